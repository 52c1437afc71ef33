/* SPDX-License-Identifier: Apache-2.0 */
/* Statistics of a handful of timings: robust location and spread, and the location's confidence interval. */
#ifndef CELLWALK_BENCH_HARNESS_STATISTICS_H
#define CELLWALK_BENCH_HARNESS_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>

/* Two medians whose intervals both hold with 0.975 bound their ratio with at least 0.95 (Bonferroni). */
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

#endif
