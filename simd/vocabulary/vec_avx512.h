/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX-512 (F, VL, DQ, BW): 16 lanes, masks in mask registers. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX512_H
#define CELLWALK_SIMD_VEC_AVX512_H

#define W           16 /* lanes of a register */
#define X(name)     _mm512_##name
#define X_INT(name) _mm512_##name##_si512
#define F32         __m512
#define F64         __m512d
#define I32         __m512i

#include "vec_x86.h"

typedef struct mask_reg {
    __mmask16 v;
} mask_reg;

static inline float_reg rf_fma(float_reg a, float_reg b, float_reg c) {
    return (float_reg){_mm512_fmadd_ps(a.v, b.v, c.v)};
}
static inline float_reg rf_fnma(float_reg a, float_reg b, float_reg c) {
    return (float_reg){_mm512_fnmadd_ps(a.v, b.v, c.v)};
}
static inline float_reg rf_abs(float_reg a) { return (float_reg){_mm512_abs_ps(a.v)}; }

static inline mask_reg rf_lt(float_reg a, float_reg b) { return (mask_reg){_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
static inline mask_reg rf_le(float_reg a, float_reg b) { return (mask_reg){_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
static inline mask_reg rf_gt(float_reg a, float_reg b) { return (mask_reg){_mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ)}; }
static inline mask_reg rf_ge(float_reg a, float_reg b) { return (mask_reg){_mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ)}; }
static inline mask_reg rf_eq(float_reg a, float_reg b) { return (mask_reg){_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)}; }
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){_mm512_mask_blend_ps(m.v, b.v, a.v)};
}

static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) {
    return (int_reg){_mm512_mask_blend_epi32(m.v, b.v, a.v)};
}

static inline int_reg ri_shift_right(int_reg a, int_reg by) { return (int_reg){_mm512_srlv_epi32(a.v, by.v)}; }
static inline int_reg ri_shift_left(int_reg a, int_reg by) { return (int_reg){_mm512_sllv_epi32(a.v, by.v)}; }
static inline mask_reg ri_eq(int_reg a, int_reg b) { return (mask_reg){_mm512_cmpeq_epi32_mask(a.v, b.v)}; }
static inline int_reg ri_lookup(const int32_t table[16], int_reg k) {
    return (int_reg){_mm512_permutexvar_epi32(k.v, _mm512_loadu_si512(table))};
}

static inline int_reg ri_where(mask_reg m, int_reg a) { return (int_reg){_mm512_maskz_mov_epi32(m.v, a.v)}; }

static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){(__mmask16)(a.v & b.v)}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){(__mmask16)(a.v | b.v)}; }
static inline mask_reg rm_xor(mask_reg a, mask_reg b) { return (mask_reg){(__mmask16)(a.v ^ b.v)}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){(__mmask16)(a.v & ~b.v)}; }
static inline mask_reg rm_not(mask_reg a) { return (mask_reg){(__mmask16)~a.v}; }
static inline mask_reg rm_from_bits(unsigned bits) { return (mask_reg){(__mmask16)bits}; }
static inline bool rm_any(mask_reg a) { return a.v != 0; }
static inline unsigned rm_bits(mask_reg a) { return a.v; }

static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    return (float_reg){_mm512_mask_i32gather_ps(_mm512_setzero_ps(), m.v, index.v, base, sizeof(float))};
}

/* A pair as one gathered double: half the loads. In pairs of registers, 8-byte loads
 * put together by shuffles, as for AVX2: faster for the lane walk, slower for packet16 (papers/walks.md). */
#if REGISTERS == 2
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
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
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    const __m512i safe = _mm512_maskz_mov_epi32(m.v, index.v);
    const __m512 a = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_castsi512_si256(safe), base, sizeof(float)));
    const __m512 b = _mm512_castpd_ps(_mm512_i32gather_pd(_mm512_extracti64x4_epi64(safe, 1), base, sizeof(float)));
    const __m512i even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
    first->v = _mm512_permutex2var_ps(a, even, b);
    second->v = _mm512_permutex2var_ps(a, _mm512_add_epi32(even, _mm512_set1_epi32(1)), b);
}
#endif

/* Lanes k and k + 4, k + 8, k + 12 share a register. */
CW_INLINE void rf_load_quads(const float *const at[16], float_reg out[4]) {
    __m512 r[4];
    for (int q = 0; q < 4; q++) {
        r[q] = _mm512_insertf32x4(_mm512_castps128_ps512(_mm_loadu_ps(at[q])), _mm_loadu_ps(at[q + 4]), 1);
        r[q] = _mm512_insertf32x4(r[q], _mm_loadu_ps(at[q + 8]), 2);
        r[q] = _mm512_insertf32x4(r[q], _mm_loadu_ps(at[q + 12]), 3);
    }
    transpose(r, out);
}
CW_INLINE void rf_gather_quads(const float *base, int_reg index, mask_reg m, float_reg out[4]) {
    int32_t k[16];
    const float *at[16];
    _mm512_storeu_si512(k, _mm512_maskz_mov_epi32(m.v, index.v));
    for (int q = 0; q < 16; q++) at[q] = base + 4 * (ptrdiff_t)k[q];
    rf_load_quads(at, out);
}

/* Members in pairs of two; a hit is three pairs, eight hits are three registers. Unpacking leaves the pairs of lanes 0, 1,
 * 4, 5, 8, 9, 12, 13 in one register and the others in the second. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
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

static inline mask_reg rm_set(bool a) { return (mask_reg){(__mmask16)(a ? 0xffff : 0)}; }

/* A transpose in which each step takes minima: halves, quarters, pairs, lanes. */
CW_INLINE void rf_lowest_of_each(const float_reg a[16], float out[16]) {
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

static inline double_reg rd_from_rf(float_reg a, int k) {
    return (double_reg){_mm512_cvtps_pd(k == 0 ? _mm512_castps512_ps256(a.v) : _mm512_extractf32x8_ps(a.v, 1))};
}
static inline float_reg rf_from_rd(double_reg low, double_reg high) {
    const __m512 first = _mm512_castps256_ps512(_mm512_cvtpd_ps(low.v));
    return (float_reg){_mm512_insertf32x8(first, _mm512_cvtpd_ps(high.v), 1)};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    return (double_reg){_mm512_mask_blend_pd((__mmask8)(m.v >> 8 * k), b.v, a.v)};
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

static inline float_reg rf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    (void)k; /* one vector is the whole block */
    __m512 rows = _mm512_castps128_ps512(_mm_loadu_ps(row));
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + step), 1);
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + 2 * step), 2);
    rows = _mm512_insertf32x4(rows, _mm_loadu_ps(row + 3 * step), 3);
    return (float_reg){_mm512_permutexvar_ps(o->lane, rows)};
}

#endif
