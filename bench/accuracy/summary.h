/* SPDX-License-Identifier: Apache-2.0 */
/* What the results of tradeoff come to, from their JSON lines alone. */
#ifndef CELLWALK_BENCH_ACCURACY_SUMMARY_H
#define CELLWALK_BENCH_ACCURACY_SUMMARY_H

#include "error.h"

#include <jansson.h>
#include <stdbool.h>

/* Appends a line of kind "summary" a contender: the geometric mean of its speeds, the means of its rates of wrong answers, the
 * median of its median errors and the largest of its worst ones, all over the groups (fields × classes of rays); and
 * whether it is on the frontiers "answers" (speed, wrong answers a million) and "place" (speed, worst height off
 * the surface). Who has not run in all groups is "partial" and on none. */
bool summary_add(json_t *lines, io_error *error);

/* Prints the contenders, fastest first, from these lines. */
void summary_print(const json_t *lines);

/* A point whose speed is not above 0, whose error is below 0, or with a NaN, is not a point and never on the frontier. */
typedef struct pareto_point {
    double speed, error;
    bool frontier; /* set by summary_pareto */
} pareto_point;

/* Marks the Pareto frontier, beginning at the fastest of those with the least error: each next one has the least error among
 * those that are faster by more than margin (0.02: two per cent, so that noise is no step; 0: the plain frontier), and is the
 * fastest with that error; the first of equals. Writes the numbers of its points to order, which has room for count, in
 * that order, and returns how many there are. */
size_t summary_pareto(pareto_point *points, size_t count, double margin, size_t *order);

#endif
