/* SPDX-License-Identifier: Apache-2.0 */
/* Times jobs against each other in rounds, each in another random order, so that changes of the machine (clock,
 * other programs, temperature) affect all of them alike. */
#ifndef CELLWALK_BENCH_HARNESS_INTERLEAVE_H
#define CELLWALK_BENCH_HARNESS_INTERLEAVE_H

#include "harness/statistics.h"

#include <stdint.h>

enum { INTERLEAVE_SAMPLES_MAX = 1000 };

typedef struct interleave_limits {
    double width;       /* stop a job when its median's confidence interval, over the median, is at most this */
    double seconds;     /* stop all when this time is over, but not before least samples of each */
    size_t least, most; /* samples a job; most <= INTERLEAVE_SAMPLES_MAX */
    uint32_t seed;      /* of the order */
} interleave_limits;

typedef struct interleave_job {
    void (*run)(void *context);
    void *context;
    /* The clock: CPU time of the process for a run of one thread, wall-clock time for one of several. */
    bool by_clock;
    /* Results for a run: seconds, and the ticks that the time stamp counter made in that time. */
    statistics seconds, ticks;
    double cpu_share; /* CPU time over the clock's time, all runs together: below the number of threads where other
                       * programs got between */
    bool converged;
} interleave_job;

/* Jobs should have run once before, so that caches and pages are warm. A job of which one run takes more than twice
 * its share of the time is run once, even if least is greater. */
void interleave(interleave_job **jobs, size_t count, const interleave_limits *limits);

#endif
