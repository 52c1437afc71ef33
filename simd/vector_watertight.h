/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test on a cell a lane, with one ray each, operation by operation as in src/scalar/watertight.h.
 * Idea, invariant and the rejected alternative are there. Lanes differ in the borders by which they enter and leave, so
 * each choice is a select. */
#ifndef CELLWALK_SIMD_VECTOR_WATERTIGHT_H
#define CELLWALK_SIMD_VECTOR_WATERTIGHT_H

#include "vector_cells.h"

static inline vfloat wt_edge(vfloat a, vfloat b, vfloat f) {
    const vfloat z = vf_add(a, vf_mul(f, vf_sub(b, a)));
    return vf_max(vf_min(a, b), vf_min(vf_max(a, b), z));
}

static inline vfloat wt_within(vfloat from, vfloat dir, vfloat t) {
    return vf_max(vf_set(0), vf_min(vf_set(1), vf_add(from, vf_mul(t, dir))));
}

/* See wt_ray of src/scalar/watertight.h. */
typedef struct vwt {
    vfloat x, y, dx, dy, dz;
    vfloat h00, h10, h01, h11;
} vwt;

/* The height difference at t on the borders by which the lanes enter, or by which they leave: x borders in these lanes,
 * else y borders; on their cells' high sides in high. */
CW_INLINE vfloat wt_border(const vwt *r, vfloat t, vmask x, vmask high) {
    const vfloat from = vf_select(x, r->y, r->x), dir = vf_select(x, r->dy, r->dx);
    /* Samples at the ends of the edge, in the order of the axis along it. */
    const vfloat a = vf_select(high, vf_select(x, r->h10, r->h01), r->h00);
    const vfloat b = vf_select(high, r->h11, vf_select(x, r->h01, r->h10));
    return vf_sub(vf_mul(t, r->dz), wt_edge(a, b, wt_within(from, dir, t)));
}

CW_INLINE vfloat wt_inside(const vwt *r, vfloat t, vmask *in_b) {
    const vfloat x = wt_within(r->x, r->dx, t), y = wt_within(r->y, r->dy, t);
    *in_b = vf_gt(y, x);
    const vfloat corner = vf_select(*in_b, r->h01, r->h10);
    const vfloat longer = vf_max(x, y), shorter = vf_min(x, y);
    const vfloat z =
        vf_add(vf_add(r->h00, vf_mul(longer, vf_sub(corner, r->h00))), vf_mul(shorter, vf_sub(r->h11, corner)));
    const vfloat low = vf_min(r->h00, vf_min(corner, r->h11)), high = vf_max(r->h00, vf_max(corner, r->h11));
    return vf_sub(vf_mul(t, r->dz), vf_max(low, vf_min(high, z)));
}

/* The height difference on the diagonal, at the t where the ray crosses it; crossing as for wt_cell_in. */
CW_INLINE vfloat wt_diagonal(const vwt *r, const vcell *c, const vfloat *crossing, vfloat *t) {
    const vfloat line = crossing ? *crossing : vf_div(vf_sub(r->y, r->x), vf_sub(r->dx, r->dy));
    *t = vf_max(c->t0, vf_min(line, c->t1));
    return vf_sub(vf_mul(*t, r->dz), wt_edge(r->h00, r->h11, wt_within(r->x, r->dx, *t)));
}

static inline vmask wt_between(vfloat da, vfloat db) {
    const vfloat zero = vf_set(0);
    return vm_or(vm_and(vf_le(db, zero), vf_ge(da, zero)), vm_and(vf_le(da, zero), vf_ge(db, zero)));
}

/* The diagonal first: its division takes longest. With fewer than 32 registers, its results wait in memory instead. */
enum { EARLY = W == 16 };

/* Lanes among which the cell is hit. In others *find is undefined. crossing: t on the diagonal's line; NULL if the
 * caller has not computed it. */
CW_INLINE vmask wt_cell_in(const vray *ray, const vcell *c, vmask among, const vfloat *crossing, vfind *find) {
    const vwt r = {vf_sub(ray->x.org, c->i),
                   vf_sub(ray->y.org, c->j),
                   ray->x.dir,
                   ray->y.dir,
                   ray->dz,
                   above_origin(ray, c->h00),
                   above_origin(ray, c->h10),
                   above_origin(ray, c->h01),
                   above_origin(ray, c->h11)};
    vfloat td, dd;
    if (EARLY) dd = wt_diagonal(&r, c, crossing, &td);
    const vmask enter_x = vf_gt(c->x_in, c->y_in), leave_x = vf_le(c->x_out, c->y_out);
    /* Low side: entered going up, left going down. Where a ray goes up on one axis only, the border's axis decides. */
    const vmask mixed = vm_xor(ray->x.up, ray->y.up);
    const vmask enter_high = vm_not(vm_xor(vm_and(enter_x, mixed), ray->y.up));
    const vmask leave_high = vm_xor(vm_and(leave_x, mixed), ray->y.up);
    /* Triangle B is at the low x and the high y border. */
    vmask in_b = vm_xor(enter_x, enter_high), out_b = vm_xor(leave_x, leave_high);
    const vfloat in = vf_max(c->x_in, c->y_in), out = vf_min(c->x_out, c->y_out);
    const vmask at_in = vf_ge(in, ray->t0), at_out = vf_le(out, ray->t1);
    vfloat da = wt_border(&r, c->t0, enter_x, enter_high);
    vfloat db = wt_border(&r, c->t1, leave_x, leave_high);
    /* Ranges that start or end inside a cell are rare, and both at once rarer. */
    if (vm_any(vm_andnot(among, at_in))) {
        vmask start_b;
        const vfloat start = wt_inside(&r, c->t0, &start_b);
        da = vf_select(at_in, da, start);
        in_b = vm_or(vm_and(at_in, in_b), vm_andnot(start_b, at_in));
    }
    if (vm_any(vm_andnot(among, at_out))) {
        vmask stop_b;
        const vfloat stop = wt_inside(&r, c->t1, &stop_b);
        db = vf_select(at_out, db, stop);
        out_b = vm_or(vm_and(at_out, out_b), vm_andnot(stop_b, at_out));
    }
    const vmask crosses = vm_xor(in_b, out_b);
    if (!EARLY) dd = wt_diagonal(&r, c, crossing, &td);
    /* first: the hit is before the diagonal; second: after it, if there is one. Without a crossing, one stretch from
     * border to border. */
    const vmask first = vm_and(crosses, wt_between(da, dd)), second = vm_andnot(crosses, first);
    const vmask rest = vm_or(vm_and(crosses, wt_between(db, dd)), vm_andnot(wt_between(da, db), crosses));
    const vmask found = vm_and(among, vm_or(first, rest));
    find->t0 = vf_select(second, td, c->t0);
    find->t1 = vf_select(first, td, c->t1);
    find->b = vm_or(vm_andnot(in_b, second), vm_and(second, out_b));
    return found;
}

/* The same, not inlined: most walks have no registers left for it. */
static __attribute__((noinline, unused)) vmask wt_cell(const vray *ray, const vcell *c, vmask among, vfind *find) {
    return wt_cell_in(ray, c, among, NULL, find);
}

#endif
