/* SPDX-License-Identifier: Apache-2.0 */
/* Looks at every edge of a field that a line may cross, one by one and in double. */
#ifndef CELLWALK_TESTS_CROSSINGS_H
#define CELLWALK_TESTS_CROSSINGS_H

#include "fields.h"

#include <math.h>

/* The columns of a row whose edges the line may cross. An edge from sample (x, y) leads at most one column right and one row down. So
 * the line, from start along dir, crosses none of a column farther from where it crosses row y than that, and than it goes in a row; a
 * cell more is for rounding. Narrows [from, until). */
static inline void columns_near_line(const double start[2], const double dir[2], size_t y, size_t *from,
                                     size_t *until) {
    const double slope = dir[0] / dir[1], room = 2 + fabs(slope), x = start[0] + slope * ((double)y - start[1]);
    if (!(room < 1e6)) return;
    *from = (size_t)fmin(fmax(x - room, 0), (double)*until);
    *until = (size_t)fmin(fmax(x + room, 0), (double)*until);
}

/* Where a line crosses an edge or meets a sample. */
typedef struct crossing {
    double t, slope; /* from its start; NaN: a hole is at the edge */
    double steep;    /* the larger of the slopes, without sign, to the edge's samples */
} crossing;

enum { CROSSINGS_MAX = 4096 };

/* Those of a line in the field from start along dir, on an earth that sinks by drop t²; by distance. Returns how many. */
size_t crossings_find(const test_field *f, const double start[3], const double dir[2], double drop,
                      crossing to[CROSSINGS_MAX]);

/* Direction number n: of the compass, exactly and nearly, whole numbers of cells, and then any. */
void line_direction(random_state *r, size_t n, double dir[2]);

#endif
