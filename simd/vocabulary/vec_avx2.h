/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for AVX2: 8 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_AVX2_H
#define CELLWALK_SIMD_VEC_AVX2_H

#include "cellwalk.h"

#include <immintrin.h>
#include <stddef.h>

enum { W = 8 };

typedef struct vfloat {
    __m256 v;
} vfloat;
typedef struct vint {
    __m256i v;
} vint;
typedef struct vmask {
    __m256 v;
} vmask;

static inline vfloat vf_set(float a) { return (vfloat){_mm256_set1_ps(a)}; }
static inline vfloat vf_load(const float *a) { return (vfloat){_mm256_loadu_ps(a)}; }
static inline void vf_store(float *to, vfloat a) { _mm256_storeu_ps(to, a.v); }
static inline vfloat vf_add(vfloat a, vfloat b) { return (vfloat){_mm256_add_ps(a.v, b.v)}; }
static inline vfloat vf_sub(vfloat a, vfloat b) { return (vfloat){_mm256_sub_ps(a.v, b.v)}; }
static inline vfloat vf_mul(vfloat a, vfloat b) { return (vfloat){_mm256_mul_ps(a.v, b.v)}; }
static inline vfloat vf_div(vfloat a, vfloat b) { return (vfloat){_mm256_div_ps(a.v, b.v)}; }
static inline vfloat vf_min(vfloat a, vfloat b) { return (vfloat){_mm256_min_ps(a.v, b.v)}; }
static inline vfloat vf_max(vfloat a, vfloat b) { return (vfloat){_mm256_max_ps(a.v, b.v)}; }
static inline vfloat vf_abs(vfloat a) { return (vfloat){_mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v)}; }
static inline vfloat vf_floor(vfloat a) { return (vfloat){_mm256_floor_ps(a.v)}; }

static inline vmask vf_lt(vfloat a, vfloat b) { return (vmask){_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
static inline vmask vf_le(vfloat a, vfloat b) { return (vmask){_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
static inline vmask vf_gt(vfloat a, vfloat b) { return (vmask){_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)}; }
static inline vmask vf_ge(vfloat a, vfloat b) { return (vmask){_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
static inline vmask vf_eq(vfloat a, vfloat b) { return (vmask){_mm256_cmp_ps(a.v, b.v, _CMP_EQ_OQ)}; }
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) { return (vfloat){_mm256_blendv_ps(b.v, a.v, m.v)}; }

static inline vint vi_set(int32_t a) { return (vint){_mm256_set1_epi32(a)}; }
static inline void vi_store(int32_t *to, vint a) { _mm256_storeu_si256((__m256i *)to, a.v); }
static inline vint vi_add(vint a, vint b) { return (vint){_mm256_add_epi32(a.v, b.v)}; }
static inline vint vi_mul(vint a, vint b) { return (vint){_mm256_mullo_epi32(a.v, b.v)}; }
static inline vint vi_select(vmask m, vint a, vint b) {
    return (vint){_mm256_blendv_epi8(b.v, a.v, _mm256_castps_si256(m.v))};
}
static inline vint vi_from_vf(vfloat a) { return (vint){_mm256_cvttps_epi32(a.v)}; }

static inline vfloat vf_from_vi(vint a) { return (vfloat){_mm256_cvtepi32_ps(a.v)}; }
static inline vint vi_load(const int32_t *a) { return (vint){_mm256_loadu_si256((const __m256i *)a)}; }
static inline vint vi_and(vint a, vint b) { return (vint){_mm256_and_si256(a.v, b.v)}; }
static inline vint vi_or(vint a, vint b) { return (vint){_mm256_or_si256(a.v, b.v)}; }
static inline vint vi_xor(vint a, vint b) { return (vint){_mm256_xor_si256(a.v, b.v)}; }
static inline vint vi_sub(vint a, vint b) { return (vint){_mm256_sub_epi32(a.v, b.v)}; }
static inline vint vi_shift_right(vint a, vint by) { return (vint){_mm256_srlv_epi32(a.v, by.v)}; }
static inline vint vi_shift_left(vint a, vint by) { return (vint){_mm256_sllv_epi32(a.v, by.v)}; }
static inline vmask vi_eq(vint a, vint b) { return (vmask){_mm256_castsi256_ps(_mm256_cmpeq_epi32(a.v, b.v))}; }
static inline vint vi_lookup(const int32_t table[16], vint k) {
    const __m256i *halves = (const __m256i *)table;
    const __m256 low = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves), k.v));
    const __m256 high = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(halves + 1), k.v));
    const __m256 upper = _mm256_castsi256_ps(_mm256_slli_epi32(k.v, 28)); /* bit 3 as the sign */
    return (vint){_mm256_castps_si256(_mm256_blendv_ps(low, high, upper))};
}

static inline vint vi_where(vmask m, vint a) { return (vint){_mm256_and_si256(a.v, _mm256_castps_si256(m.v))}; }
static inline vfloat vf_flip(vfloat a, vfloat sign) { return (vfloat){_mm256_xor_ps(a.v, sign.v)}; }
static inline vfloat vf_power_of_2(vint k) {
    return (vfloat){_mm256_castsi256_ps(_mm256_slli_epi32(_mm256_add_epi32(k.v, _mm256_set1_epi32(127)), 23))};
}

static inline vmask vm_and(vmask a, vmask b) { return (vmask){_mm256_and_ps(a.v, b.v)}; }
static inline vmask vm_or(vmask a, vmask b) { return (vmask){_mm256_or_ps(a.v, b.v)}; }
static inline vmask vm_xor(vmask a, vmask b) { return (vmask){_mm256_xor_ps(a.v, b.v)}; }
static inline vmask vm_andnot(vmask a, vmask b) { return (vmask){_mm256_andnot_ps(b.v, a.v)}; }
static inline vmask vm_not(vmask a) { return (vmask){_mm256_xor_ps(a.v, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))}; }
static inline vmask vm_first(size_t n) {
    const __m256i lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    return (vmask){_mm256_castsi256_ps(_mm256_cmpgt_epi32(_mm256_set1_epi32((int32_t)n), lane))};
}
static inline vmask vm_from_bits(unsigned bits) {
    const __m256i bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return (vmask){
        _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int32_t)bits), bit), bit))};
}
static inline bool vm_any(vmask a) { return _mm256_movemask_ps(a.v) != 0; }
static inline unsigned vm_bits(vmask a) { return (unsigned)_mm256_movemask_ps(a.v); }

static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    return (vfloat){_mm256_mask_i32gather_ps(_mm256_setzero_ps(), base, index.v, m.v, sizeof(float))};
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
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
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

/* Lanes k and k + 4 share a register, then a 4 × 4 transpose within halves. Indices are doubled as a vector, so that an
 * address's own factor of 8 makes 16 bytes of them. */
CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    const __m256i safe = _mm256_and_si256(index.v, _mm256_castps_si256(m.v));
    const lane_pairs k = lanes_out(_mm256_add_epi32(safe, safe));
    __m256 r[4];
    for (int q = 0; q < 4; q++)
        r[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(base + 2 * lane_out(k, q))),
                                    _mm_load_ps(base + 2 * lane_out(k, q + 4)), 1);
    const __m256 a = _mm256_unpacklo_ps(r[0], r[1]), b = _mm256_unpackhi_ps(r[0], r[1]);
    const __m256 c = _mm256_unpacklo_ps(r[2], r[3]), d = _mm256_unpackhi_ps(r[2], r[3]);
    out[0].v = _mm256_shuffle_ps(a, c, 0x44);
    out[1].v = _mm256_shuffle_ps(a, c, 0xee);
    out[2].v = _mm256_shuffle_ps(b, d, 0x44);
    out[3].v = _mm256_shuffle_ps(b, d, 0xee);
}

/* Transposes 8 rays of 8 floats: pairs, pairs of pairs, halves. */
CW_INLINE void vf_load_each_ray(const cw_ray *const rays[8], vfloat out[8]) {
    __m256 r[8], s[8];
    for (int k = 0; k < 8; k++) r[k] = _mm256_loadu_ps((const float *)rays[k]);
    for (int k = 0; k < 4; k++) {
        s[2 * k] = _mm256_unpacklo_ps(r[2 * k], r[2 * k + 1]);
        s[2 * k + 1] = _mm256_unpackhi_ps(r[2 * k], r[2 * k + 1]);
    }
    for (int k = 0; k < 2; k++) {
        r[4 * k + 0] = _mm256_shuffle_ps(s[4 * k], s[4 * k + 2], 0x44);
        r[4 * k + 1] = _mm256_shuffle_ps(s[4 * k], s[4 * k + 2], 0xee);
        r[4 * k + 2] = _mm256_shuffle_ps(s[4 * k + 1], s[4 * k + 3], 0x44);
        r[4 * k + 3] = _mm256_shuffle_ps(s[4 * k + 1], s[4 * k + 3], 0xee);
    }
    for (int k = 0; k < 4; k++) {
        out[k].v = _mm256_permute2f128_ps(r[k], r[4 + k], 0x20);
        out[4 + k].v = _mm256_permute2f128_ps(r[k], r[4 + k], 0x31);
    }
}
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    const cw_ray *each[8];
    for (int k = 0; k < 8; k++) each[k] = rays + k;
    vf_load_each_ray(each, out);
}

/* In two halves, each compacted by a byte shuffle from a table of 16. Rejected: BMI2's pext and pdep, which need no
 * table. Not every CPU with AVX2 has them, and on some they take hundreds of cycles. */
typedef struct vpick {
    __m128i low, high;
    int count; /* lanes of the low half */
} vpick;
/* The bytes of lane k are 4 k to 4 k + 3. */
static inline __m128i vpick_half(int mask) {
    static const uint8_t first[16][4] = {
        {0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {2, 0, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}, {0, 1, 2, 0},
        {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0}, {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};
    int32_t lanes;
    __builtin_memcpy(&lanes, first[mask], sizeof lanes);
    const __m128i four = _mm_cvtepu8_epi32(_mm_cvtsi32_si128(lanes)); /* a lane's number in each */
    return _mm_add_epi8(_mm_mullo_epi32(four, _mm_set1_epi32(0x04040404)), _mm_set1_epi32(0x03020100));
}
static inline vpick vpick_make(vmask m) {
    const int mask = _mm256_movemask_ps(m.v);
    return (vpick){vpick_half(mask & 15), vpick_half(mask >> 4), __builtin_popcount((unsigned)mask & 15)};
}
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    const __m128i low = _mm_castps_si128(_mm256_castps256_ps128(a.v));
    const __m128i high = _mm_castps_si128(_mm256_extractf128_ps(a.v, 1));
    _mm_storeu_ps(to, _mm_castsi128_ps(_mm_shuffle_epi8(low, pick.low)));
    _mm_storeu_ps(to + pick.count, _mm_castsi128_ps(_mm_shuffle_epi8(high, pick.high)));
}

/* Members in pairs of two; a hit is three pairs, four hits are three registers. Unpacking leaves pairs of lanes 0, 1
 * and 4, 5 in one register, of 2, 3 and 6, 7 in the other; the halves of registers are put in order as they are
 * stored. */
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
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

static inline vmask vm_set(bool a) { return (vmask){_mm256_castsi256_ps(_mm256_set1_epi32(-(int32_t)a))}; }

/* By eights: a transpose in which each step takes minima. */
CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
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

typedef struct vdouble {
    __m256d a, b; /* lanes 0 to 3, 4 to 7 */
} vdouble;

static inline vdouble vd_set(double a) { return (vdouble){_mm256_set1_pd(a), _mm256_set1_pd(a)}; }
static inline vdouble vd_from_vf(vfloat x) {
    return (vdouble){_mm256_cvtps_pd(_mm256_castps256_ps128(x.v)), _mm256_cvtps_pd(_mm256_extractf128_ps(x.v, 1))};
}
static inline vfloat vf_from_vd(vdouble x) {
    return (vfloat){_mm256_insertf128_ps(_mm256_castps128_ps256(_mm256_cvtpd_ps(x.a)), _mm256_cvtpd_ps(x.b), 1)};
}
static inline vdouble vd_add(vdouble x, vdouble y) {
    return (vdouble){_mm256_add_pd(x.a, y.a), _mm256_add_pd(x.b, y.b)};
}
static inline vdouble vd_sub(vdouble x, vdouble y) {
    return (vdouble){_mm256_sub_pd(x.a, y.a), _mm256_sub_pd(x.b, y.b)};
}
static inline vdouble vd_mul(vdouble x, vdouble y) {
    return (vdouble){_mm256_mul_pd(x.a, y.a), _mm256_mul_pd(x.b, y.b)};
}
static inline vdouble vd_div(vdouble x, vdouble y) {
    return (vdouble){_mm256_div_pd(x.a, y.a), _mm256_div_pd(x.b, y.b)};
}
static inline vdouble vd_min(vdouble x, vdouble y) {
    return (vdouble){_mm256_min_pd(x.a, y.a), _mm256_min_pd(x.b, y.b)};
}
static inline vdouble vd_max(vdouble x, vdouble y) {
    return (vdouble){_mm256_max_pd(x.a, y.a), _mm256_max_pd(x.b, y.b)};
}
static inline vdouble vd_select(vmask m, vdouble x, vdouble y) {
    const __m256i bits = _mm256_castps_si256(m.v);
    const __m256i a = _mm256_cvtepi32_epi64(_mm256_castsi256_si128(bits));
    const __m256i b = _mm256_cvtepi32_epi64(_mm256_extracti128_si256(bits, 1));
    return (vdouble){_mm256_blendv_pd(y.a, x.a, _mm256_castsi256_pd(a)),
                     _mm256_blendv_pd(y.b, x.b, _mm256_castsi256_pd(b))};
}

typedef struct vorder {
    int flip_x, flip_y;
    __m256i column; /* lane shuffle that turns each row of 4 round where flip_x */
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) {
    const __m256i same = _mm256_setr_epi32(0, 1, 2, 3, 0, 1, 2, 3), turned = _mm256_setr_epi32(3, 2, 1, 0, 3, 2, 1, 0);
    return (vorder){up_x ? 0 : 3, up_y ? 0 : 3, up_x ? same : turned};
}

static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    const float *near = row + (ptrdiff_t)(2 * k) * step;
    const __m256 rows = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(near)), _mm_loadu_ps(near + step), 1);
    return (vfloat){_mm256_permutevar_ps(rows, o->column)};
}

#endif
