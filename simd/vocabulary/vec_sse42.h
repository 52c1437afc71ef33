/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for SSE4.2: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_SSE42_H
#define CELLWALK_SIMD_VEC_SSE42_H

#define W           4 /* lanes of a register */
#define X(name)     _mm_##name
#define X_INT(name) _mm_##name##_si128
#define F32         __m128
#define F64         __m128d
#define I32         __m128i
#define LANE_MASK   __m128

#include "vec_x86.h"

/* SSE4.2 has no shift by a vector: times 2^by, put together as a float. */
static inline int_reg ri_shift_left(int_reg a, int_reg by) {
    return (int_reg){_mm_mullo_epi32(a.v, _mm_cvttps_epi32(rf_power_of_2(by).v))};
}
/* SSE4.2 has no shift by a vector: times 2^-by in floats, which hold the 24 bits of a and of the product. */
static inline int_reg ri_shift_right(int_reg a, int_reg by) {
    const __m128 power = _mm_castsi128_ps(_mm_slli_epi32(_mm_sub_epi32(_mm_set1_epi32(127), by.v), 23));
    return (int_reg){_mm_cvttps_epi32(_mm_cvtepi32_ps(a.v) * power)};
}
static inline int_reg ri_lookup(const int32_t table[16], int_reg k) {
    return (int_reg){_mm_setr_epi32(table[_mm_cvtsi128_si32(k.v)], table[_mm_extract_epi32(k.v, 1)],
                                    table[_mm_extract_epi32(k.v, 2)], table[_mm_extract_epi32(k.v, 3)])};
}

static inline mask_reg rm_from_bits(unsigned bits) {
    const __m128i bit = _mm_setr_epi32(1, 2, 4, 8);
    return (mask_reg){_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int32_t)bits), bit), bit))};
}

static inline lane_indices lanes_out(int_reg index, mask_reg m) {
    const __m128i safe = _mm_and_si128(index.v, _mm_castps_si128(m.v));
    const uint64_t low = (uint64_t)_mm_cvtsi128_si64(safe), high = (uint64_t)_mm_extract_epi64(safe, 1);
    return (lane_indices){{(uint32_t)low, (uint32_t)(low >> 32), (uint32_t)high, (uint32_t)(high >> 32)}};
}
static inline float_reg of_quarters(const __m128 q[1]) { return (float_reg){q[0]}; }
static inline void to_quarters(__m128 r, __m128 q[1]) { q[0] = r; }

/* No gather instruction: lanes one by one, those outside m from base[0]. */
static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    const lane_indices at = lanes_out(index, m);
    const __m128 a = _mm_load_ss(base + at.k[0]), b = _mm_load_ss(base + at.k[1]);
    const __m128 c = _mm_load_ss(base + at.k[2]), d = _mm_load_ss(base + at.k[3]);
    return (float_reg){_mm_and_ps(_mm_movelh_ps(_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d)), m.v)};
}

static inline double_reg rd_from_rf(float_reg a, int k) {
    return (double_reg){_mm_cvtps_pd(k == 0 ? a.v : _mm_movehl_ps(a.v, a.v))};
}
static inline float_reg rf_from_rd(double_reg low, double_reg high) {
    return (float_reg){_mm_movelh_ps(_mm_cvtpd_ps(low.v), _mm_cvtpd_ps(high.v))};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    const __m128 twice = k == 0 ? _mm_unpacklo_ps(m.v, m.v) : _mm_unpackhi_ps(m.v, m.v);
    return (double_reg){_mm_blendv_pd(b.v, a.v, _mm_castps_pd(twice))};
}

#endif
