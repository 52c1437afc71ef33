/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/statistics.h"

#include <math.h>
#include <stdlib.h>

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double middle(const double *sorted, size_t n) {
    return n % 2 ? sorted[n / 2] : 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]);
}

int statistics_interval_rank(size_t n, double confidence) {
    /* [x(k), x(n - 1 - k)] misses the median if at most k samples lie on one side of it. */
    double tail = 0, term = pow(0.5, (double)n); /* n choose k, over 2^n */
    int k = 0;
    while ((size_t)k <= n / 2) {
        tail += term;
        if (1 - 2 * tail < confidence) break;
        term *= (double)(n - (size_t)k) / (double)(k + 1);
        k++;
    }
    return k - 1;
}

statistics statistics_of(double *samples, size_t n) {
    if (n == 0) return (statistics){0};
    qsort(samples, n, sizeof *samples, compare_doubles);
    statistics s = {.n = n, .min = samples[0], .median = middle(samples, n)};
    const int rank = statistics_interval_rank(n, STATISTICS_CONFIDENCE);
    const size_t drop = rank < 0 ? 0 : (size_t)rank;
    s.sure = rank >= 0;
    s.low = samples[drop];
    s.high = samples[n - 1 - drop];
    return s;
}
