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
    const vfloat cell_l = vf_select(b, h->j, h->i), cell_s = vf_select(b, h->i, h->j);
    const vdouble dl = vd_from_vf(vf_select(b, s->dir[1], s->dir[0])),
                  ds = vd_from_vf(vf_select(b, s->dir[0], s->dir[1]));
    vdouble org_l, org_s, org_z;
    if (s->moved) {
        org_l = vd_select(b, s->base[1], s->base[0]);
        org_s = vd_select(b, s->base[0], s->base[1]);
        org_z = s->base[2];
    } else {
        org_l = vd_from_vf(vf_select(b, s->org[1], s->org[0]));
        org_s = vd_from_vf(vf_select(b, s->org[0], s->org[1]));
        org_z = vd_from_vf(s->org[2]);
    }
    org_l = vd_sub(org_l, vd_from_vf(cell_l));
    org_s = vd_sub(org_s, vd_from_vf(cell_s));
    const vdouble h00 = vd_from_vf(h->h00), corner = vd_from_vf(h->corner);
    const vdouble first = vd_sub(corner, h00), second = vd_sub(vd_from_vf(h->h11), corner);
    const vdouble below = vd_sub(vd_add(vd_mul(first, org_l), vd_mul(second, org_s)), vd_sub(org_z, h00));
    const vdouble rise = vd_sub(vd_from_vf(s->dir[2]), vd_add(vd_mul(first, dl), vd_mul(second, ds)));
    const vdouble t = vd_min(vd_max(vd_div(below, rise), vd_from_vf(h->find.t0)), vd_from_vf(h->find.t1));
    const vfloat zero = vf_set(0), one = vf_set(1);
    const vfloat longer = vf_from_vd(vd_add(org_l, vd_mul(t, dl))), shorter = vf_from_vd(vd_add(org_s, vd_mul(t, ds)));
    const vfloat across = vf_max(vf_min(one, shorter), zero), along = vf_max(vf_min(one, longer), across);
    const vfloat rest = vf_sub(along, across);
    vfloat given = vf_from_vd(vd_add(s->shift, t));
    if (s->moved) given = vf_min(s->last, vf_max(s->first, given)); /* see ray_t */
    return (vhit){given, vf_select(b, across, rest), vf_select(b, rest, across)};
}

#endif
