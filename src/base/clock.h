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

/* Time that the process has had a CPU for. One thread's work takes as much of it as of the clock's time, except that what
 * the system gave to other programs meanwhile does not count. */
static inline double clock_cpu_seconds(void) { return clock_read(CLOCK_PROCESS_CPUTIME_ID); }

/* The time stamp counter: it runs at a fixed rate whatever the core's clock does, so its "cycles" are units of time and
 * not cycles that the core has spent. 0 where there is none. */
static inline uint64_t clock_ticks(void) {
#if defined(__x86_64__) || defined(__i386__)
    return __builtin_ia32_rdtsc();
#else
    return 0;
#endif
}

#endif
