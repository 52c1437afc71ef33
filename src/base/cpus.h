/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BASE_CPUS_H
#define CELLWALK_BASE_CPUS_H

#include "linux.h"

#include <sched.h>
#ifdef _WIN32
#include <pthread.h>
#else
#include <unistd.h>
#endif

/* More than that nobody has a use for. */
enum { CPUS_MAX = 4096 };

/* CPUs that the calling thread may run on, fewer than the machine has where somebody limits it; at least 1. */
static inline unsigned cpus_usable(void) {
#ifdef _WIN32
    long count = pthread_num_processors_np();
#else
    long count = sysconf(_SC_NPROCESSORS_ONLN);
#endif
#if CELLWALK_LINUX
    cpu_set_t set; /* fails where there are more CPUs than it has room for */
    if (sched_getaffinity(0, sizeof set, &set) == 0) count = CPU_COUNT(&set);
#endif
    return count < 1 ? 1 : count > CPUS_MAX ? CPUS_MAX : (unsigned)count;
}

#endif
