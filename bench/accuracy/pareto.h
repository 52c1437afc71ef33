/* SPDX-License-Identifier: Apache-2.0 */
/* The Pareto frontier of speed and error: who is beaten by nobody in both. */
#ifndef CELLWALK_BENCH_ACCURACY_PARETO_H
#define CELLWALK_BENCH_ACCURACY_PARETO_H

#include <stdbool.h>
#include <stddef.h>

/* A point whose speed is not above 0, whose error is below 0, or with a NaN, is not a point and never on the frontier. */
typedef struct tradeoff_point {
    double speed, error;
    bool frontier; /* set by tradeoff_pareto */
} tradeoff_point;

/* Marks the frontier, beginning at the fastest of those with the least error: each next one has the least error among those
 * that are faster by more than margin (0.02: two per cent, so that noise is no step; 0: the plain frontier), and is the
 * fastest with that error; the first of equals. Writes the numbers of its points to order, which has room for count, in
 * that order, and returns how many there are. */
size_t tradeoff_pareto(tradeoff_point *points, size_t count, double margin, size_t *order);

#endif
