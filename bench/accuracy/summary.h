/* SPDX-License-Identifier: Apache-2.0 */
/* What the results of tradeoff come to, from their JSON lines alone. */
#ifndef CELLWALK_BENCH_ACCURACY_SUMMARY_H
#define CELLWALK_BENCH_ACCURACY_SUMMARY_H

#include "error.h"

#include <jansson.h>
#include <stdbool.h>

/* Appends a line of kind "summary" a contender: the geometric mean of its speeds, the means of its rates of wrong answers, the
 *     median of its median errors and the largest of its worst ones, all over the groups (fields × classes of rays); and
 *     whether it is on the frontiers "answers" (speed, wrong answers a million) and "place" (speed, worst height off
 *     the surface). Who has not run in all groups is "partial" and on none.
 * False if out of memory. */
bool tradeoff_summarise(json_t *lines, io_error *error);

/* Prints the contenders, fastest first, from these lines. */
void summary_print(const json_t *lines);

#endif
