/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX2: 8 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX2_H
#define CELLWALK_SIMD_VEC_AVX2_H

#define W        8 /* lanes of a register */
#define X(name)  _mm256_##name
#define I32      __m256i
#define HALF_REG __m128

#include "vec_x86.h"

static inline int_reg ri_lookup(const table_entry table[16], int_reg k) {
    const __m256i *halves = (const __m256i *)table, at = (__m256i)k.v;
    const __m256 low = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves), at));
    const __m256 high = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves + 1), at));
    return (int_reg){(int_lanes)_mm256_blendv_ps(low, high, (__m256)(k.v << 28))}; /* bit 3 as the sign */
}

static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    return (float_reg){
        _mm256_mask_i32gather_ps(_mm256_setzero_ps(), base, (__m256i)index.v, (__m256)m.v, sizeof(float))};
}

static inline __m128 half_of(float_reg a, int k) {
    return k == 0 ? _mm256_castps256_ps128(a.v) : _mm256_extractf128_ps(a.v, 1);
}
static inline float_reg of_halves(__m128 low, __m128 high) {
    return (float_reg){_mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1)};
}
static inline float_reg of_quarters(const quarter q[2]) { return of_halves(q[0], q[1]); }
static inline quarter quarter_of(float_reg a, int h) { return half_of(a, h); }

#endif
