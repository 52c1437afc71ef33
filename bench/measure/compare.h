/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_MEASURE_COMPARE_H
#define CELLWALK_BENCH_MEASURE_COMPARE_H

#include "error.h"

#include <stddef.h>

/* How many comparisons came out which way. */
typedef struct compare_counts {
    size_t faster, slower, undecided, unmatched;
    size_t controls; /* compared too, without a verdict */
} compare_counts;

/* Prints a line for each result that both files have; fails if there is none. margin: see statistics_ratio. */
bool compare_files(const char *path_a, const char *path_b, double margin, compare_counts *counts, io_error *error);

#endif
