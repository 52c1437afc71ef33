/* SPDX-License-Identifier: Apache-2.0 */
/* The 2D cell walk, one ray at a time, after Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing",
 * 1987, and Musgrave, "Grid tracing", 1988. It is the plain form of the walk that the packet kernels vectorise, and
 * tests compare their bits with it.
 *
 * Invariant: each crossing is computed from the border's coordinate, so it does not depend on where the walk began.
 * Rejected: adding a constant to the last crossing, as the paper does, since errors then build up along the ray. */

#ifndef CELLWALK_SCALAR_CELL_WALK_H
#define CELLWALK_SCALAR_CELL_WALK_H

#include "moller_trumbore.h"
#include "refine.h"
#include "strict.h"
#include "watertight.h"

/* The first cell along an axis that is left at t or later. The place at t is a guess, which the crossings correct. */
static size_t first_cell(const strict_axis *a, float t, size_t cells) {
    const float last = (float)(cells - 1);
    float place = floorf(a->org + t * a->dir);
    place = max_second(0, min_second(last, place));
    if (a->dir == 0) return (size_t)(a->center - 0.5f);
    const float out = a->step > 0 ? 1 : 0, in = 1 - out, step = (float)a->step;
    const float begin = a->step > 0 ? 0 : last, end = last - begin;
    while (place != end && strict_crossing(a, place + out) < t) place += step;
    while (place != begin && strict_crossing(a, place + in) >= t) place -= step;
    return (size_t)place;
}

/* Möller and Trumbore's test of a cell on the walk. It does not use the walk's crossings and heights, so its hits
 * are limited to the cell's stretch and heights, with a little room for their rounding. Then a walk that skips a
 * cell because the ray is clear of it skips no hit. */
static inline bool mt_find(const strict_ray *r, const strict_cell *c, strict_find *find) {
    const float room = 0x1p-20f;
    const mt_range range = {max_second(c->t0 - room * fabsf(c->t0), r->t0),
                            min_second(c->t1 + room * fabsf(c->t1), r->t1),
                            strict_room_below(strict_low(c) - r->oz, r->dz, STRICT_ROOM),
                            strict_room_above(strict_high(c) - r->oz, r->dz, STRICT_ROOM)};
    cw_hit hit = {.t = 0};
    if (!mt_cell(r->start.org, r->start.dir, &range, c->i, c->j, c->h00, c->h10, c->h01, c->h11, &hit)) return false;
    *find = (strict_find){hit.t, hit.t, hit.triangle == CW_TRIANGLE_B};
    return true;
}

static inline bool cell_walk(const cw_field *f, const cw_ray *ray, cw_leaf leaf, bool any, cw_hit *hit) {
    strict_ray r;
    if (!strict_ray_init(&r, f, ray, leaf)) return false;
    const size_t cells_x = f->nx - 1, cells_y = f->ny - 1;
    size_t i = first_cell(&r.x, r.from, cells_x), j = first_cell(&r.y, r.from, cells_y);
    for (;;) { /* at most cells_x + cells_y times: each turn goes on along one axis and none turns back */
        strict_cell c;
        if (strict_gate(&c, &r, f, i, j)) {
            strict_find find;
            if (leaf == CW_LEAF_WATERTIGHT ? wt_cell(&r, &c, &find) : mt_find(&r, &c, &find)) {
                if (!any) *hit = refine_hit(&r.start, &c, &find);
                return true;
            }
        }
        const bool in_x = c.x_out <= c.y_out;
        if ((in_x ? c.x_out : c.y_out) > r.until) return false;
        if (in_x) {
            i += (size_t)(ptrdiff_t)r.x.step; /* below 0 it wraps, beyond every field */
            if (i >= cells_x) return false;
        } else {
            j += (size_t)(ptrdiff_t)r.y.step;
            if (j >= cells_y) return false;
        }
    }
}

#endif
