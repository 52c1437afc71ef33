/* SPDX-License-Identifier: Apache-2.0 */
/* Times jobs against each other in rounds, each in another random order, so that changes of the machine (clock,
 * other programs, temperature) affect all of them alike. */
#ifndef CELLWALK_BENCH_HARNESS_INTERLEAVE_H
#define CELLWALK_BENCH_HARNESS_INTERLEAVE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- statistics of a handful of timings ---- */

/* Stricter than 0.95, since interleave() looks after each round and stops at the first that is narrow. */
#define STATISTICS_CONFIDENCE 0.975

typedef struct statistics {
    size_t n;
    double min, median;
    /* Confidence interval of the median from order statistics: for any distribution, the number of samples below the
     * median is binomial with p = 1/2. With fewer than 7 samples even [smallest, largest] covers less than
     * STATISTICS_CONFIDENCE: sure is false, and low and high are those two. */
    double low, high;
    bool sure;
} statistics;

/* Sorts samples. n = 0 gives all zero. */
statistics statistics_of(double *samples, size_t n);

/* Number of samples to drop at either end, so that the rest covers the median with at least confidence; the largest
 * such number. -1 if not even all samples do. */
int statistics_interval_rank(size_t n, double confidence);

/* ---- rounds ---- */

/* Passes below which no interval covers a median with STATISTICS_CONFIDENCE; passes at most. */
enum { INTERLEAVE_LEAST = 7, INTERLEAVE_MOST = 400 };

typedef struct interleave_job {
    void (*run)(void *context);
    void *context;
    /* The clock: CPU time of the process for a run of one thread, wall-clock time for one of several. */
    bool by_clock;
    const char *group; /* of jobs of one group, NULL being none, the fastest counts: the others need not converge, and
                           those that are clearly slower end after a few rounds */
    const double *counts; /* NULL, or where run leaves the seconds that count instead */
    /* Results. times[k]: of round k, in seconds of a run; runs: of a round, more of a short job than of a long one. */
    unsigned runs;
    double times[INTERLEAVE_MOST];
    statistics seconds;
    bool ended;     /* takes no part in later rounds */
    bool best;      /* of its group */
    bool converged; /* its ratio to the first job has a narrow interval; the first job: it had enough passes */
} interleave_job;

typedef struct interleave_limits {
    double width;   /* of an interval, over its middle */
    double seconds; /* no round begins later */
    uint32_t seed;  /* of the order */
} interleave_limits;

/* Jobs should have run once before, so that caches and pages are warm. Ends when all that count have converged. */
void interleave(interleave_job **jobs, size_t count, const interleave_limits *limits);

/* How many times as long as b job a takes: the median of the rounds' ratios, which the machine's changes from round to
 * round do not enter, with its interval. */
statistics interleave_ratio(const interleave_job *a, const interleave_job *b);

#endif
