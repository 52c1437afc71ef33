/* SPDX-License-Identifier: Apache-2.0 */
/* Rays made ready for a walk, by the rules of src/scalar/ray.h and strict.h, operation by operation. */
#ifndef CELLWALK_SIMD_VECTOR_RAYS_H
#define CELLWALK_SIMD_VECTOR_RAYS_H

#include "../src/scalar/strict.h"
#include "field.h"
#include "vector_cells.h"

#include <float.h>

/* W rays as they are traced; see ray_start. */
typedef struct vstart {
    vfloat org[3], dir[3];
    vfloat inverse[3]; /* 1 / dir; set for move_rays alone */
    vfloat tmin, tmax;
    /* Set only if a ray has been moved: */
    vfloat first, last; /* the caller's tmin and tmax */
    vdouble base[3];    /* org before rounding */
    vdouble shift;      /* else 0 */
    bool moved;         /* some ray has been moved */
    bool plain;         /* no ray is far, or has a number that must be looked at, such as a direction of zero */
} vstart;

static inline vmask is_far(const cw_field *f, const vfloat org[3]) {
    vmask far[3];
    for (int c = 0; c < 3; c++) far[c] = vf_gt(vf_abs(vf_sub(org[c], vf_set(f->middle[c]))), vf_set(f->reach[c]));
    return vm_or(vm_or(far[0], far[1]), far[2]);
}

/* Moves the origins of rays that are far away to just before the field's box: ray_move, lane by lane. Returns the lanes
 * whose rays may meet the box. Not inlined, so that near rays do not pay for its registers. */
static __attribute__((noinline)) vmask move_rays(vstart *s, const cw_field *f, vmask far) {
    const vfloat low[3] = {vf_set(0), vf_set(0), vf_set(f->low)};
    const vfloat high[3] = {vf_set((float)(f->nx - 1)), vf_set((float)(f->ny - 1)), vf_set(f->high)};
    const vfloat infinite = vf_set(INFINITY), minus_infinite = vf_set(-INFINITY), least = vf_set(FLT_MIN);
    vmask hopeful = vm_set(true);
    vfloat to_low[3], to_high[3]; /* from the base */
    s->moved = true;
    s->shift = vd_set(0);
    s->first = s->tmin;
    s->last = s->tmax;
    vdouble begin = vd_from_vf(s->first), end = vd_from_vf(s->last);
    for (int c = 0; c < 3; c++) {
        s->base[c] = vd_from_vf(s->org[c]);
        to_low[c] = vf_sub(low[c], s->org[c]); /* as if rounded from double */
        to_high[c] = vf_sub(high[c], s->org[c]);
    }
    for (int k = 0;;) {
        vfloat in = minus_infinite, out = infinite;
        vmask passes = vm_set(false);
        for (int c = 0; c < 3; c++) {
            const vfloat a = vf_mul(to_low[c], s->inverse[c]), b = vf_mul(to_high[c], s->inverse[c]);
            const vmask stands = vf_eq(s->dir[c], vf_set(0));
            vfloat first = vf_min(a, b), last = vf_max(a, b);
            if (vm_any(stands)) {
                const vmask outside = vm_or(vf_gt(to_low[c], vf_set(0)), vf_lt(to_high[c], vf_set(0)));
                passes = vm_or(passes, vm_and(stands, outside));
                first = vf_select(stands, minus_infinite, first);
                last = vf_select(stands, infinite, last);
            }
            in = vf_max(first, in);
            out = vf_min(last, out);
        }
        const vfloat share = vf_set(RAY_BOX_ROOM);
        const vfloat room = vf_mul(vf_add(vf_max(vf_abs(in), vf_abs(out)), least), share);
        const vfloat farthest = vf_set(RAY_FARTHEST), before = vf_set(-RAY_FARTHEST);
        passes = vm_or(passes, vm_or(vf_gt(vf_sub(in, out), room), vm_or(vf_gt(in, farthest), vf_lt(out, before))));
        in = vf_max(in, before);
        hopeful = vm_andnot(hopeful, vm_and(far, passes));
        far = vm_andnot(far, passes);
        if (!vm_any(far)) break;
        vfloat step = vf_sub(in, vf_mul(vf_add(vf_abs(in), least), share));
        step = vf_select(far, step, vf_set(0));
        const vdouble way = vd_from_vf(step);
        s->shift = vd_add(s->shift, way);
        begin = vd_sub(begin, way);
        end = vd_sub(end, way);
        for (int c = 0; c < 3; c++) {
            const vdouble base = vd_add(s->base[c], vd_mul(way, vd_from_vf(s->dir[c])));
            s->base[c] = vd_select(far, base, s->base[c]); /* a zero keeps its sign */
            s->org[c] = vf_from_vd(s->base[c]);
        }
        far = vm_and(far, is_far(f, s->org));
        if (!vm_any(far) || ++k == RAY_MOVES) break;
        for (int c = 0; c < 3; c++) {
            to_low[c] = vf_from_vd(vd_sub(vd_from_vf(low[c]), s->base[c]));
            to_high[c] = vf_from_vd(vd_sub(vd_from_vf(high[c]), s->base[c]));
        }
    }
    s->tmin = vf_max(vf_from_vd(begin), vf_set(-RAY_T_LIMIT));
    s->tmax = vf_min(vf_from_vd(end), vf_set(RAY_T_LIMIT));
    return hopeful;
}

/* Moves the far rays among alive; returns the rays that may hit. If any is moved, *moved is set as a whole, and of *s
 * only moved, origins and ends. So *s stays in registers: its address is not taken, and directions do not change. */
CW_INLINE vmask move_if_far(vstart *s, const cw_field *f, vmask alive, vstart *moved) {
    const vmask far = vm_and(alive, is_far(f, s->org));
    if (!vm_any(far)) return alive;
    for (int c = 0; c < 3; c++) {
        moved->org[c] = s->org[c];
        moved->dir[c] = s->dir[c];
        moved->inverse[c] = vf_div(vf_set(1), s->dir[c]);
    }
    moved->tmin = s->tmin;
    moved->tmax = s->tmax;
    const vmask hopeful = move_rays(moved, f, far);
    for (int c = 0; c < 3; c++) s->org[c] = moved->org[c];
    s->tmin = moved->tmin;
    s->tmax = moved->tmax;
    s->moved = true;
    return vm_and(alive, hopeful);
}

/* ray_init, lane by lane, from the numbers of rays; returns the lanes whose rays may hit. *moved: see move_if_far.
 * Mostly all rays are plain, which takes fewer operations to see than to do without branches all that others need. */
CW_INLINE vmask start_rays(vstart *s, const cw_field *f, const vfloat c[8], vstart *moved) {
    const vfloat zero = vf_set(0), least = vf_set(0x1p-128f), most = vf_set(0x1p126f);
    vmask plain = vm_set(true);
    for (int k = 0; k < 3; k++) {
        const vfloat off = vf_abs(vf_sub(c[k], vf_set(f->middle[k]))), d = vf_abs(c[4 + k]);
        plain = vm_and(plain, vm_and(vf_lt(off, vf_set(f->reach[k])), vm_and(vf_gt(d, least), vf_le(d, most))));
        s->org[k] = c[k];
        s->dir[k] = c[4 + k];
    }
    s->tmin = vf_max(c[3], vf_set(-RAY_T_LIMIT));
    s->tmax = vf_min(c[7], vf_set(RAY_T_LIMIT));
    s->shift = vd_set(0);
    s->moved = false;
    s->plain = !vm_any(vm_not(plain)); /* NaN is not, nor is infinity on a level field, where nothing is far */
    if (s->plain) return vf_le(c[3], c[7]);
    const vfloat poison = vf_add(vf_add(vf_mul(c[0], zero), vf_mul(c[1], zero)), vf_mul(c[2], zero));
    vmask alive = vm_and(vf_eq(poison, zero), vf_le(c[3], c[7])), stands = vm_set(true);
    for (int k = 0; k < 3; k++) {
        s->dir[k] = vf_select(vf_gt(vf_abs(c[4 + k]), least), c[4 + k], zero); /* if its reciprocal overflows, zero */
        stands = vm_and(stands, vf_eq(s->dir[k], zero));
        alive = vm_and(alive, vf_le(vf_abs(c[4 + k]), most));
    }
    return move_if_far(s, f, vm_andnot(alive, stands), moved);
}

/* The first n of size rays. If n < size, a copy in which the missing rays repeat the first one. */
static inline const cw_ray *fill_up(const cw_ray *rays, size_t n, size_t size, cw_ray *copy) {
    if (n >= size) return rays;
    for (size_t k = 0; k < size; k++) copy[k] = rays[k < n ? k : 0];
    return copy;
}

/* strict_room. */
static inline vfloat make_room(vfloat height, vfloat dz, float room) {
    const vfloat least = vf_mul(vf_set(FLT_MIN), vf_add(vf_set(1), vf_abs(dz)));
    return vf_mul(vf_set(room), vf_add(vf_abs(height), least));
}

/* Lanes that can be within the field on this axis. */
static inline vmask make_axis(vaxis *a, vfloat org, vfloat dir, size_t samples, bool plain, vfloat *enter,
                              vfloat *leave) {
    const vfloat end = vf_set((float)(samples - 1)), zero = vf_set(0);
    a->org = a->center = org;
    a->dir = dir;
    a->inverse = vf_div(vf_set(1), dir);
    vmask within = vm_set(true);
    if (!plain) {
        const vmask stands = vf_eq(dir, zero);
        const vfloat cell = vf_min(vf_floor(org), vf_set((float)(samples - 1) - 1));
        a->center = vf_select(stands, vf_add(cell, vf_set(0.5f)), org);
        a->inverse = vf_select(stands, vf_set(INFINITY), a->inverse); /* -0 too */
        within = vm_not(vm_andnot(stands, vm_and(vf_ge(org, zero), vf_le(org, end))));
    }
    a->up = vf_ge(dir, zero);
    const vfloat at_zero = crossing(a, zero), at_end = crossing(a, end);
    *enter = vf_select(a->up, at_zero, at_end);
    *leave = vf_select(a->up, at_end, at_zero);
    return within;
}

/* strict_slab. Returns 1 / dz. */
CW_INLINE vfloat make_slab(vray *r, const cw_field *f, cw_leaf leaf) {
    vfloat low = above_origin(r, vf_set(f->low)), high = above_origin(r, vf_set(f->high));
    if (leaf == CW_LEAF_MOLLER_TRUMBORE) {
        low = vf_sub(low, make_room(low, r->dz, 2 * STRICT_ROOM));
        high = vf_add(high, make_room(high, r->dz, 2 * STRICT_ROOM));
    }
    const vfloat u8 = vf_set(8 * (FLT_EPSILON / 2)), one = vf_set(1), inverse = vf_div(one, r->dz);
    const vfloat least = vf_mul(vf_set(STRICT_LEAST), vf_add(one, vf_abs(inverse)));
    const vmask up = vf_gt(r->dz, vf_set(0));
    const vfloat enter = vf_select(up, low, high), leave = vf_select(up, high, low);
    const vfloat a = vf_mul(enter, inverse), b = vf_mul(leave, inverse);
    const vfloat s0 = vf_sub(a, vf_mul(u8, vf_add(vf_abs(a), least)));
    const vfloat s1 = vf_add(b, vf_mul(u8, vf_add(vf_abs(b), least)));
    const vfloat z0 = vf_mul(s0, r->dz), z1 = vf_mul(s1, r->dz);
    const vmask beyond0 = vm_or(vm_and(up, vf_lt(z0, enter)), vm_andnot(vf_gt(z0, enter), up));
    const vmask beyond1 = vm_or(vm_and(up, vf_gt(z1, leave)), vm_andnot(vf_lt(z1, leave), up));
    r->from = vf_select(vm_and(beyond0, vf_gt(s0, r->t0)), s0, r->t0);
    r->until = vf_select(vm_and(beyond1, vf_lt(s1, r->t1)), s1, r->t1);
    return inverse;
}

/* Returns the lanes that may hit. Unless cut is set, rays are not cut by make_slab if all begin over the field and none
 * behind its origin: a walk together does not need that. Of others, intervals would be too wide, or begin below 0.
 * *start is set only if r->moved, for refine_hits. */
CW_INLINE vmask make_rays(vray *r, const cw_field *f, const cw_ray *rays, cw_leaf leaf, bool cut, vstart *start) {
    vfloat c[8];
    vstart s;
    vf_load_rays(rays, c);
    vmask alive = start_rays(&s, f, c, start);
    vfloat x_in, x_out, y_in, y_out;
    alive = vm_and(alive, make_axis(&r->x, s.org[0], s.dir[0], f->nx, s.plain, &x_in, &x_out));
    alive = vm_and(alive, make_axis(&r->y, s.org[1], s.dir[1], f->ny, s.plain, &y_in, &y_out));
    r->oz = s.org[2];
    r->dz = s.dir[2];
    r->moved = s.moved;
    r->t0 = vf_max(vf_max(x_in, y_in), s.tmin);
    r->t1 = vf_min(vf_min(x_out, y_out), s.tmax);
    r->from = r->t0;
    r->until = r->t1;
    alive = vm_and(alive, vf_le(r->t0, r->t1));
    alive = vm_and(alive, meets(r, r->t0, r->t1, vf_set(f->low), vf_set(f->high)));
    const vmask outside = vm_or(vf_gt(r->t0, s.tmin), vf_lt(r->t0, vf_set(0)));
    if (vm_any(cut ? alive : vm_and(alive, outside))) (void)make_slab(r, f, leaf);
    return alive;
}

#endif
