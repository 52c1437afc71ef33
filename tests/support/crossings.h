/* SPDX-License-Identifier: Apache-2.0 */
/* Which edges of a field a line may cross. */
#ifndef CELLWALK_TESTS_CROSSINGS_H
#define CELLWALK_TESTS_CROSSINGS_H

#include <math.h>
#include <stddef.h>

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

#endif
