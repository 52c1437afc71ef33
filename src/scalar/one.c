/* SPDX-License-Identifier: Apache-2.0 */
/* One ray, for calls of few rays: made ready, and from cell to cell if it soon falls to the ground. Else it walks over the pyramid, 16
 * children of a node at once (simd/one_kernel.c). */

#include "one.h"

#include "kernels.h"
#include "refine.h"
#include "watertight.h"

/* Rays that seem to fall to the ground within ONE_CELLS cells take so many first, whatever their nodes. Others that begin less than ONE_LOW
 * above it begin their walk at their block: measured (papers/walks.md). */
enum { ONE_CELLS = 8, ONE_LOW = 8 };

/* Number of the cell at t along an axis, or of an earlier one, within the field. See first_corner in simd/lane_rays.h. */
static inline int32_t cell_at(const strict_axis *a, float t, size_t samples) {
    const float sign = (float)a->step, org = sign * a->org, early = org - 0x1p-21f * (fabsf(org) + (float)samples);
    const float place = max_second(min_second(early + t * (sign * a->dir), sign * a->last - 0.5f), sign * a->first);
    int32_t at = (int32_t)place;
    at -= place < (float)at;
    return at ^ (a->step >> 1);
}

static inline void find_hit(const cw_field *f, const strict_ray *r, const one_find *found, cw_hit *hit) {
    const float *row = f->z + (size_t)found->j * f->stride + (size_t)found->i;
    const strict_cell c = {.i = (size_t)found->i,
                           .j = (size_t)found->j,
                           .h00 = row[0],
                           .h10 = row[1],
                           .h01 = row[f->stride],
                           .h11 = row[f->stride + 1]};
    *hit = refine_hit(&r->start, &c, &(strict_find){found->t0, found->t1, found->b});
}

/* From cell (i, j) on, at most ONE_CELLS cells; (*i, *j) is then the next one. */
static inline cw_one_end few_cells(const cw_field *f, const strict_ray *r, int32_t *i, int32_t *j, one_find *found) {
    for (int k = 0; k < ONE_CELLS; k++) {
        strict_cell c;
        strict_find find;
        if (strict_gate(&c, r, f, (size_t)*i, (size_t)*j) && wt_cell(r, &c, &find)) {
            *found = (one_find){*i, *j, find.t0, find.t1, find.b};
            return CW_ONE_FOUND;
        }
        const bool in_x = c.x_out <= c.y_out;
        if ((in_x ? c.x_out : c.y_out) > r->until) return CW_ONE_MISSES;
        if (in_x) {
            *i += r->x.step;
            if ((size_t)*i >= f->nx - 1) return CW_ONE_MISSES; /* below 0 too */
        } else {
            *j += r->y.step;
            if ((size_t)*j >= f->ny - 1) return CW_ONE_MISSES;
        }
    }
    return CW_ONE_LONG;
}

static __attribute__((noinline)) cw_one_end one_walk(const cw_field *f, const strict_ray *r, cw_one_fn *wide,
                                                     cw_hit *hit) {
    int32_t i = cell_at(&r->x, r->from, f->nx), j = cell_at(&r->y, r->from, f->ny);
    const float height = r->from * r->dz - (f->z[(size_t)j * f->stride + (size_t)i] - r->oz);
    const float speed = fabsf(r->x.dir) + fabsf(r->y.dir);
    one_find found;
    cw_one_end end = CW_ONE_LONG;
    if (height >= 0 && height * speed <= ONE_CELLS * -r->dz) end = few_cells(f, r, &i, &j, &found);
    if (end == CW_ONE_LONG && wide) end = wide(f, r, i, j, fabsf(height) <= ONE_LOW, &found);
    if (end == CW_ONE_FOUND && hit) find_hit(f, r, &found, hit);
    return end;
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
        cw_one_end end = CW_ONE_MISSES;
        if (!is_past(f, &rays[k]) && strict_ray_init(&r, f, &rays[k], CW_LEAF_WATERTIGHT))
            end = one_walk(f, &r, wide, hits ? &hits[k] : NULL);
        if (end == CW_ONE_LONG) return false;
        if (hits == NULL) {
            occluded[k] = end == CW_ONE_FOUND;
        } else if (end == CW_ONE_MISSES) { /* not by miss(), which compilers make elsewhere and copy */
            hits[k].t = INFINITY;
            hits[k].i = hits[k].j = -1;
            hits[k].triangle = 0;
            hits[k].u = hits[k].v = 0;
        }
    }
    return true;
}
