/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for pairs of vectors of the vocabulary that was included between vec_half.h and this file.
 * Meanings are in vec_scalar.h.
 *
 * A step of the lane walk is one chain of some forty dependent operations, longer than the CPU can look ahead, so
 * one vector leaves most of its units idle. Two vectors in lockstep, operation by operation, are two chains at once.
 * Rejected: vectors that take turns step by step, since the CPU still sees one chain at a time (papers/walks.md). */
#ifndef CELLWALK_SIMD_VEC_TWICE_H
#define CELLWALK_SIMD_VEC_TWICE_H

#undef W
#undef vfloat
#undef vint
#undef vmask
#undef vdouble
#undef vd_add
#undef vd_div
#undef vd_from_vf
#undef vd_max
#undef vd_min
#undef vd_mul
#undef vd_select
#undef vd_set
#undef vd_sub
#undef vf_from_vd
#undef vf_abs
#undef vf_add
#undef vf_div
#undef vf_eq
#undef vf_flip
#undef vf_floor
#undef vf_from_vi
#undef vf_gather
#undef vf_gather_pairs
#undef vf_gather_quads
#undef vf_ge
#undef vf_gt
#undef vf_le
#undef vf_load
#undef vf_load_block
#undef vf_load_each_ray
#undef vf_load_rays
#undef vf_lowest_of_each
#undef vf_lt
#undef vf_max
#undef vf_min
#undef vf_mul
#undef vf_power_of_2
#undef vf_select
#undef vf_set
#undef vf_store
#undef vf_store_hits
#undef vf_store_picked
#undef vpick
#undef vpick_make
#undef vf_sub
#undef vi_add
#undef vi_and
#undef vi_eq
#undef vi_from_vf
#undef vi_load
#undef vi_lookup
#undef vi_mul
#undef vi_or
#undef vi_select
#undef vi_set
#undef vi_shift_left
#undef vi_shift_right
#undef vi_store
#undef vi_sub
#undef vi_where
#undef vi_xor
#undef vm_and
#undef vm_andnot
#undef vm_any
#undef vm_bits
#undef vm_first
#undef vm_from_bits
#undef vm_not
#undef vm_or
#undef vm_set
#undef vm_xor

enum { W = 2 * half_W };

typedef struct vfloat {
    half_vfloat a, b;
} vfloat;
typedef struct vint {
    half_vint a, b;
} vint;
typedef struct vmask {
    half_vmask a, b;
} vmask;
typedef struct vdouble {
    half_vdouble a, b;
} vdouble;

/* A word that does the same in each lane, of one to three vectors. */
#define ONE(result, word, type)                                                                                        \
    static inline result word(type x) { return (result){half_##word(x.a), half_##word(x.b)}; }
#define TWO(result, word, left, right)                                                                                 \
    static inline result word(left x, right y) { return (result){half_##word(x.a, y.a), half_##word(x.b, y.b)}; }
#define THREE(result, word, type)                                                                                      \
    static inline result word(type x, type y, type z) {                                                                \
        return (result){half_##word(x.a, y.a, z.a), half_##word(x.b, y.b, z.b)};                                       \
    }

/* clang-format off: a word a line */
TWO(vfloat, vf_add, vfloat, vfloat)
TWO(vfloat, vf_sub, vfloat, vfloat)
TWO(vfloat, vf_mul, vfloat, vfloat)
TWO(vfloat, vf_div, vfloat, vfloat)
TWO(vfloat, vf_min, vfloat, vfloat)
TWO(vfloat, vf_max, vfloat, vfloat)
TWO(vfloat, vf_flip, vfloat, vfloat)
TWO(vmask, vf_lt, vfloat, vfloat)
TWO(vmask, vf_le, vfloat, vfloat)
TWO(vmask, vf_gt, vfloat, vfloat)
TWO(vmask, vf_ge, vfloat, vfloat)
TWO(vmask, vf_eq, vfloat, vfloat)
TWO(vint, vi_add, vint, vint)
TWO(vint, vi_sub, vint, vint)
TWO(vint, vi_mul, vint, vint)
TWO(vint, vi_and, vint, vint)
TWO(vint, vi_or, vint, vint)
TWO(vint, vi_xor, vint, vint)
TWO(vint, vi_shift_left, vint, vint)
TWO(vint, vi_shift_right, vint, vint)
TWO(vmask, vi_eq, vint, vint)
TWO(vint, vi_where, vmask, vint)
TWO(vmask, vm_and, vmask, vmask)
TWO(vmask, vm_or, vmask, vmask)
TWO(vmask, vm_xor, vmask, vmask)
TWO(vmask, vm_andnot, vmask, vmask)
ONE(vfloat, vf_abs, vfloat)
ONE(vfloat, vf_floor, vfloat)
ONE(vfloat, vf_from_vi, vint)
ONE(vint, vi_from_vf, vfloat)
ONE(vfloat, vf_power_of_2, vint)
ONE(vmask, vm_not, vmask)
TWO(vdouble, vd_add, vdouble, vdouble)
TWO(vdouble, vd_sub, vdouble, vdouble)
TWO(vdouble, vd_mul, vdouble, vdouble)
TWO(vdouble, vd_div, vdouble, vdouble)
TWO(vdouble, vd_min, vdouble, vdouble)
TWO(vdouble, vd_max, vdouble, vdouble)
ONE(vdouble, vd_from_vf, vfloat)
ONE(vfloat, vf_from_vd, vdouble)
/* clang-format on */

#undef ONE
#undef TWO
#undef THREE

static inline vfloat vf_set(float a) { return (vfloat){half_vf_set(a), half_vf_set(a)}; }
static inline vfloat vf_load(const float *a) { return (vfloat){half_vf_load(a), half_vf_load(a + half_W)}; }
static inline void vf_store(float *to, vfloat a) {
    half_vf_store(to, a.a);
    half_vf_store(to + half_W, a.b);
}
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) {
    return (vfloat){half_vf_select(m.a, a.a, b.a), half_vf_select(m.b, a.b, b.b)};
}

static inline vdouble vd_set(double a) { return (vdouble){half_vd_set(a), half_vd_set(a)}; }
static inline vdouble vd_select(vmask m, vdouble a, vdouble b) {
    return (vdouble){half_vd_select(m.a, a.a, b.a), half_vd_select(m.b, a.b, b.b)};
}

static inline vint vi_set(int32_t a) { return (vint){half_vi_set(a), half_vi_set(a)}; }
static inline vint vi_load(const int32_t *a) { return (vint){half_vi_load(a), half_vi_load(a + half_W)}; }
static inline void vi_store(int32_t *to, vint a) {
    half_vi_store(to, a.a);
    half_vi_store(to + half_W, a.b);
}
static inline vint vi_select(vmask m, vint a, vint b) {
    return (vint){half_vi_select(m.a, a.a, b.a), half_vi_select(m.b, a.b, b.b)};
}
static inline vint vi_lookup(const int32_t table[16], vint k) {
    return (vint){half_vi_lookup(table, k.a), half_vi_lookup(table, k.b)};
}

static inline vmask vm_set(bool a) { return (vmask){half_vm_set(a), half_vm_set(a)}; }
static inline vmask vm_first(size_t n) { return (vmask){half_vm_first(n), half_vm_first(n < half_W ? 0 : n - half_W)}; }
static inline vmask vm_from_bits(unsigned bits) {
    return (vmask){half_vm_from_bits(bits), half_vm_from_bits(bits >> half_W)};
}
static inline bool vm_any(vmask a) { return half_vm_any(half_vm_or(a.a, a.b)); }
static inline unsigned vm_bits(vmask a) { return half_vm_bits(a.a) | half_vm_bits(a.b) << half_W; }

static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    return (vfloat){half_vf_gather(base, index.a, m.a), half_vf_gather(base, index.b, m.b)};
}
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    half_vf_gather_pairs(base, index.a, m.a, &first->a, &second->a);
    half_vf_gather_pairs(base, index.b, m.b, &first->b, &second->b);
}

/* Puts n vectors together from their halves. */
static inline void twice_join(const half_vfloat *a, const half_vfloat *b, vfloat *out, size_t n) {
    for (size_t k = 0; k < n; k++) out[k] = (vfloat){a[k], b[k]};
}
CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    half_vfloat a[4], b[4];
    half_vf_gather_quads(base, index.a, m.a, a);
    half_vf_gather_quads(base, index.b, m.b, b);
    twice_join(a, b, out, 4);
}
CW_INLINE void vf_load_each_ray(const cw_ray *const rays[2 * half_W], vfloat out[8]) {
    half_vfloat a[8], b[8];
    half_vf_load_each_ray(rays, a);
    half_vf_load_each_ray(rays + half_W, b);
    twice_join(a, b, out, 8);
}
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    half_vfloat a[8], b[8];
    half_vf_load_rays(rays, a);
    half_vf_load_rays(rays + half_W, b);
    twice_join(a, b, out, 8);
}

typedef struct vpick {
    half_vpick a, b;
    int of_a; /* lanes picked of a */
} vpick;
static inline vpick vpick_make(vmask m) {
    return (vpick){half_vpick_make(m.a), half_vpick_make(m.b), __builtin_popcount(half_vm_bits(m.a))};
}
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    half_vf_store_picked(to, a.a, pick.a);
    half_vf_store_picked(to + pick.of_a, a.b, pick.b);
}
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
    half_vf_store_hits(hits, t.a, u.a, v.a, i.a, j.a, b.a);
    half_vf_store_hits(hits + half_W, t.b, u.b, v.b, i.b, j.b, b.b);
}

CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    half_vfloat lower[16];
    for (int k = 0; k < 16; k++) lower[k] = half_vf_min(a[k].a, a[k].b);
    half_vf_lowest_of_each(lower, out);
}

/* vorder is the halves' own. */
static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    return (vfloat){half_vf_load_block(row, step, o, 2 * k), half_vf_load_block(row, step, o, 2 * k + 1)};
}

#endif
