/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX2: 8 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX2_H
#define CELLWALK_SIMD_VEC_AVX2_H

#define W           8 /* lanes of a register */
#define X(name)     _mm256_##name
#define X_INT(name) _mm256_##name##_si256
#define F32         __m256
#define F64         __m256d
#define I32         __m256i
#define LANE_MASK   __m256

#include "vec_x86.h"

static inline int_reg ri_shift_right(int_reg a, int_reg by) { return (int_reg){_mm256_srlv_epi32(a.v, by.v)}; }
static inline int_reg ri_shift_left(int_reg a, int_reg by) { return (int_reg){_mm256_sllv_epi32(a.v, by.v)}; }
static inline int_reg ri_lookup(const int32_t table[16], int_reg k) {
    const __m256i *halves = (const __m256i *)table;
    const __m256 low = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves), k.v));
    const __m256 high = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves + 1), k.v));
    const __m256 upper = _mm256_castsi256_ps(_mm256_slli_epi32(k.v, 28)); /* bit 3 as the sign */
    return (int_reg){_mm256_castps_si256(_mm256_blendv_ps(low, high, upper))};
}

static inline mask_reg rm_from_bits(unsigned bits) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return (mask_reg){
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int32_t)bits), bit), bit))};
}

static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    return (float_reg){_mm256_mask_i32gather_ps(_mm256_setzero_ps(), base, index.v, m.v, sizeof(float))};
}

/* Two a register, which halves the number of extractions. (GCC builds an array of all eight in memory, and loads then wait for
 * it.) */
static inline lane_indices lanes_out(int_reg index, mask_reg m) {
    const __m256i safe = _mm256_and_si256(index.v, _mm256_castps_si256(m.v));
    const __m128i half[2] = {_mm256_castsi256_si128(safe), _mm256_extracti128_si256(safe, 1)};
    lane_indices out;
    for (int h = 0; h < 2; h++) {
        const uint64_t low = (uint64_t)_mm_cvtsi128_si64(half[h]), high = (uint64_t)_mm_extract_epi64(half[h], 1);
        out.k[4 * h] = (uint32_t)low;
        out.k[4 * h + 1] = (uint32_t)(low >> 32);
        out.k[4 * h + 2] = (uint32_t)high;
        out.k[4 * h + 3] = (uint32_t)(high >> 32);
    }
    return out;
}
static inline float_reg of_quarters(const __m128 q[2]) {
    return (float_reg){_mm256_insertf128_ps(_mm256_castps128_ps256(q[0]), q[1], 1)};
}
static inline void to_quarters(__m256 r, __m128 q[2]) {
    q[0] = _mm256_castps256_ps128(r);
    q[1] = _mm256_extractf128_ps(r, 1);
}

static inline double_reg rd_from_rf(float_reg a, int k) {
    return (double_reg){_mm256_cvtps_pd(k == 0 ? _mm256_castps256_ps128(a.v) : _mm256_extractf128_ps(a.v, 1))};
}
static inline float_reg rf_from_rd(double_reg low, double_reg high) {
    const __m256 first = _mm256_castps128_ps256(_mm256_cvtpd_ps(low.v));
    return (float_reg){_mm256_insertf128_ps(first, _mm256_cvtpd_ps(high.v), 1)};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    const __m256i bits = _mm256_castps_si256(m.v);
    const __m256i wide =
        _mm256_cvtepi32_epi64(k == 0 ? _mm256_castsi256_si128(bits) : _mm256_extracti128_si256(bits, 1));
    return (double_reg){_mm256_blendv_pd(b.v, a.v, _mm256_castsi256_pd(wide))};
}

#endif
