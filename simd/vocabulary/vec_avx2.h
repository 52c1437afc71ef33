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

#include "vec_x86.h"

static inline float_reg rf_fma(float_reg a, float_reg b, float_reg c) {
    return (float_reg){_mm256_fmadd_ps(a.v, b.v, c.v)};
}
static inline float_reg rf_fnma(float_reg a, float_reg b, float_reg c) {
    return (float_reg){_mm256_fnmadd_ps(a.v, b.v, c.v)};
}

static inline mask_reg rf_lt(float_reg a, float_reg b) { return (mask_reg){_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
static inline mask_reg rf_le(float_reg a, float_reg b) { return (mask_reg){_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
static inline mask_reg rf_gt(float_reg a, float_reg b) { return (mask_reg){_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)}; }
static inline mask_reg rf_ge(float_reg a, float_reg b) { return (mask_reg){_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
static inline mask_reg rf_eq(float_reg a, float_reg b) { return (mask_reg){_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)}; }

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

/* Lanes that are not negative, two a register, which halves the number of extractions. (GCC builds an array of all
 * eight in memory, and loads then wait for it.) */
typedef struct lane_pairs {
    uint64_t pair[4];
} lane_pairs;
static inline lane_pairs lanes_out(__m256i a) {
    const __m128i low = _mm256_castsi256_si128(a), high = _mm256_extracti128_si256(a, 1);
    return (lane_pairs){{(uint64_t)_mm_cvtsi128_si64(low), (uint64_t)_mm_extract_epi64(low, 1),
                         (uint64_t)_mm_cvtsi128_si64(high), (uint64_t)_mm_extract_epi64(high, 1)}};
}
static inline size_t lane_out(lane_pairs a, int k) {
    return k % 2 == 0 ? (uint32_t)a.pair[k / 2] : (size_t)(a.pair[k / 2] >> 32);
}

/* Each pair as one 8-byte load; shuffles then separate the two floats. CPUs that split a gather into dozens of
 * operations take less time for both vectors this way than for one gather. */
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    const lane_pairs k = lanes_out(_mm256_and_si256(index.v, _mm256_castps_si256(m.v)));
    __m128 q[4];
    for (int p = 0; p < 4; p++) {
        q[p] = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(base + lane_out(k, 2 * p))));
        q[p] = _mm_loadh_pi(q[p], (const __m64 *)(base + lane_out(k, 2 * p + 1)));
    }
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(q[0]), q[2], 1);
    const __m256 high = _mm256_insertf128_ps(_mm256_castps128_ps256(q[1]), q[3], 1);
    first->v = _mm256_shuffle_ps(low, high, 0x88);
    second->v = _mm256_shuffle_ps(low, high, 0xdd);
}

/* Lanes k and k + 4 share a register. Indices are doubled as a vector, so that an address's own factor of 8 makes 16 bytes
 * of them. */
CW_INLINE void rf_gather_quads(const float *base, int_reg index, mask_reg m, float_reg out[4]) {
    const __m256i safe = _mm256_and_si256(index.v, _mm256_castps_si256(m.v));
    const lane_pairs k = lanes_out(_mm256_add_epi32(safe, safe));
    __m256 r[4];
    for (int q = 0; q < 4; q++)
        r[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(base + 2 * lane_out(k, q))),
                                    _mm_load_ps(base + 2 * lane_out(k, q + 4)), 1);
    transpose(r, out);
}
CW_INLINE void rf_load_quads(const float *const at[8], float_reg out[4]) {
    __m256 r[4];
    for (int q = 0; q < 4; q++)
        r[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(at[q])), _mm_loadu_ps(at[q + 4]), 1);
    transpose(r, out);
}

/* Members in pairs of two; a hit is three pairs, four hits are three registers. Unpacking leaves pairs of lanes 0, 1
 * and 4, 5 in one register, of 2, 3 and 6, 7 in the other; the halves of registers are put in order as they are
 * stored. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
    const __m256 whole_i = _mm256_castsi256_ps(_mm256_cvttps_epi32(i.v));
    const __m256 whole_j = _mm256_castsi256_ps(_mm256_cvttps_epi32(j.v));
    const __m256 in_b = _mm256_and_ps(b.v, _mm256_castsi256_ps(_mm256_set1_epi32(1)));
    float *to = (float *)hits;
    for (int half = 0; half < 2; half++, to += 12) {
        const __m256d ti = _mm256_castps_pd(half ? _mm256_unpackhi_ps(t.v, whole_i) : _mm256_unpacklo_ps(t.v, whole_i));
        const __m256d jb =
            _mm256_castps_pd(half ? _mm256_unpackhi_ps(whole_j, in_b) : _mm256_unpacklo_ps(whole_j, in_b));
        const __m256d uv = _mm256_castps_pd(half ? _mm256_unpackhi_ps(u.v, v.v) : _mm256_unpacklo_ps(u.v, v.v));
        const __m256 a = _mm256_castpd_ps(_mm256_unpacklo_pd(ti, jb));
        const __m256 m = _mm256_castpd_ps(_mm256_shuffle_pd(uv, ti, 10));
        const __m256 z = _mm256_castpd_ps(_mm256_unpackhi_pd(jb, uv));
        _mm256_storeu_ps(to, _mm256_permute2f128_ps(a, m, 0x20));
        _mm_storeu_ps(to + 8, _mm256_castps256_ps128(z));
        _mm256_storeu_ps(to + 24, _mm256_permute2f128_ps(a, m, 0x31));
        _mm_storeu_ps(to + 32, _mm256_extractf128_ps(z, 1));
    }
}

/* By eights: a transpose in which each step takes minima. */
CW_INLINE void rf_lowest_of_each(const float_reg a[16], float out[16]) {
    for (int k = 0; k < 16; k += 8) {
        __m256 half[4]; /* of vectors k + q and k + 4 + q, a half each */
        for (int q = 0; q < 4; q++)
            half[q] = _mm256_min_ps(_mm256_permute2f128_ps(a[k + q].v, a[k + 4 + q].v, 0x20),
                                    _mm256_permute2f128_ps(a[k + q].v, a[k + 4 + q].v, 0x31));
        const __m256 ab = _mm256_min_ps(_mm256_unpacklo_ps(half[0], half[1]), _mm256_unpackhi_ps(half[0], half[1]));
        const __m256 cd = _mm256_min_ps(_mm256_unpacklo_ps(half[2], half[3]), _mm256_unpackhi_ps(half[2], half[3]));
        _mm256_storeu_ps(out + k, _mm256_min_ps(_mm256_shuffle_ps(ab, cd, 0x44), _mm256_shuffle_ps(ab, cd, 0xee)));
    }
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

typedef struct vorder {
    int flip_x, flip_y;
    __m256i column; /* lane shuffle that turns each row of 4 round where flip_x */
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) {
    const __m256i same = _mm256_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3), turned = _mm256_setr_epi32(3, 2, 1, 0, 3, 2, 1, 0);
    return (vorder){up_x ? 0 : 3, up_y ? 0 : 3, up_x ? same : turned};
}

static inline float_reg rf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    const float *near = row + (ptrdiff_t)(2 * k) * step;
    const __m256 rows = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(near)), _mm_loadu_ps(near + step), 1);
    return (float_reg){_mm256_permutevar_ps(rows, o->column)};
}

#endif
