/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BASE_CPUS_H
#define CELLWALK_BASE_CPUS_H

#include <sched.h>

/* CPUs that the calling thread may run on, which are fewer than the machine has where somebody limits it; at least 1. */
static inline unsigned cpus_usable(void) {
    cpu_set_t set;
    return sched_getaffinity(0, sizeof set, &set) == 0 ? (unsigned)CPU_COUNT(&set) : 1;
}

#endif
