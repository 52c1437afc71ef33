/* SPDX-License-Identifier: Apache-2.0 */
/* Rays one after another: the kernel cell, and calls of few rays, over the pyramid if they go far (simd/one_kernel.c).
 *
 * The cell walk follows Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", 1987, and Musgrave, "Grid
 * tracing", 1988. It is the plain form of the walk that the packet kernels vectorise, and tests compare their bits with it.
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

typedef enum walk_end { WALK_MISSES, WALK_FINDS, WALK_GOES_ON } walk_end;

/* From cell (i, j) on, at most so many cells, 0 for all; (*i, *j) is then the next one. c is the cell of a find. */
static inline __attribute__((always_inline)) walk_end walk_cells(const cw_field *f, const strict_ray *r, size_t *i,
                                                                 size_t *j, int most, cw_leaf leaf, strict_cell *c,
                                                                 strict_find *find) {
    for (int k = 0; most == 0 || k < most; k += most != 0) { /* at most nx + ny turns: none goes back on an axis */
        if (strict_gate(c, r, f, *i, *j) && (leaf == CW_LEAF_WATERTIGHT ? wt_cell(r, c, find) : mt_find(r, c, find)))
            return WALK_FINDS;
        const bool in_x = c->x_out <= c->y_out;
        if ((in_x ? c->x_out : c->y_out) > r->until) return WALK_MISSES;
        if (in_x) {
            *i += (size_t)(ptrdiff_t)r->x.step; /* below 0 it wraps, beyond every field */
            if (*i >= f->nx - 1) return WALK_MISSES;
        } else {
            *j += (size_t)(ptrdiff_t)r->y.step;
            if (*j >= f->ny - 1) return WALK_MISSES;
        }
    }
    return WALK_GOES_ON;
}

/* ---- the kernel cell --------------------------------------------------------------------------------------------- */

static inline void trace_cells(const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, cw_hit *hits,
                               uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        strict_ray r;
        strict_cell c;
        strict_find find;
        bool found = strict_ray_init(&r, f, &rays[k], leaf);
        if (found) {
            size_t i = first_cell(&r.x, r.from, f->nx - 1), j = first_cell(&r.y, r.from, f->ny - 1);
            found = walk_cells(f, &r, &i, &j, 0, leaf, &c, &find) == WALK_FINDS;
        }
        if (hits == NULL)
            occluded[k] = found;
        else if (found)
            hits[k] = refine_hit(&r.start, &c, &find);
        else
            hits[k] = miss();
    }
}
static void trace_mt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_MOLLER_TRUMBORE, hits, occluded);
}
static void trace_wt(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    trace_cells(f, rays, n, CW_LEAF_WATERTIGHT, hits, occluded);
}

const cw_kernel_code cw_cell = {.trace = {[CW_LEAF_MOLLER_TRUMBORE] = trace_mt, [CW_LEAF_WATERTIGHT] = trace_wt}};

/* ---- few rays ---------------------------------------------------------------------------------------------------- */

/* Rays that seem to fall to the ground within ONE_CELLS cells take so many first, whatever their nodes. Others that begin less than ONE_LOW
 * above it begin their walk at their block: measured (papers/walks.md). */
enum { ONE_CELLS = 8, ONE_LOW = 8 };

/* Number of the cell at t along an axis, or of an earlier one, within the field. See first_corner in simd/lane_rays.h. */
static inline size_t cell_at(const strict_axis *a, float t, size_t samples) {
    const float sign = (float)a->step, org = sign * a->org, early = org - 0x1p-21f * (fabsf(org) + (float)samples);
    const float place = max_second(min_second(early + t * (sign * a->dir), sign * a->last - 0.5f), sign * a->first);
    int32_t at = (int32_t)place;
    at -= place < (float)at;
    return (size_t)(at ^ (a->step >> 1));
}

static inline void find_hit(const cw_field *f, const strict_ray *r, const cw_one_find *found, cw_hit *hit) {
    const float *row = f->z + (size_t)found->j * f->stride + (size_t)found->i;
    const strict_cell c = {.i = (size_t)found->i,
                           .j = (size_t)found->j,
                           .h00 = row[0],
                           .h10 = row[1],
                           .h01 = row[f->stride],
                           .h11 = row[f->stride + 1]};
    *hit = refine_hit(&r->start, &c, &(strict_find){found->t0, found->t1, found->b});
}

static __attribute__((noinline)) walk_end one_walk(const cw_field *f, const strict_ray *r, cw_one_fn *wide,
                                                   cw_hit *hit) {
    size_t i = cell_at(&r->x, r->from, f->nx), j = cell_at(&r->y, r->from, f->ny);
    const float height = r->from * r->dz - (f->z[j * f->stride + i] - r->oz);
    const float speed = fabsf(r->x.dir) + fabsf(r->y.dir);
    if (height >= 0 && height * speed <= ONE_CELLS * -r->dz) {
        strict_cell c;
        strict_find find;
        const walk_end end = walk_cells(f, r, &i, &j, ONE_CELLS, CW_LEAF_WATERTIGHT, &c, &find);
        if (end == WALK_FINDS && hit) *hit = refine_hit(&r->start, &c, &find);
        if (end != WALK_GOES_ON) return end;
    }
    if (wide == NULL) return WALK_GOES_ON;
    cw_one_find found;
    if (!wide(f, r, (int32_t)i, (int32_t)j, fabsf(height) <= ONE_LOW, &found)) return WALK_MISSES;
    if (hit) find_hit(f, r, &found, hit);
    return WALK_FINDS;
}

/* A cell or more beside the field, or above all of it, and going no nearer: whatever follows would find a miss. So far away no product or
 * quotient is so small that it would be 0. */
static inline bool is_past(const cw_field *f, const cw_ray *ray) {
    const float *o = ray->org, *d = ray->dir;
    const float x = o[0] - f->middle[0], y = o[1] - f->middle[1];
    const bool beside_x = fabsf(x) > f->middle[0] + 2, beside_y = fabsf(y) > f->middle[1] + 2, above = o[2] > f->high;
    if (!(beside_x | beside_y | above)) return false;
    const bool past = (beside_x & (x * d[0] >= 0)) | (beside_y & (y * d[1] >= 0)) | (above & (d[2] >= 0));
    return past && ray->tmin >= 0 && !ray_is_far(f, o);
}

bool cw_one(const cw_field *f, cw_one_fn *wide, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        strict_ray r;
        walk_end end = WALK_MISSES;
        if (!is_past(f, &rays[k]) && strict_ray_init(&r, f, &rays[k], CW_LEAF_WATERTIGHT))
            end = one_walk(f, &r, wide, hits ? &hits[k] : NULL);
        if (end == WALK_GOES_ON) return false;
        if (hits == NULL) {
            occluded[k] = end == WALK_FINDS;
        } else if (end == WALK_MISSES) { /* not by miss(), which compilers make elsewhere and copy */
            hits[k].t = INFINITY;
            hits[k].i = hits[k].j = -1;
            hits[k].triangle = 0;
            hits[k].u = hits[k].v = 0;
        }
    }
    return true;
}
