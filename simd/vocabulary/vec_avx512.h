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
#define LANE_MASK   __mmask16

#include "vec_x86.h"

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

static inline lane_indices lanes_out(int_reg index, mask_reg m) {
    lane_indices out;
    _mm512_storeu_si512(out.k, ri_where(m, index).v);
    return out;
}
static inline float_reg of_quarters(const __m128 q[4]) {
    const __m512 a = _mm512_insertf32x4(_mm512_castps128_ps512(q[0]), q[1], 1);
    return (float_reg){_mm512_insertf32x4(_mm512_insertf32x4(a, q[2], 2), q[3], 3)};
}
static inline void to_quarters(__m512 r, __m128 q[4]) {
    q[0] = _mm512_castps512_ps128(r);
    q[1] = _mm512_extractf32x4_ps(r, 1);
    q[2] = _mm512_extractf32x4_ps(r, 2);
    q[3] = _mm512_extractf32x4_ps(r, 3);
}

static inline mask_reg rm_set(bool a) { return (mask_reg){(__mmask16)(a ? 0xffff : 0)}; }

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

#endif
