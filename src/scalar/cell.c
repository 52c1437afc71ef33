/* SPDX-License-Identifier: Apache-2.0 */
/* Rays one after another: the kernel cell, and rays alone that soon fall to the ground.
 *
 * The cell walk follows Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", 1987, and Musgrave,
 * "Grid tracing", 1988. It is the plain form of the packet kernels' walk, and tests compare their bits with it.
 *
 * Invariant: each crossing is computed from the border's coordinate, so it does not depend on where the walk began.
 * Rejected: adding a constant to the last crossing, as the paper does, since errors then build up along the ray. */

#include "kernels.h"
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
    const float room = 0x1p-20f, low = strict_low(c) - r->oz, high = strict_high(c) - r->oz;
    const mt_range range = {max_second(c->t0 - room * fabsf(c->t0), r->t0),
                            min_second(c->t1 + room * fabsf(c->t1), r->t1), low - strict_room(low, r->dz, STRICT_ROOM),
                            high + strict_room(high, r->dz, STRICT_ROOM)};
    cw_hit hit = {.t = 0};
    if (!mt_cell(r->start.org, r->start.dir, &range, c->i, c->j, c->h00, c->h10, c->h01, c->h11, &hit)) return false;
    *find = (strict_find){hit.t, hit.t, hit.triangle == CW_TRIANGLE_B};
    return true;
}

typedef enum walk_end { WALK_MISSES, WALK_FINDS, WALK_GOES_ON } walk_end;

/* From the first cell on, at most so many cells, 0 for all. c is the cell of a find. */
static inline __attribute__((always_inline)) walk_end walk_cells(const cw_field *f, const strict_ray *r, int most,
                                                                 cw_leaf leaf, strict_cell *c, strict_find *find) {
    size_t i = first_cell(&r->x, r->from, f->nx - 1), j = first_cell(&r->y, r->from, f->ny - 1);
    for (int k = 0; most == 0 || k < most; k += most != 0) { /* at most nx + ny turns: none goes back on an axis */
        if (strict_gate(c, r, f, i, j) && (leaf == CW_LEAF_WATERTIGHT ? wt_cell(r, c, find) : mt_find(r, c, find)))
            return WALK_FINDS;
        const bool in_x = c->x_out <= c->y_out;
        if ((in_x ? c->x_out : c->y_out) > r->until) return WALK_MISSES;
        if (in_x) {
            i += (size_t)(ptrdiff_t)r->x.step; /* below 0 it wraps, beyond every field */
            if (i >= f->nx - 1) return WALK_MISSES;
        } else {
            j += (size_t)(ptrdiff_t)r->y.step;
            if (j >= f->ny - 1) return WALK_MISSES;
        }
    }
    return WALK_GOES_ON;
}

/* ---- the kernel cell --------------------------------------------------------------------------------------------- */

/* most: cells of each ray, 0 for all; false if one goes on. */
static inline __attribute__((always_inline)) bool trace_cells(const cw_field *f, const cw_ray *rays, size_t n,
                                                              cw_leaf leaf, int most, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        strict_ray r;
        strict_cell c;
        strict_find find;
        walk_end end = WALK_MISSES;
        if (strict_ray_init(&r, f, &rays[k], leaf)) end = walk_cells(f, &r, most, leaf, &c, &find);
        if (end == WALK_GOES_ON) return false;
        if (hits == NULL)
            occluded[k] = end == WALK_FINDS;
        else if (end == WALK_FINDS)
            hits[k] = refine_hit(f, &r.start, c.i, c.j, &find);
        else
            hits[k] = miss();
    }
    return true;
}
static void trace_mt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_MOLLER_TRUMBORE, 0, hits, occluded);
}
static void trace_wt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_WATERTIGHT, 0, hits, occluded);
}

bool cw_cell_few(const cw_field *f, const cw_ray *ray, int most, cw_hit *hit, uint8_t *occluded) {
    return trace_cells(f, ray, 1, CW_LEAF_WATERTIGHT, most, hit, occluded);
}

const cw_kernel_code cw_cell = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_mt, [CW_LEAF_WATERTIGHT] = trace_wt}};
