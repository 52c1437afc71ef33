/* SPDX-License-Identifier: Apache-2.0 */
/* The time stamp counter, and the CPU that a measurement stays on. */
#ifndef CELLWALK_BENCH_HARNESS_TIMING_H
#define CELLWALK_BENCH_HARNESS_TIMING_H

#include <stdint.h>

/* The time stamp counter: it runs at a fixed rate whatever the core's clock does, so its "cycles" are units of time and
 * not cycles that the core has spent. 0 where there is none. */
static inline uint64_t timing_ticks(void) {
#if defined(__x86_64__) || defined(__i386__)
    return __builtin_ia32_rdtsc();
#else
    return 0;
#endif
}

/* Ticks a second, measured against the clock for 20 ms; 0 where there is no counter. */
double timing_tick_rate(void);

/* Keeps the calling thread on one CPU: cpu, or with -1 the one that it is on. The CPU, or -1 if that failed. */
int timing_pin(int cpu);

#endif
