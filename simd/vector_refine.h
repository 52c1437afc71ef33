/* SPDX-License-Identifier: Apache-2.0 */
/* Turns the finds of leaf tests into hits: src/scalar/refine.h, operation by operation, where the reason is. Done once
 * a hit, after all lanes of a packet have ended, so that as many lanes as possible are in use. */
#ifndef CELLWALK_SIMD_VECTOR_REFINE_H
#define CELLWALK_SIMD_VECTOR_REFINE_H

#include "vector_rays.h"

/* The data of a hit until then: the leaf test's find, the cell, and the triangle's samples. */
typedef struct found_hits {
    vfind find;
    vfloat i, j;
    vfloat h00, corner, h11; /* corner: sample (i, j + 1) for triangle B, (i + 1, j) for A */
} found_hits;

/* The numbers of a cw_hit that refinement computes. */
typedef struct vhit {
    vfloat t, u, v;
} vhit;

/* Lanes without a find are undefined. */
CW_INLINE vhit refine_hits(const vstart *s, const found_hits *h) {
    const vmask b = h->find.b;
    const vdouble slope_x =
        vd_sub(vd_from_vf(vf_select(b, h->h11, h->corner)), vd_from_vf(vf_select(b, h->corner, h->h00)));
    const vdouble slope_y =
        vd_sub(vd_from_vf(vf_select(b, h->corner, h->h11)), vd_from_vf(vf_select(b, h->h00, h->corner)));
    vdouble base[3];
    for (int c = 0; c < 3; c++) base[c] = s->moved ? s->base[c] : vd_from_vf(s->org[c]);
    const vdouble x = vd_sub(base[0], vd_from_vf(h->i)), y = vd_sub(base[1], vd_from_vf(h->j));
    const vdouble dx = vd_from_vf(s->dir[0]), dy = vd_from_vf(s->dir[1]), dz = vd_from_vf(s->dir[2]);
    const vdouble z = vd_sub(base[2], vd_from_vf(h->h00));
    const vdouble below = vd_sub(vd_add(vd_mul(slope_x, x), vd_mul(slope_y, y)), z);
    const vdouble rise = vd_sub(dz, vd_add(vd_mul(slope_x, dx), vd_mul(slope_y, dy)));
    const vdouble t = vd_min(vd_max(vd_div(below, rise), vd_from_vf(h->find.t0)), vd_from_vf(h->find.t1));
    const vfloat zero = vf_set(0), one = vf_set(1);
    const vfloat at_x = vf_min(one, vf_max(vf_from_vd(vd_add(x, vd_mul(t, dx))), zero));
    const vfloat at_y = vf_min(one, vf_max(vf_from_vd(vd_add(y, vd_mul(t, dy))), zero));
    const vfloat least_x = vf_select(b, zero, at_y), least_y = vf_select(b, at_x, zero);
    vfloat given = vf_from_vd(vd_add(s->shift, t));
    if (s->moved) given = vf_min(s->last, vf_max(s->first, given)); /* see ray_t */
    return (vhit){given, vf_sub(vf_max(at_x, least_x), least_x), vf_sub(vf_max(at_y, least_y), least_y)};
}

#endif
