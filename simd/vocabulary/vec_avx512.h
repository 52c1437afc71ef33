/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX-512 (F, VL, DQ, BW): 16 lanes, masks in mask registers. Meanings: vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX512_H
#define CELLWALK_SIMD_VEC_AVX512_H

#define W        16 /* lanes of a register */
#define X(name)  _mm512_##name
#define I32      __m512i
#define HALF_REG __m256

#include "vec_x86.h"

#define COMPARE(a, sign, b, name) _mm512_cmp_ps_mask(a, b, _CMP_##name##_OQ)
static inline mask_reg ri_eq(int_reg a, int_reg b) { return (mask_reg){_mm512_cmpeq_epi32_mask((I32)a.v, (I32)b.v)}; }
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){_mm512_mask_blend_ps(m.v, b.v, a.v)};
}
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) {
    return (int_reg){(int_lanes)_mm512_mask_blend_epi32(m.v, (I32)b.v, (I32)a.v)};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    return (double_reg){_mm512_mask_blend_pd((__mmask8)(m.v >> 8 * k), b.v, a.v)};
}
/* Fused: an exact product does not show it. Rounding is named for the test symbols, which allows no other fusion. */
static inline float_reg rf_mul_sub(float_reg a, float_reg b, float_reg c) {
    return (float_reg){_mm512_fmsub_round_ps(a.v, b.v, c.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC)};
}
static inline int_reg ri_where(mask_reg m, int_reg a) {
    return (int_reg){(int_lanes)_mm512_maskz_mov_epi32(m.v, (I32)a.v)};
}
static inline int_reg ri_lookup(const table_entry table[16], int_reg k) {
    return (int_reg){(int_lanes)_mm512_permutexvar_epi32((I32)k.v, _mm512_loadu_si512(table))};
}

static inline mask_reg rm_set(bool a) { return (mask_reg){(lane_mask)(a ? 0xffff : 0)}; }
static inline mask_reg rm_from_bits(unsigned bits) { return (mask_reg){(lane_mask)bits}; }
static inline bool rm_any(mask_reg a) { return a.v != 0; }
/* In another register, or compilers make the AND of two such from comparisons, and the second waits for the first. */
static inline unsigned rm_bits(mask_reg a) {
    unsigned bits = a.v;
    __asm__("" : "+r"(bits));
    return bits;
}

static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    return (float_reg){_mm512_mask_i32gather_ps(_mm512_setzero_ps(), m.v, (I32)index.v, base, sizeof(float))};
}

static inline __m256 half_of(float_reg a, int k) {
    return k == 0 ? _mm512_castps512_ps256(a.v) : _mm512_extractf32x8_ps(a.v, 1);
}
static inline float_reg of_halves(__m256 low, __m256 high) {
    return (float_reg){_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1)};
}
static inline float_reg of_quarters(const quarter q[4]) {
    const __m512 a = _mm512_insertf32x4(_mm512_castps128_ps512(q[0]), q[1], 1);
    return (float_reg){_mm512_insertf32x4(_mm512_insertf32x4(a, q[2], 2), q[3], 3)};
}
static inline quarter quarter_of(float_reg a, int h) {
    const __m256 half = half_of(a, h / 2);
    return h % 2 == 0 ? _mm256_castps256_ps128(half) : _mm256_extractf128_ps(half, 1);
}

#endif
