/* SPDX-License-Identifier: Apache-2.0 */
/* Möller and Trumbore 1997 on a cell a lane, with one ray each, operation by operation as in
 * src/scalar/moller_trumbore.h. The edges' zeros and ones are constants; products with 0 are left out in both files. */
#ifndef CELLWALK_SIMD_VECTOR_MOLLER_TRUMBORE_H
#define CELLWALK_SIMD_VECTOR_MOLLER_TRUMBORE_H

#include "vector_rays.h"

/* See mt_range. */
typedef struct vrange {
    vfloat tmin, tmax, low, high;
} vrange;

/* One triangle with edges e1 = (1, e1y, e1z), e2 = (e2x, 1, e2z), where e1y and e2x are 0 or 1. */
static inline vmask mt_triangle(const vfloat d[3], const vfloat o[3], bool e1y, vfloat e1z, bool e2x, vfloat e2z,
                                const vrange *range, vfloat *t) {
    const vfloat zero = vf_set(0), one = vf_set(1);
    const vfloat px = vf_sub(vf_mul(d[1], e2z), d[2]);
    const vfloat py = vf_sub(e2x ? d[2] : zero, vf_mul(d[0], e2z));
    const vfloat pz = e2x ? vf_sub(d[0], d[1]) : d[0];
    const vfloat det = vf_add(e1y ? vf_add(px, py) : px, vf_mul(pz, e1z));
    const vfloat inverse = vf_div(one, det);
    const vfloat u = vf_mul(vf_add(vf_add(vf_mul(o[0], px), vf_mul(o[1], py)), vf_mul(o[2], pz)), inverse);
    const vfloat qx = e1y ? vf_sub(vf_mul(o[1], e1z), o[2]) : vf_mul(o[1], e1z);
    const vfloat qy = vf_sub(o[2], vf_mul(o[0], e1z));
    const vfloat qz = vf_sub(e1y ? o[0] : zero, o[1]);
    const vfloat v = vf_mul(vf_add(vf_add(vf_mul(d[0], qx), vf_mul(d[1], qy)), vf_mul(d[2], qz)), inverse);
    *t = vf_mul(vf_add(e2x ? vf_add(qx, qy) : qy, vf_mul(e2z, qz)), inverse);
    const vmask inside = vm_and(vm_and(vf_ge(u, zero), vf_ge(v, zero)), vf_le(vf_add(u, v), one));
    const vfloat z = vf_mul(*t, d[2]);
    const vmask in_time = vm_and(vf_ge(*t, range->tmin), vf_le(*t, range->tmax));
    const vmask in_height = vm_and(vf_ge(z, range->low), vf_le(z, range->high));
    return vm_and(inside, vm_and(in_time, in_height));
}

/* Lanes among which the cell is hit, at a t of the cell's stretch and heights or slightly beyond: mt_find of
 * src/scalar/cell.c. */
CW_INLINE vmask mt_cell(const vray *r, const vcell *c, vmask among, vfind *find) {
    const vfloat room = vf_set(0x1p-20f), low = above_origin(r, cell_low(c)), high = above_origin(r, cell_high(c));
    const vrange range = {vf_max(vf_sub(c->t0, vf_mul(room, vf_abs(c->t0))), r->t0),
                          vf_min(vf_add(c->t1, vf_mul(room, vf_abs(c->t1))), r->t1),
                          vf_sub(low, make_room(low, r->dz, STRICT_ROOM)),
                          vf_add(high, make_room(high, r->dz, STRICT_ROOM))};
    const vfloat o[3] = {vf_sub(r->x.org, c->i), vf_sub(r->y.org, c->j), vf_sub(r->oz, c->h00)};
    const vfloat d[3] = {r->x.dir, r->y.dir, r->dz};
    const vfloat across = vf_sub(c->h11, c->h00);
    vfloat a, b;
    const vmask hit_a = mt_triangle(d, o, false, vf_sub(c->h10, c->h00), true, across, &range, &a);
    const vmask hit_b = mt_triangle(d, o, true, across, false, vf_sub(c->h01, c->h00), &range, &b);
    find->b = vm_andnot(hit_b, vm_and(hit_a, vf_le(a, b)));
    find->t0 = find->t1 = vf_select(find->b, b, a);
    return vm_and(among, vm_or(hit_a, hit_b));
}

#endif
