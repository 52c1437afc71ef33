/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary one lane wide, in plain C. Tests compare the other vocabularies with it, and CPUs without
 * SSE4.2 run it. It also documents the vocabulary: every vec_*.h has the same names with the same meaning, lane by
 * lane, bit for bit.
 *
 * vfloat, vint and vmask are three distinct types, so that a mask cannot be used as a number by mistake. Arithmetic
 * is IEEE, rounded once an operation. Comparisons are false on NaN. */
#ifndef CELLWALK_SIMD_VEC_SCALAR_H
#define CELLWALK_SIMD_VEC_SCALAR_H

#include "cellwalk.h"

#include <math.h>

enum { W = 1 };

typedef struct vfloat {
    float v;
} vfloat;
typedef struct vint {
    int32_t v;
} vint;
typedef struct vmask {
    bool v;
} vmask;

static inline vfloat vf_set(float a) { return (vfloat){a}; }
static inline vfloat vf_load(const float *a) { return (vfloat){*a}; } /* W floats, any alignment */
static inline void vf_store(float *to, vfloat a) { *to = a.v; }
static inline vfloat vf_add(vfloat a, vfloat b) { return (vfloat){a.v + b.v}; }
static inline vfloat vf_sub(vfloat a, vfloat b) { return (vfloat){a.v - b.v}; }
static inline vfloat vf_mul(vfloat a, vfloat b) { return (vfloat){a.v * b.v}; }
static inline vfloat vf_div(vfloat a, vfloat b) { return (vfloat){a.v / b.v}; }
/* a < b ? a : b and a > b ? a : b, so b where either is NaN. */
static inline vfloat vf_min(vfloat a, vfloat b) { return (vfloat){a.v < b.v ? a.v : b.v}; }
static inline vfloat vf_max(vfloat a, vfloat b) { return (vfloat){a.v > b.v ? a.v : b.v}; }
static inline vfloat vf_abs(vfloat a) { return (vfloat){fabsf(a.v)}; }
static inline vfloat vf_floor(vfloat a) { return (vfloat){floorf(a.v)}; }

static inline vmask vf_lt(vfloat a, vfloat b) { return (vmask){a.v < b.v}; }
static inline vmask vf_le(vfloat a, vfloat b) { return (vmask){a.v <= b.v}; }
static inline vmask vf_gt(vfloat a, vfloat b) { return (vmask){a.v > b.v}; }
static inline vmask vf_ge(vfloat a, vfloat b) { return (vmask){a.v >= b.v}; }
static inline vmask vf_eq(vfloat a, vfloat b) { return (vmask){a.v == b.v}; }
/* m ? a : b */
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) { return m.v ? a : b; }

static inline vint vi_set(int32_t a) { return (vint){a}; }
static inline void vi_store(int32_t *to, vint a) { *to = a.v; }
static inline vint vi_add(vint a, vint b) { return (vint){a.v + b.v}; }
static inline vint vi_mul(vint a, vint b) { return (vint){a.v * b.v}; }
static inline vint vi_select(vmask m, vint a, vint b) { return m.v ? a : b; }
static inline vint vi_from_vf(vfloat a) { return (vint){(int32_t)a.v}; } /* toward zero; a within int32 */

static inline vfloat vf_from_vi(vint a) { return (vfloat){(float)a.v}; }
static inline vint vi_load(const int32_t *a) { return (vint){*a}; }
static inline vint vi_and(vint a, vint b) { return (vint){a.v & b.v}; }
static inline vint vi_or(vint a, vint b) { return (vint){a.v | b.v}; }
static inline vint vi_xor(vint a, vint b) { return (vint){a.v ^ b.v}; }
static inline vint vi_sub(vint a, vint b) { return (vint){a.v - b.v}; }
static inline vint vi_shift_right(vint a, vint by) { return (vint){a.v >> by.v}; } /* a in [0, 2^24], by in [0, 31] */
static inline vint vi_shift_left(vint a, vint by) {
    return (vint){(int32_t)((uint32_t)a.v << by.v)};
} /* by in [0, 31] */
static inline vmask vi_eq(vint a, vint b) { return (vmask){a.v == b.v}; }
/* table[k] of 16 entries, k in [0, 15] */
static inline vint vi_lookup(const int32_t table[16], vint k) { return (vint){table[k.v]}; }

static inline vint vi_where(vmask m, vint a) { return (vint){m.v ? a.v : 0}; }
static inline vfloat vf_flip(vfloat a, vfloat sign) {
    return (vfloat){signbit(sign.v) ? -a.v : a.v};
} /* sign: 0 or -0 */
static inline vfloat vf_power_of_2(vint k) { return (vfloat){ldexpf(1, k.v)}; } /* k in [-126, 127] */

static inline vmask vm_and(vmask a, vmask b) { return (vmask){a.v && b.v}; }
static inline vmask vm_or(vmask a, vmask b) { return (vmask){a.v || b.v}; }
static inline vmask vm_xor(vmask a, vmask b) { return (vmask){a.v != b.v}; }
static inline vmask vm_andnot(vmask a, vmask b) { return (vmask){a.v && !b.v}; } /* a and not b */
static inline vmask vm_not(vmask a) { return (vmask){!a.v}; }
static inline vmask vm_first(size_t n) { return (vmask){n > 0}; } /* lanes 0 to n - 1 */
static inline vmask vm_from_bits(unsigned bits) {
    return (vmask){bits & 1};
} /* lane k = bit k; further bits are ignored */
static inline bool vm_any(vmask a) { return a.v; }
static inline unsigned vm_bits(vmask a) { return a.v; } /* bit k = lane k */

/* base[index] where m, else 0; indices of lanes outside m are not used. */
static inline vfloat vf_gather(const float *base, vint index, vmask m) { return (vfloat){m.v ? base[index.v] : 0}; }

/* base[index] and base[index + 1] where m, else base[0] and base[1]. */
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    const int32_t k = m.v ? index.v : 0;
    first->v = base[k];
    second->v = base[k + 1];
}

/* base[4 index] to base[4 index + 3] where m, else base[0] to base[3]; base + 4 k is aligned to 16 bytes. */
CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    const float *from = base + 4 * (ptrdiff_t)(m.v ? index.v : 0);
    for (int c = 0; c < 4; c++) out[c].v = from[c];
}

/* Rays of consecutive lanes, from an array of structures to one vector each of org x y z, tmin, dir x y z, tmax. */
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    for (int c = 0; c < 3; c++) {
        out[c].v = rays->org[c];
        out[4 + c].v = rays->dir[c];
    }
    out[3].v = rays->tmin;
    out[7].v = rays->tmax;
}

/* The same of rays anywhere, a pointer a lane. */
CW_INLINE void vf_load_each_ray(const cw_ray *const rays[1], vfloat out[8]) { vf_load_rays(rays[0], out); }

/* vpick_make prepares the selection of the lanes of m; vf_store_picked stores these lanes one after another. The
 * rest of the W floats at to is undefined. */
typedef struct vpick {
    int unused;
} vpick;
static inline vpick vpick_make(vmask m) {
    (void)m;
    return (vpick){0};
}
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    (void)pick;
    *to = a.v;
}

/* W hits of consecutive lanes, from one vector each of t, u, v, i, j, triangle to an array of structures. i and j
 * are whole numbers; triangle is B where b. */
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
    *hits = (cw_hit){.t = t.v, .i = (int32_t)i.v, .j = (int32_t)j.v, .triangle = b.v, .u = u.v, .v = v.v};
}

static inline vmask vm_set(bool a) { return (vmask){a}; }

/* The lowest lane of each of 16 vectors. No lane is NaN. */
CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    for (int k = 0; k < 16; k++) out[k] = a[k].v;
}

/* W doubles, for numbers that are computed once a ray or once a hit. */
typedef struct vdouble {
    double v;
} vdouble;

static inline vdouble vd_set(double a) { return (vdouble){a}; }
static inline vdouble vd_from_vf(vfloat a) { return (vdouble){(double)a.v}; }
static inline vfloat vf_from_vd(vdouble a) { return (vfloat){(float)a.v}; } /* rounded to nearest */
static inline vdouble vd_add(vdouble a, vdouble b) { return (vdouble){a.v + b.v}; }
static inline vdouble vd_sub(vdouble a, vdouble b) { return (vdouble){a.v - b.v}; }
static inline vdouble vd_mul(vdouble a, vdouble b) { return (vdouble){a.v * b.v}; }
static inline vdouble vd_div(vdouble a, vdouble b) { return (vdouble){a.v / b.v}; }
static inline vdouble vd_min(vdouble a, vdouble b) { return (vdouble){a.v < b.v ? a.v : b.v}; } /* as vf_min */
static inline vdouble vd_max(vdouble a, vdouble b) { return (vdouble){a.v > b.v ? a.v : b.v}; }
static inline vdouble vd_select(vmask m, vdouble a, vdouble b) { return m.v ? a : b; }

/* A block of 4 × 4 floats in the order in which a ray of one direction quadrant meets them: lane 4 y + x of the 16
 * is the x-th column from where x is entered and the y-th row from where y is entered. A ray goes through a block
 * along a monotone staircase, so this order is front to back. */
typedef struct vorder {
    int flip_x, flip_y; /* 3 where the ray goes down, else 0: number in walk order XOR flip = number in the field */
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) { return (vorder){up_x ? 0 : 3, up_y ? 0 : 3}; }

/* Lanes k W to k W + W - 1 of the block whose rows, in walk order, begin step floats apart from row on. */
static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    return (vfloat){row[(ptrdiff_t)(k >> 2) * step + (ptrdiff_t)((k & 3) ^ (size_t)o->flip_x)]};
}

#endif
