/* SPDX-License-Identifier: Apache-2.0 */
/* Kernels beside the plain walk from cell to cell. */
#ifndef CELLWALK_TESTS_AS_CELL_H
#define CELLWALK_TESTS_AS_CELL_H

#include "cellwalk.h"

typedef struct as_cell_counts {
    size_t rays, hits, kernels; /* kernels: of all calls together */
} as_cell_counts;

/* Traces rays with the run's kernel and leaf test, for the closest hit and for any. Returns how many answers differ in a bit from
 * those expected, of which the first is printed. */
size_t as_cell_differ(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, const cw_hit *expected);

/* Traces rays with cell and each pyramid kernel that this machine runs, for the closest hit and for any. Fails with the ray if
 * an answer differs in a bit. Adds to the counts. */
void as_cell_check(cw_field *field, const cw_ray *rays, size_t n, as_cell_counts *counts);

#endif
