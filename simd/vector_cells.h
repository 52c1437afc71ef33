/* SPDX-License-Identifier: Apache-2.0 */
/* Rays and cells, one of each a lane; and the gate, which selects the cells to be tested: src/scalar/strict.h,
 * operation by operation. */
#ifndef CELLWALK_SIMD_VECTOR_CELLS_H
#define CELLWALK_SIMD_VECTOR_CELLS_H

#include "vocabulary.h"

#include <math.h>

/* One axis of W rays; see strict_axis. */
typedef struct vaxis {
    vfloat org, dir, center, inverse;
    vmask up;
} vaxis;

typedef struct vray {
    vaxis x, y;
    vfloat oz, dz;
    vfloat t0, t1;      /* over the field: leaf tests clip to it */
    vfloat from, until; /* the rest of the walk; the only members that change on the way */
    bool moved;         /* the origin of some ray is not the caller's: see vstart */
} vray;

static inline vfloat crossing(const vaxis *a, vfloat border) { return vf_mul(vf_sub(border, a->center), a->inverse); }

/* A height relative to the ray's origin. */
static inline vfloat above_origin(const vray *r, vfloat z) { return vf_sub(z, r->oz); }

/* Lanes whose heights on [t0, t1] meet [low, high]. */
static inline vmask meets(const vray *r, vfloat t0, vfloat t1, vfloat low, vfloat high) {
    const vfloat z0 = vf_mul(t0, r->dz), z1 = vf_mul(t1, r->dz);
    return vm_and(vf_ge(vf_max(z0, z1), above_origin(r, low)), vf_le(vf_min(z0, z1), above_origin(r, high)));
}

/* A cell a lane: its place, border crossings, t-interval and samples; see strict_cell. */
typedef struct vcell {
    vfloat i, j;
    vfloat x_in, x_out, y_in, y_out;
    vfloat t0, t1;
    vfloat h00, h10, h01, h11;
} vcell;

/* Sets t0 and t1 of cells whose crossings are filled in. */
static inline void clip_cell(vcell *c, const vray *r) {
    c->t0 = vf_max(vf_max(c->x_in, c->y_in), r->t0);
    c->t1 = vf_min(vf_min(c->x_out, c->y_out), r->t1);
}

/* The cell's lowest and highest sample. Holes drop out: vf_min and vf_max yield the second operand where the first is
 * NaN. */
static inline vfloat cell_low(const vcell *c) {
    return vf_min(c->h11, vf_min(c->h01, vf_min(c->h10, vf_min(c->h00, vf_set(INFINITY)))));
}
static inline vfloat cell_high(const vcell *c) {
    return vf_max(c->h11, vf_max(c->h01, vf_max(c->h10, vf_max(c->h00, vf_set(-INFINITY)))));
}

/* Lanes whose cell, with crossings and t-interval filled in, and its lowest and highest sample, passes the gate. */
static inline vmask cell_gate_of(const vray *r, const vcell *c, vfloat low, vfloat high) {
    const vmask walked = vm_and(vf_le(c->x_in, c->y_out), vf_lt(c->y_in, c->x_out));
    return vm_and(vm_and(walked, vf_le(c->t0, c->t1)), meets(r, c->t0, c->t1, low, high));
}
static inline vmask cell_gate(const vray *r, const vcell *c) { return cell_gate_of(r, c, cell_low(c), cell_high(c)); }

/* The result of a leaf test: a stretch of t on which the ray meets a triangle of the cell, see strict_find. Lanes
 * outside its mask are undefined. */
typedef struct vfind {
    vfloat t0, t1;
    vmask b; /* triangle B */
} vfind;

#endif
