/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BASE_CPUS_H
#define CELLWALK_BASE_CPUS_H

#include <sched.h>
#include <unistd.h>

/* More than that nobody has a use for. */
enum { CPUS_MAX = 4096 };

/* CPUs that the calling thread may run on, which are fewer than the machine has where somebody limits it; at least 1. */
static inline unsigned cpus_usable(void) {
    cpu_set_t set;
    long count;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        count = CPU_COUNT(&set);
    else /* more CPUs than the set has room for */
        count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1 : count > CPUS_MAX ? CPUS_MAX : (unsigned)count;
}

#endif
