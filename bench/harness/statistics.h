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
    double mad; /* median of the absolute deviations from the median, not scaled */
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

typedef enum verdict { VERDICT_UNDECIDED, VERDICT_LOWER, VERDICT_HIGHER } verdict;

/* Ratio b / a of two medians, with bounds that hold with 0.95 if both intervals are sure. The verdict is about b:
 * lower or higher only if both are sure and the whole interval lies beyond 1 by more than the margin (0.02: two per
 * cent). */
typedef struct ratio {
    double value, low, high;
    verdict verdict;
} ratio;
ratio statistics_ratio(const statistics *a, const statistics *b, double margin);

#endif
