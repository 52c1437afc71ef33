/* SPDX-License-Identifier: Apache-2.0 */
/* W rays made ready for a walk: the rules of src/scalar/strict.h, operation by operation. The vocabulary comes first. */

#include "count.h"
#include "field.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

/* For bodies that take constant arguments (leaf test, kind of query) or a ray by pointer: unless it is inlined, a compiler
 * keeps the choice at run time and writes the ray's twenty vectors to the stack for the call. */
#define CW_INLINE static inline __attribute__((always_inline))

/* Counts an event with the lanes of a mask. */
#ifdef CELLWALK_COUNT
CW_INLINE void count_lanes(count_kind kind, vmask lanes) { count_step(kind, vm_bits(lanes)); }
#else
CW_INLINE void count_lanes(count_kind kind, vmask lanes) { (void)kind, (void)lanes; }
#endif

/* One axis of W rays; see strict_axis. */
typedef struct vaxis {
    vfloat org, dir, center, inverse;
    vfloat first, last;
    vmask up;
    vfloat step; /* +1 or -1 */
} vaxis;

typedef struct vray {
    vaxis x, y;
    vfloat oz, dz;
    vfloat tmin, tmax;
    vfloat t0, t1;     /* inside the field */
    vfloat begin, end; /* inside the slab's surroundings too: a cell's interval lies in it */
    vfloat from,
        until; /* inside the slab: what a walk still has to visit; unlike all the rest it may change on the way */
} vray;

static inline vfloat crossing(const vaxis *a, vfloat border) { return vf_mul(vf_sub(border, a->center), a->inverse); }

static inline vfloat height(const vray *r, vfloat t) { return vf_add(r->oz, vf_mul(t, r->dz)); }

/* Lanes whose heights on [t0, t1] meet [low, high]. */
static inline vmask meets(const vray *r, vfloat t0, vfloat t1, vfloat low, vfloat high) {
    const vfloat z0 = height(r, t0), z1 = height(r, t1);
    return vm_and(vf_ge(vf_max(z0, z1), low), vf_le(vf_min(z0, z1), high));
}

static inline vmask has_inverse(vfloat inverse) { return vf_le(vf_abs(inverse), vf_set(FLT_MAX)); }

/* False where the direction is NaN, infinite or so large that its inverse is denormal. */
static inline vmask direction_counts(vfloat inverse) { return vf_ge(vf_abs(inverse), vf_set(FLT_MIN)); }

/* Lanes that can be within the field on this axis. */
static inline vmask make_axis(vaxis *a, vfloat org, vfloat dir, size_t samples) {
    const vfloat end = vf_set((float)(samples - 1)), zero = vf_set(0);
    const vfloat inverse = vf_div(vf_set(1), dir);
    const vmask moves = has_inverse(inverse);
    const vfloat cell = vf_min(vf_floor(org), vf_set((float)(samples - 1) - 1));
    a->org = org;
    a->dir = vf_select(moves, dir, zero);
    a->center = vf_select(moves, org, vf_add(cell, vf_set(0.5f)));
    a->inverse = vf_select(moves, inverse, vf_set(INFINITY));
    a->up = vf_ge(a->dir, zero);
    a->first = vf_select(a->up, zero, end);
    a->last = vf_select(a->up, end, zero);
    a->step = vf_select(a->up, vf_set(1), vf_set(-1));
    return vm_and(direction_counts(inverse), vm_or(moves, vm_and(vf_ge(org, zero), vf_le(org, end))));
}

static inline void make_slab(vray *r, const cw_field *f) {
    const vfloat low = vf_set(f->low), high = vf_set(f->high), u = vf_set(FLT_EPSILON / 2), least = vf_set(FLT_MIN);
    const vfloat u4 = vf_mul(vf_set(4), u), u8 = vf_mul(vf_set(8), u);
    const vfloat inverse = vf_div(vf_set(1), r->dz), across = vf_abs(inverse);
    const vmask up = vf_gt(r->dz, vf_set(0));
    const vfloat enter = vf_select(up, low, high), leave = vf_select(up, high, low);
    const vfloat a = vf_mul(vf_sub(enter, r->oz), inverse), b = vf_mul(vf_sub(leave, r->oz), inverse);
    const vfloat oz = vf_add(vf_abs(r->oz), least);
    const vfloat reach_a = vf_mul(vf_add(oz, vf_abs(enter)), across);
    const vfloat reach_b = vf_mul(vf_add(oz, vf_abs(leave)), across);
    const vfloat s0 = vf_sub(a, vf_add(vf_mul(u8, reach_a), vf_mul(u4, vf_add(vf_abs(a), least))));
    const vfloat s1 = vf_add(b, vf_add(vf_mul(u8, reach_b), vf_mul(u4, vf_add(vf_abs(b), least))));
    const vfloat z0 = height(r, s0), z1 = height(r, s1);
    const vmask beyond0 = vm_or(vm_and(up, vf_lt(z0, enter)), vm_andnot(vf_gt(z0, enter), up));
    const vmask beyond1 = vm_or(vm_and(up, vf_gt(z1, leave)), vm_andnot(vf_lt(z1, leave), up));
    r->from = vf_select(vm_and(beyond0, vf_gt(s0, r->t0)), s0, r->t0);
    r->until = vf_select(vm_and(beyond1, vf_lt(s1, r->t1)), s1, r->t1);
    const vfloat span = vf_mul(vf_sub(high, low), across);
    r->begin = vf_max(vf_sub(r->from, vf_add(reach_a, span)), r->t0);
    r->end = vf_min(vf_add(r->until, vf_add(reach_b, span)), r->t1);
}

/* Lanes that may hit. Where none may, the slab is left out. */
static inline vmask make_rays(vray *r, const cw_field *f, const cw_ray *rays) {
    vfloat c[8];
    vf_load_rays(rays, c);
    const vfloat zero = vf_set(0);
    const vfloat poison = vf_add(vf_add(vf_mul(c[0], zero), vf_mul(c[1], zero)), vf_mul(c[2], zero));
    const vfloat inverse_z = vf_div(vf_set(1), c[6]);
    vmask alive = vm_and(vf_eq(poison, zero), vf_le(c[3], c[7]));
    alive = vm_and(alive, make_axis(&r->x, c[0], c[4], f->nx));
    alive = vm_and(alive, make_axis(&r->y, c[1], c[5], f->ny));
    r->oz = c[2];
    alive = vm_and(alive, direction_counts(inverse_z));
    r->dz = vf_select(has_inverse(inverse_z), c[6], zero);
    const vmask still = vm_and(vm_and(vf_eq(r->x.dir, zero), vf_eq(r->y.dir, zero)), vf_eq(r->dz, zero));
    r->tmin = vf_max(c[3], vf_set(-FLT_MAX / 2));
    r->tmax = vf_min(c[7], vf_set(FLT_MAX / 2));
    r->t0 = vf_max(vf_max(crossing(&r->x, r->x.first), crossing(&r->y, r->y.first)), r->tmin);
    r->t1 = vf_min(vf_min(crossing(&r->x, r->x.last), crossing(&r->y, r->y.last)), r->tmax);
    alive = vm_and(vm_andnot(alive, still), vf_le(r->t0, r->t1));
    alive = vm_and(alive, meets(r, r->t0, r->t1, vf_set(f->low), vf_set(f->high)));
    count_lanes(COUNT_RAY, alive);
    if (vm_any(alive))
        make_slab(r, f);
    else
        r->from = r->until = r->begin = r->end = r->t0;
    return alive;
}

/* A cell a lane: its place, border crossings, t-interval and samples; see strict_cell. */
typedef struct vcell {
    vfloat i, j;
    vfloat x_in, x_out, y_in, y_out;
    vfloat t0, t1;
    vfloat h00, h10, h01, h11;
} vcell;

/* The cell's lowest and highest sample. Holes drop out: vf_min and vf_max yield the second operand where the first is
 * NaN. */
static inline vfloat cell_low(const vcell *c) {
    return vf_min(c->h11, vf_min(c->h01, vf_min(c->h10, vf_min(c->h00, vf_set(INFINITY)))));
}
static inline vfloat cell_high(const vcell *c) {
    return vf_max(c->h11, vf_max(c->h01, vf_max(c->h10, vf_max(c->h00, vf_set(-INFINITY)))));
}

/* Lanes whose cell, with crossings, t-interval and samples filled in, passes the gate. */
static inline vmask cell_gate(const vray *r, const vcell *c) {
    const vmask walked = vm_and(vf_le(c->x_in, c->y_out), vf_lt(c->y_in, c->x_out));
    return vm_and(vm_and(walked, vf_le(c->t0, c->t1)), meets(r, c->t0, c->t1, cell_low(c), cell_high(c)));
}

/* What a leaf test finds; lanes outside its mask hold anything. */
typedef struct vhit {
    vfloat t, u, v;
    vmask b; /* triangle B */
} vhit;
