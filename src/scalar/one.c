/* SPDX-License-Identifier: Apache-2.0 */
/* One ray over the pyramid of slabs, for calls of few rays: the lane walk (simd/lane_walk.h) in plain C, with branches in place of masks,
 * and nothing queued or copied. It begins at the block of 4 × 4 cells in which the ray begins, or at its cell if the ray soon falls to the
 * ground. At first it goes up wherever the ray is clear of a node. Invariants, mirrored axes and places of children are the lane walk's. */

#include "cell_walk.h"
#include "kernels.h"
#include "pyramid.h"

/* Rays that take ONE_STEPS run beside a surface, which the close walk of the pyramid kernels is made for. */
enum { ONE_STEPS = 96, ONE_CELLS = 8 };

/* An axis along which the ray goes up: a strict_axis, mirrored if it goes down. */
typedef struct one_axis {
    float org, early, dir, center, inverse, first, last;
    int32_t turned; /* -1 if mirrored */
} one_axis;

static inline one_axis mirror(const strict_axis *a, size_t samples) {
    const float sign = (float)a->step, org = sign * a->org, early = org - 0x1p-21f * (fabsf(org) + (float)samples);
    return (one_axis){org,
                      early,
                      sign * a->dir,
                      sign * a->center,
                      fabsf(a->inverse),
                      sign * a->first,
                      sign * a->last,
                      a->step > 0 ? 0 : -1};
}

/* What slabs have no room for: see mirror_packet in simd/lane_rays.h. */
static inline float pad_of(const strict_ray *r, const cw_field *f) {
    const float size = (float)(f->nx + f->ny), origin = fabsf(r->x.org) + fabsf(r->y.org);
    const float tallest = max_second(fabsf(f->low), fabsf(f->high)), steepest = f->pyramid->steepest;
    const float heights = 2 * (fabsf(r->oz) + tallest) + steepest * max_second(0, origin - size);
    const float lengths = (origin + size) + (fabsf(r->x.dir) + fabsf(r->y.dir));
    const float largest = (heights + fabsf(r->dz)) + steepest * lengths;
    const float least = (1 + max_second(fabsf(r->from), fabsf(r->until))) + 0x1p-14f * largest;
    return largest <= 0x1p120f ? SLAB_ROUNDING * heights + FLT_MIN * least : INFINITY;
}

/* The place at t along an axis, or an earlier one, within the field. */
static inline float place_at(const one_axis *a, float t) {
    return max_second(min_second(a->early + t * a->dir, a->last - 0.5f), a->first);
}

/* Clears *ended if the ray takes too long. True if it hits. Not inlined: so compilers see that it starts from a ray that is made. */
static __attribute__((noinline)) bool one_walk(const cw_field *f, const strict_ray *r, bool any, bool *ended,
                                               cw_hit *hit) {
    const struct cw_pyramid *p = f->pyramid;
    const one_axis a[2] = {mirror(&r->x, f->nx), mirror(&r->y, f->ny)};
    const float pad = pad_of(r, f);
    float t = r->from, leave = INFINITY; /* the rest of the node's parent is skipped from leave on */
    int32_t at[2];                       /* low corner, mirrored */
    for (int c = 0; c < 2; c++) {
        const float place = place_at(&a[c], t);
        at[c] = (int32_t)place;
        at[c] -= place < (float)at[c];
    }
    /* A ray that soon falls to the height of its cell's first sample takes the first cells whatever their blocks. */
    const float *first = f->z + (size_t)(at[1] ^ a[1].turned) * f->stride + (at[0] ^ a[0].turned);
    const float height = t * r->dz - (*first - r->oz);
    const bool falls = height >= 0 && height * (a[0].dir + a[1].dir) <= ONE_CELLS * -r->dz;
    const int flat = falls ? ONE_CELLS : 0;
    int level = falls ? 0 : 1; /* 0: cells */
    bool rising = true;
    if (!falls) at[0] &= -4, at[1] &= -4;
    for (int steps = 0; steps < ONE_STEPS; steps++) {
        const int shift = 2 * level;
        const int32_t size = (int32_t)1 << shift, parent = -4 * size, border[2] = {at[0] + size, at[1] + size};
        const float out[2] = {((float)border[0] - a[0].center) * a[0].inverse,
                              ((float)border[1] - a[1].center) * a[1].inverse};
        const int k = !(out[0] <= out[1]); /* the axis along which it leaves the node */
        const int32_t i = at[0] ^ a[0].turned, j = at[1] ^ a[1].turned;
        bool rises = false;
        if (level == 0) {
            strict_cell c;
            strict_find find;
            if (strict_gate(&c, r, f, (size_t)i, (size_t)j) && wt_cell(r, &c, &find)) {
                if (!any) *hit = refine_hit(&r->start, &c, &find);
                return true;
            }
        } else if (t <= leave) {
            const int32_t across = (((int32_t)f->nx - 2) >> shift) + 1;
            const cw_pyramid_slab *s = &p->slab[p->first[level] + (j >> shift) * across + (i >> shift)];
            const float half = 0.5f * (float)size, low = s->low - pad, high = s->high + pad;
            const float slope[2] = {a[0].turned ? -s->slope_x : s->slope_x, a[1].turned ? -s->slope_y : s->slope_y};
            const float origin =
                (r->oz - slope[0] * (a[0].org - ((float)at[0] + half))) - slope[1] * (a[1].org - ((float)at[1] + half));
            const float rate = (r->dz - slope[0] * a[0].dir) - slope[1] * a[1].dir;
            const float t1 = min_second(out[k], r->until), d0 = t * rate + origin, d1 = t1 * rate + origin;
            if (t <= t1 && !(min_second(d0, d1) > high || max_second(d0, d1) < low)) {
                const float per = 1 / max_second(FLT_MIN, fabsf(rate));
                const float before = max_second(0, max_second(d0 - high, low - d0));
                const float after = max_second(0, max_second(d1 - high, low - d1));
                t = min_second(max_second(before * per + t, t), t1);
                leave = max_second(t, min_second(t1 - after * per, INFINITY));
                for (int c = 0; c < 2; c++) {
                    const float child = (place_at(&a[c], t) - (float)at[c]) * (4 / (float)size);
                    at[c] += (int32_t)max_second(min_second(child, 3), 0) << (shift - 2);
                }
                level--;
                rising = false;
                continue;
            }
            rises = rising && level < p->levels;
        } else {
            leave = INFINITY;
        }
        if (!rises) {
            if (out[k] > r->until || (float)border[k] >= a[k].last) return false;
            t = max_second(t, out[k]);
            const bool elsewhere = ((at[k] ^ border[k]) & parent) != 0 && steps >= flat;
            rises = elsewhere || t > leave;
            if (rises) leave = elsewhere ? INFINITY : -INFINITY;
            at[k] = border[k];
        }
        if (rises) {
            at[0] &= parent;
            at[1] &= parent;
            level++;
        }
    }
    *ended = false;
    return false;
}

/* Above everything and not falling: the gate would fail at every t. */
static inline bool is_above(const cw_field *f, const cw_ray *ray) {
    return ray->org[2] > f->high && ray->dir[2] >= 0 && ray->tmin >= 0 && !ray_is_far(f, ray->org);
}

bool cw_one(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    bool ended = true;
    for (size_t k = 0; k < n && ended; k++) {
        strict_ray r;
        cw_hit hit = miss();
        const bool may = !is_above(f, &rays[k]) && strict_ray_init(&r, f, &rays[k], CW_LEAF_WATERTIGHT);
        const bool found = may && one_walk(f, &r, hits == NULL, &ended, &hit);
        if (hits == NULL)
            occluded[k] = found;
        else
            hits[k] = hit;
    }
    return ended;
}
