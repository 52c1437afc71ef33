/* SPDX-License-Identifier: Apache-2.0 */
/* Clocks, in seconds. */
#ifndef CELLWALK_BASE_CLOCK_H
#define CELLWALK_BASE_CLOCK_H

#include <stdint.h>
#include <time.h>

static inline double clock_read(clockid_t which) {
    struct timespec t;
    clock_gettime(which, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A clock that nobody sets. */
static inline double clock_seconds(void) { return clock_read(CLOCK_MONOTONIC); }

/* CPU time of the process. For the work of one thread it is the elapsed time without the time that the system gave
 * to other programs. */
static inline double clock_cpu_seconds(void) { return clock_read(CLOCK_PROCESS_CPUTIME_ID); }

#endif
