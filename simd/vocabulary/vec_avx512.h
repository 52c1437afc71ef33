/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX-512 (F, VL, DQ, BW): 16 lanes, masks in mask registers. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX512_H
#define CELLWALK_SIMD_VEC_AVX512_H

#include "cellwalk.h"

#include <immintrin.h>
#include <stddef.h>

enum { W = 16 };

typedef struct vfloat {
    __m512 v;
} vfloat;
typedef struct vint {
    __m512i v;
} vint;
typedef struct vmask {
    __mmask16 v;
} vmask;

static inline vfloat vf_set(float a) { return (vfloat){_mm512_set1_ps(a)}; }
static inline vfloat vf_load(const float *a) { return (vfloat){_mm512_loadu_ps(a)}; }
static inline void vf_store(float *to, vfloat a) { _mm512_storeu_ps(to, a.v); }
static inline vfloat vf_add(vfloat a, vfloat b) { return (vfloat){_mm512_add_ps(a.v, b.v)}; }
static inline vfloat vf_sub(vfloat a, vfloat b) { return (vfloat){_mm512_sub_ps(a.v, b.v)}; }
static inline vfloat vf_mul(vfloat a, vfloat b) { return (vfloat){_mm512_mul_ps(a.v, b.v)}; }
static inline vfloat vf_div(vfloat a, vfloat b) { return (vfloat){_mm512_div_ps(a.v, b.v)}; }
static inline vfloat vf_min(vfloat a, vfloat b) { return (vfloat){_mm512_min_ps(a.v, b.v)}; }
static inline vfloat vf_max(vfloat a, vfloat b) { return (vfloat){_mm512_max_ps(a.v, b.v)}; }
static inline vfloat vf_abs(vfloat a) { return (vfloat){_mm512_abs_ps(a.v)}; }
static inline vfloat vf_floor(vfloat a) { return (vfloat){_mm512_floor_ps(a.v)}; }

static inline vmask vf_lt(vfloat a, vfloat b) { return (vmask){_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
static inline vmask vf_le(vfloat a, vfloat b) { return (vmask){_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
static inline vmask vf_gt(vfloat a, vfloat b) { return (vmask){_mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ)}; }
static inline vmask vf_ge(vfloat a, vfloat b) { return (vmask){_mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ)}; }
static inline vmask vf_eq(vfloat a, vfloat b) { return (vmask){_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)}; }
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) { return (vfloat){_mm512_mask_blend_ps(m.v, b.v, a.v)}; }

static inline vint vi_set(int32_t a) { return (vint){_mm512_set1_epi32(a)}; }
static inline void vi_store(int32_t *to, vint a) { _mm512_storeu_si512(to, a.v); }
static inline vint vi_add(vint a, vint b) { return (vint){_mm512_add_epi32(a.v, b.v)}; }
static inline vint vi_mul(vint a, vint b) { return (vint){_mm512_mullo_epi32(a.v, b.v)}; }
static inline vint vi_select(vmask m, vint a, vint b) { return (vint){_mm512_mask_blend_epi32(m.v, b.v, a.v)}; }
static inline vint vi_from_vf(vfloat a) { return (vint){_mm512_cvttps_epi32(a.v)}; }

static inline vfloat vf_from_vi(vint a) { return (vfloat){_mm512_cvtepi32_ps(a.v)}; }
static inline vint vi_load(const int32_t *a) { return (vint){_mm512_loadu_si512(a)}; }
static inline vint vi_and(vint a, vint b) { return (vint){_mm512_and_si512(a.v, b.v)}; }
static inline vint vi_or(vint a, vint b) { return (vint){_mm512_or_si512(a.v, b.v)}; }
static inline vint vi_xor(vint a, vint b) { return (vint){_mm512_xor_si512(a.v, b.v)}; }
static inline vint vi_sub(vint a, vint b) { return (vint){_mm512_sub_epi32(a.v, b.v)}; }
static inline vint vi_shift_right(vint a, vint by) { return (vint){_mm512_srlv_epi32(a.v, by.v)}; }
static inline vint vi_shift_left(vint a, vint by) { return (vint){_mm512_sllv_epi32(a.v, by.v)}; }
static inline vmask vi_eq(vint a, vint b) { return (vmask){_mm512_cmpeq_epi32_mask(a.v, b.v)}; }
static inline vint vi_lookup(const int32_t table[16], vint k) {
    return (vint){_mm512_permutexvar_epi32(k.v, _mm512_loadu_si512(table))};
}

static inline vint vi_where(vmask m, vint a) { return (vint){_mm512_maskz_mov_epi32(m.v, a.v)}; }
static inline vfloat vf_flip(vfloat a, vfloat sign) {
    return (vfloat){_mm512_castsi512_ps(_mm512_xor_si512(_mm512_castps_si512(a.v), _mm512_castps_si512(sign.v)))};
}
static inline vfloat vf_power_of_2(vint k) {
    return (vfloat){_mm512_castsi512_ps(_mm512_slli_epi32(_mm512_add_epi32(k.v, _mm512_set1_epi32(127)), 23))};
}

static inline vmask vm_and(vmask a, vmask b) { return (vmask){(__mmask16)(a.v & b.v)}; }
static inline vmask vm_or(vmask a, vmask b) { return (vmask){(__mmask16)(a.v | b.v)}; }
static inline vmask vm_xor(vmask a, vmask b) { return (vmask){(__mmask16)(a.v ^ b.v)}; }
static inline vmask vm_andnot(vmask a, vmask b) { return (vmask){(__mmask16)(a.v & ~b.v)}; }
static inline vmask vm_not(vmask a) { return (vmask){(__mmask16)~a.v}; }
static inline vmask vm_first(size_t n) { return (vmask){(__mmask16)(n >= W ? 0xffff : (1u << n) - 1)}; }
static inline vmask vm_from_bits(unsigned bits) { return (vmask){(__mmask16)bits}; }
static inline bool vm_any(vmask a) { return a.v != 0; }
static inline unsigned vm_bits(vmask a) { return a.v; }

static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    return (vfloat){_mm512_mask_i32gather_ps(_mm512_setzero_ps(), m.v, index.v, base, sizeof(float))};
}

/* A pair as one gathered double: half the loads. Where CELLWALK_PAIRS is defined, 8-byte loads
 * put together by shuffles, as for AVX2: faster for the lane walk, slower for packet16 (papers/walks.md). */
#ifdef CELLWALK_PAIRS
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    int32_t k[16];
    _mm512_storeu_si512(k, _mm512_maskz_mov_epi32(m.v, index.v));
    __m512 r[2]; /* in quarter number p: lanes 4 p and 4 p + 1; the two after them */
    for (int h = 0; h < 2; h++) {
        __m128 q[4];
        for (int p = 0; p < 4; p++) {
            q[p] = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(base + k[4 * p + 2 * h])));
            q[p] = _mm_loadh_pi(q[p], (const __m64 *)(base + k[4 * p + 2 * h + 1]));
        }
        r[h] = _mm512_insertf32x4(_mm512_castps128_ps512(q[0]), q[1], 1);
        r[h] = _mm512_insertf32x4(r[h], q[2], 2);
        r[h] = _mm512_insertf32x4(r[h], q[3], 3);
    }
    first->v = _mm512_shuffle_ps(r[0], r[1], 0x88);
    second->v = _mm512_shuffle_ps(r[0], r[1], 0xdd);
}
#else
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    const __m512i safe = _mm512_maskz_mov_epi32(m.v, index.v);
    const __m512 a = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(safe), base, sizeof(float)));
    const __m512 b = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(safe, 1), base, sizeof(float)));
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    first->v = _mm512_permutex2var_ps(a, even, b);
    second->v = _mm512_permutex2var_ps(a, _mm512_add_epi32(even, _mm512_set1_epi32(1)), b);
}
#endif

/* Lanes k and k + 4, k + 8, k + 12 share a register in quarters, as in vf_load_rays. */
CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    int32_t k[16];
    _mm512_storeu_si512(k, _mm512_maskz_mov_epi32(m.v, index.v));
    __m512 r[4];
    for (int q = 0; q < 4; q++) {
        r[q] = _mm512_castps128_ps512(_mm_load_ps(base + 4 * (ptrdiff_t)k[q]));
        r[q] = _mm512_insertf32x4(r[q], _mm_load_ps(base + 4 * (ptrdiff_t)k[q + 4]), 1);
        r[q] = _mm512_insertf32x4(r[q], _mm_load_ps(base + 4 * (ptrdiff_t)k[q + 8]), 2);
        r[q] = _mm512_insertf32x4(r[q], _mm_load_ps(base + 4 * (ptrdiff_t)k[q + 12]), 3);
    }
    const __m512 a = _mm512_unpacklo_ps(r[0], r[1]), b = _mm512_unpackhi_ps(r[0], r[1]);
    const __m512 c = _mm512_unpacklo_ps(r[2], r[3]), d = _mm512_unpackhi_ps(r[2], r[3]);
    out[0].v = _mm512_shuffle_ps(a, c, 0x44);
    out[1].v = _mm512_shuffle_ps(a, c, 0xee);
    out[2].v = _mm512_shuffle_ps(b, d, 0x44);
    out[3].v = _mm512_shuffle_ps(b, d, 0xee);
}

/* Rays k and k + 4, k + 8, k + 12 share a register in quarters, so that the 4 × 4 transposes within quarters do. */
CW_INLINE void vf_load_each_ray(const cw_ray *const rays[16], vfloat out[8]) {
    for (int half = 0; half < 2; half++) {
        __m512 r[4];
        for (int k = 0; k < 4; k++) {
            r[k] = _mm512_castps128_ps512(_mm_loadu_ps((const float *)rays[k] + 4 * half));
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps((const float *)rays[k + 4] + 4 * half), 1);
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps((const float *)rays[k + 8] + 4 * half), 2);
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps((const float *)rays[k + 12] + 4 * half), 3);
        }
        const __m512 low01 = _mm512_unpacklo_ps(r[0], r[1]), high01 = _mm512_unpackhi_ps(r[0], r[1]);
        const __m512 low23 = _mm512_unpacklo_ps(r[2], r[3]), high23 = _mm512_unpackhi_ps(r[2], r[3]);
        out[4 * half + 0].v = _mm512_shuffle_ps(low01, low23, 0x44);
        out[4 * half + 1].v = _mm512_shuffle_ps(low01, low23, 0xee);
        out[4 * half + 2].v = _mm512_shuffle_ps(high01, high23, 0x44);
        out[4 * half + 3].v = _mm512_shuffle_ps(high01, high23, 0xee);
    }
}

/* Two rays a register: transposed within quarters by fours, then each member's lanes are put in order. 8 loads and 24
 * shuffles; put together from quarters as above there are 32 and 16. */
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    const __m512i order = _mm512_setr_epi32(0, 8, 1, 9, 2, 10, 3, 11, 16, 24, 17, 25, 18, 26, 19, 27);
    const __m512i order4 = _mm512_add_epi32(order, _mm512_set1_epi32(4));
    __m512 member[2][4]; /* of rays 0 to 7, 8 to 15: 0, 2, 4, 6 and 1, 3, 5, 7, members k and k + 4 */
    for (int half = 0; half < 2; half++) {
        __m512 r[4];
        for (int k = 0; k < 4; k++) r[k] = _mm512_loadu_ps((const float *)(rays + 8 * half + 2 * k));
        const __m512 low01 = _mm512_unpacklo_ps(r[0], r[1]), high01 = _mm512_unpackhi_ps(r[0], r[1]);
        const __m512 low23 = _mm512_unpacklo_ps(r[2], r[3]), high23 = _mm512_unpackhi_ps(r[2], r[3]);
        member[half][0] = _mm512_shuffle_ps(low01, low23, 0x44);
        member[half][1] = _mm512_shuffle_ps(low01, low23, 0xee);
        member[half][2] = _mm512_shuffle_ps(high01, high23, 0x44);
        member[half][3] = _mm512_shuffle_ps(high01, high23, 0xee);
    }
    for (int k = 0; k < 4; k++) {
        out[k].v = _mm512_permutex2var_ps(member[0][k], order, member[1][k]);
        out[4 + k].v = _mm512_permutex2var_ps(member[0][k], order4, member[1][k]);
    }
}

typedef struct vpick {
    __mmask16 lanes;
} vpick;
static inline vpick vpick_make(vmask m) { return (vpick){m.v}; }
/* Compressed in a register first: the compressing store to memory is slow on some CPUs (papers/walks.md). */
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    _mm512_storeu_ps(to, _mm512_maskz_compress_ps(pick.lanes, a.v));
}

/* Members in pairs of two; a hit is three pairs, eight hits are three registers. Unpacking leaves the pairs of lanes 0, 1,
 * 4, 5, 8, 9, 12, 13 in one register and the others in the second. */
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
    const __m512 whole_i = _mm512_castsi512_ps(_mm512_cvttps_epi32(i.v));
    const __m512 whole_j = _mm512_castsi512_ps(_mm512_cvttps_epi32(j.v));
    const __m512 in_b = _mm512_castsi512_ps(_mm512_maskz_set1_epi32(b.v, 1));
    const __m512d ti[2] = {_mm512_castps_pd(_mm512_unpacklo_ps(t.v, whole_i)),
                           _mm512_castps_pd(_mm512_unpackhi_ps(t.v, whole_i))};
    const __m512d jb[2] = {_mm512_castps_pd(_mm512_unpacklo_ps(whole_j, in_b)),
                           _mm512_castps_pd(_mm512_unpackhi_ps(whole_j, in_b))};
    const __m512d uv[2] = {_mm512_castps_pd(_mm512_unpacklo_ps(u.v, v.v)),
                           _mm512_castps_pd(_mm512_unpackhi_ps(u.v, v.v))};
    /* Within quarters as for SSE: hits 4 q + 2 h and the next are the quarters q of a, m and z, one after the other. */
    __m512 r[2][3];
    for (int h = 0; h < 2; h++) {
        r[h][0] = _mm512_castpd_ps(_mm512_unpacklo_pd(ti[h], jb[h]));
        r[h][1] = _mm512_castpd_ps(_mm512_shuffle_pd(uv[h], ti[h], 0xaa));
        r[h][2] = _mm512_castpd_ps(_mm512_unpackhi_pd(jb[h], uv[h]));
    }
    /* Of each quarter number q in turn: a0 m0 z0 a1 | m1 z1. */
    const __m512 am = _mm512_shuffle_f32x4(r[0][0], r[0][1], 0x44),
                 am_high = _mm512_shuffle_f32x4(r[0][0], r[0][1], 0xee);
    const __m512 za = _mm512_shuffle_f32x4(r[0][2], r[1][0], 0x44),
                 za_high = _mm512_shuffle_f32x4(r[0][2], r[1][0], 0xee);
    const __m512 mz = _mm512_shuffle_f32x4(r[1][1], r[1][2], 0x44),
                 mz_high = _mm512_shuffle_f32x4(r[1][1], r[1][2], 0xee);
    /* am: a0 a1 m0 m1 by quarters q = 0, 1; picking even places gives q = 0, odd ones q = 1. */
    float *to = (float *)hits;
    for (int high = 0; high < 2; high++, to += 48) {
        const __m512 x = high ? am_high : am, y = high ? za_high : za, w = high ? mz_high : mz;
        _mm512_storeu_ps(to, _mm512_shuffle_f32x4(x, y, 0x88));
        _mm512_storeu_ps(to + 16, _mm512_shuffle_f32x4(w, x, 0xd8));
        _mm512_storeu_ps(to + 32, _mm512_shuffle_f32x4(y, w, 0xdd));
    }
}

static inline vmask vm_set(bool a) { return (vmask){(__mmask16)(a ? 0xffff : 0)}; }

/* A transpose in which each step takes minima: halves, quarters, pairs, lanes. */
CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    __m512 half[8], quarter[4];
    for (int k = 0; k < 8; k++) /* of vectors k and k + 8, a half each */
        half[k] = _mm512_min_ps(_mm512_shuffle_f32x4(a[k].v, a[k + 8].v, 0x44),
                                _mm512_shuffle_f32x4(a[k].v, a[k + 8].v, 0xee));
    for (int k = 0; k < 4; k++) /* of vectors k, k + 8, k + 4 and k + 12, a quarter each */
        quarter[k] = _mm512_min_ps(_mm512_shuffle_f32x4(half[k], half[k + 4], 0x88),
                                   _mm512_shuffle_f32x4(half[k], half[k + 4], 0xdd));
    const __m512 ab =
        _mm512_min_ps(_mm512_unpacklo_ps(quarter[0], quarter[1]), _mm512_unpackhi_ps(quarter[0], quarter[1]));
    const __m512 cd =
        _mm512_min_ps(_mm512_unpacklo_ps(quarter[2], quarter[3]), _mm512_unpackhi_ps(quarter[2], quarter[3]));
    const __m512 all = _mm512_min_ps(_mm512_shuffle_ps(ab, cd, 0x44), _mm512_shuffle_ps(ab, cd, 0xee));
    _mm512_storeu_ps(out, _mm512_shuffle_f32x4(all, all, 0xd8)); /* 0, 8, 4, 12 and the three after each: in order */
}

typedef struct vdouble {
    __m512d a, b; /* lanes 0 to 7, 8 to 15 */
} vdouble;

static inline vdouble vd_set(double a) { return (vdouble){_mm512_set1_pd(a), _mm512_set1_pd(a)}; }
static inline vdouble vd_from_vf(vfloat x) {
    return (vdouble){_mm512_cvtps_pd(_mm512_castps512_ps256(x.v)), _mm512_cvtps_pd(_mm512_extractf32x8_ps(x.v, 1))};
}
static inline vfloat vf_from_vd(vdouble x) {
    return (vfloat){_mm512_insertf32x8(_mm512_castps256_ps512(_mm512_cvtpd_ps(x.a)), _mm512_cvtpd_ps(x.b), 1)};
}
static inline vdouble vd_add(vdouble x, vdouble y) {
    return (vdouble){_mm512_add_pd(x.a, y.a), _mm512_add_pd(x.b, y.b)};
}
static inline vdouble vd_sub(vdouble x, vdouble y) {
    return (vdouble){_mm512_sub_pd(x.a, y.a), _mm512_sub_pd(x.b, y.b)};
}
static inline vdouble vd_mul(vdouble x, vdouble y) {
    return (vdouble){_mm512_mul_pd(x.a, y.a), _mm512_mul_pd(x.b, y.b)};
}
static inline vdouble vd_div(vdouble x, vdouble y) {
    return (vdouble){_mm512_div_pd(x.a, y.a), _mm512_div_pd(x.b, y.b)};
}
static inline vdouble vd_min(vdouble x, vdouble y) {
    return (vdouble){_mm512_min_pd(x.a, y.a), _mm512_min_pd(x.b, y.b)};
}
static inline vdouble vd_max(vdouble x, vdouble y) {
    return (vdouble){_mm512_max_pd(x.a, y.a), _mm512_max_pd(x.b, y.b)};
}
static inline vdouble vd_select(vmask m, vdouble x, vdouble y) {
    return (vdouble){_mm512_mask_blend_pd((__mmask8)m.v, y.a, x.a),
                     _mm512_mask_blend_pd((__mmask8)(m.v >> 8), y.b, x.b)};
}

typedef struct vorder {
    int flip_x, flip_y;
    __m512i lane;
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) {
    const __m512i same = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const int flip = up_x ? 0 : 3;
    return (vorder){up_x ? 0 : 3, up_y ? 0 : 3, _mm512_xor_si512(same, _mm512_set1_epi32(flip))};
}

static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    (void)k; /* one vector is the whole block */
    __m512 rows = _mm512_castps128_ps512(_mm_loadu_ps(row));
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + step), 1);
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + 2 * step), 2);
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + 3 * step), 3);
    return (vfloat){_mm512_permutexvar_ps(o->lane, rows)};
}

#endif
