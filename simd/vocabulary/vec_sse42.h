/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for SSE4.2: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_SSE42_H
#define CELLWALK_SIMD_VEC_SSE42_H

#include "cellwalk.h"

#include <nmmintrin.h>
#include <stddef.h>

enum { W = 4 };

typedef struct vfloat {
    __m128 v;
} vfloat;
typedef struct vint {
    __m128i v;
} vint;
typedef struct vmask {
    __m128 v;
} vmask;

static inline vfloat vf_set(float a) { return (vfloat){_mm_set1_ps(a)}; }
static inline vfloat vf_load(const float *a) { return (vfloat){_mm_loadu_ps(a)}; }
static inline void vf_store(float *to, vfloat a) { _mm_storeu_ps(to, a.v); }
static inline vfloat vf_add(vfloat a, vfloat b) { return (vfloat){_mm_add_ps(a.v, b.v)}; }
static inline vfloat vf_sub(vfloat a, vfloat b) { return (vfloat){_mm_sub_ps(a.v, b.v)}; }
static inline vfloat vf_mul(vfloat a, vfloat b) { return (vfloat){_mm_mul_ps(a.v, b.v)}; }
static inline vfloat vf_div(vfloat a, vfloat b) { return (vfloat){_mm_div_ps(a.v, b.v)}; }
static inline vfloat vf_min(vfloat a, vfloat b) { return (vfloat){_mm_min_ps(a.v, b.v)}; }
static inline vfloat vf_max(vfloat a, vfloat b) { return (vfloat){_mm_max_ps(a.v, b.v)}; }
static inline vfloat vf_abs(vfloat a) { return (vfloat){_mm_andnot_ps(_mm_set1_ps(-0.0f), a.v)}; }
static inline vfloat vf_floor(vfloat a) { return (vfloat){_mm_floor_ps(a.v)}; }

static inline vmask vf_lt(vfloat a, vfloat b) { return (vmask){_mm_cmplt_ps(a.v, b.v)}; }
static inline vmask vf_le(vfloat a, vfloat b) { return (vmask){_mm_cmple_ps(a.v, b.v)}; }
static inline vmask vf_gt(vfloat a, vfloat b) { return (vmask){_mm_cmpgt_ps(a.v, b.v)}; }
static inline vmask vf_ge(vfloat a, vfloat b) { return (vmask){_mm_cmpge_ps(a.v, b.v)}; }
static inline vmask vf_eq(vfloat a, vfloat b) { return (vmask){_mm_cmpeq_ps(a.v, b.v)}; }
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) { return (vfloat){_mm_blendv_ps(b.v, a.v, m.v)}; }

static inline vint vi_set(int32_t a) { return (vint){_mm_set1_epi32(a)}; }
static inline void vi_store(int32_t *to, vint a) { _mm_storeu_si128((__m128i *)to, a.v); }
static inline vint vi_add(vint a, vint b) { return (vint){_mm_add_epi32(a.v, b.v)}; }
static inline vint vi_mul(vint a, vint b) { return (vint){_mm_mullo_epi32(a.v, b.v)}; }
static inline vint vi_select(vmask m, vint a, vint b) {
    return (vint){_mm_blendv_epi8(b.v, a.v, _mm_castps_si128(m.v))};
}
static inline vint vi_from_vf(vfloat a) { return (vint){_mm_cvttps_epi32(a.v)}; }

static inline vfloat vf_from_vi(vint a) { return (vfloat){_mm_cvtepi32_ps(a.v)}; }
static inline vint vi_load(const int32_t *a) { return (vint){_mm_loadu_si128((const __m128i *)a)}; }
static inline vint vi_and(vint a, vint b) { return (vint){_mm_and_si128(a.v, b.v)}; }
static inline vint vi_or(vint a, vint b) { return (vint){_mm_or_si128(a.v, b.v)}; }
static inline vint vi_xor(vint a, vint b) { return (vint){_mm_xor_si128(a.v, b.v)}; }
static inline vint vi_sub(vint a, vint b) { return (vint){_mm_sub_epi32(a.v, b.v)}; }
/* SSE4.2 has no shift by a vector: times 2^by, put together as a float. */
static inline vint vi_shift_left(vint a, vint by) {
    const __m128 power = _mm_castsi128_ps(_mm_slli_epi32(_mm_add_epi32(by.v, _mm_set1_epi32(127)), 23));
    return (vint){_mm_mullo_epi32(a.v, _mm_cvttps_epi32(power))};
}
static inline vmask vi_eq(vint a, vint b) { return (vmask){_mm_castsi128_ps(_mm_cmpeq_epi32(a.v, b.v))}; }
/* SSE4.2 has no shift by a vector: times 2^-by in floats, which hold the 24 bits of a and of the product. */
static inline vint vi_shift_right(vint a, vint by) {
    const __m128 power = _mm_castsi128_ps(_mm_slli_epi32(_mm_sub_epi32(_mm_set1_epi32(127), by.v), 23));
    return (vint){_mm_cvttps_epi32(_mm_mul_ps(_mm_cvtepi32_ps(a.v), power))};
}
static inline vint vi_lookup(const int32_t table[16], vint k) {
    return (vint){_mm_setr_epi32(table[_mm_cvtsi128_si32(k.v)], table[_mm_extract_epi32(k.v, 1)],
                                 table[_mm_extract_epi32(k.v, 2)], table[_mm_extract_epi32(k.v, 3)])};
}

static inline vint vi_where(vmask m, vint a) { return (vint){_mm_and_si128(a.v, _mm_castps_si128(m.v))}; }
static inline vfloat vf_flip(vfloat a, vfloat sign) { return (vfloat){_mm_xor_ps(a.v, sign.v)}; }
static inline vfloat vf_power_of_2(vint k) {
    return (vfloat){_mm_castsi128_ps(_mm_slli_epi32(_mm_add_epi32(k.v, _mm_set1_epi32(127)), 23))};
}

static inline vmask vm_and(vmask a, vmask b) { return (vmask){_mm_and_ps(a.v, b.v)}; }
static inline vmask vm_or(vmask a, vmask b) { return (vmask){_mm_or_ps(a.v, b.v)}; }
static inline vmask vm_xor(vmask a, vmask b) { return (vmask){_mm_xor_ps(a.v, b.v)}; }
static inline vmask vm_andnot(vmask a, vmask b) { return (vmask){_mm_andnot_ps(b.v, a.v)}; }
static inline vmask vm_not(vmask a) { return (vmask){_mm_xor_ps(a.v, _mm_castsi128_ps(_mm_set1_epi32(-1)))}; }
static inline vmask vm_first(size_t n) {
    return (vmask){_mm_castsi128_ps(_mm_cmpgt_epi32(_mm_set1_epi32((int32_t)n), _mm_setr_epi32(0, 1, 2, 3)))};
}
static inline vmask vm_from_bits(unsigned bits) {
    const __m128i bit = _mm_setr_epi32(1, 2, 4, 8);
    return (vmask){_mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int32_t)bits), bit), bit))};
}
static inline bool vm_any(vmask a) { return _mm_movemask_ps(a.v) != 0; }
static inline unsigned vm_bits(vmask a) { return (unsigned)_mm_movemask_ps(a.v); }

/* No gather instruction: lanes one by one, those outside m from base[0]. */
static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    const __m128i safe = _mm_and_si128(index.v, _mm_castps_si128(m.v));
    const __m128 a = _mm_load_ss(base + _mm_cvtsi128_si32(safe)), b = _mm_load_ss(base + _mm_extract_epi32(safe, 1));
    const __m128 c = _mm_load_ss(base + _mm_extract_epi32(safe, 2)), d = _mm_load_ss(base + _mm_extract_epi32(safe, 3));
    return (vfloat){_mm_and_ps(_mm_movelh_ps(_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d)), m.v)};
}

/* Two floats as one 8-byte load, the lanes' pairs then separated by shuffles. An integer load: _mm_load_sd would claim that a
 * double lies there, aligned. */
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    const __m128i safe = _mm_and_si128(index.v, _mm_castps_si128(m.v));
    __m128 low = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(base + _mm_cvtsi128_si32(safe))));
    __m128 high = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(base + _mm_extract_epi32(safe, 2))));
    low = _mm_loadh_pi(low, (const __m64 *)(base + _mm_extract_epi32(safe, 1)));
    high = _mm_loadh_pi(high, (const __m64 *)(base + _mm_extract_epi32(safe, 3)));
    first->v = _mm_shuffle_ps(low, high, 0x88);
    second->v = _mm_shuffle_ps(low, high, 0xdd);
}

CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    int32_t k[4];
    _mm_storeu_si128((__m128i *)k, _mm_and_si128(index.v, _mm_castps_si128(m.v)));
    __m128 r[4];
    for (int q = 0; q < 4; q++) r[q] = _mm_load_ps(base + 4 * (ptrdiff_t)k[q]);
    const __m128 a = _mm_unpacklo_ps(r[0], r[1]), b = _mm_unpackhi_ps(r[0], r[1]);
    const __m128 c = _mm_unpacklo_ps(r[2], r[3]), d = _mm_unpackhi_ps(r[2], r[3]);
    out[0].v = _mm_movelh_ps(a, c);
    out[1].v = _mm_movehl_ps(c, a);
    out[2].v = _mm_movelh_ps(b, d);
    out[3].v = _mm_movehl_ps(d, b);
}

CW_INLINE void vf_load_each_ray(const cw_ray *const rays[4], vfloat out[8]) {
    for (int half = 0; half < 2; half++) {
        const __m128 a = _mm_loadu_ps((const float *)rays[0] + 4 * half);
        const __m128 b = _mm_loadu_ps((const float *)rays[1] + 4 * half);
        const __m128 c = _mm_loadu_ps((const float *)rays[2] + 4 * half);
        const __m128 d = _mm_loadu_ps((const float *)rays[3] + 4 * half);
        const __m128 ab_low = _mm_unpacklo_ps(a, b), ab_high = _mm_unpackhi_ps(a, b);
        const __m128 cd_low = _mm_unpacklo_ps(c, d), cd_high = _mm_unpackhi_ps(c, d);
        out[4 * half + 0].v = _mm_movelh_ps(ab_low, cd_low);
        out[4 * half + 1].v = _mm_movehl_ps(cd_low, ab_low);
        out[4 * half + 2].v = _mm_movelh_ps(ab_high, cd_high);
        out[4 * half + 3].v = _mm_movehl_ps(cd_high, ab_high);
    }
}
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    vf_load_each_ray((const cw_ray *[4]){rays, rays + 1, rays + 2, rays + 3}, out);
}

typedef struct vpick {
    __m128i bytes;
} vpick;
/* The bytes of lane k are 4 k to 4 k + 3. */
static inline vpick vpick_make(vmask m) {
    static const uint8_t first[16][4] = {
        {0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {2, 0, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}, {0, 1, 2, 0},
        {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0}, {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};
    int32_t lanes;
    __builtin_memcpy(&lanes, first[_mm_movemask_ps(m.v)], sizeof lanes);
    const __m128i four = _mm_cvtepu8_epi32(_mm_cvtsi32_si128(lanes)); /* a lane's number in each */
    const __m128i times = _mm_mullo_epi32(four, _mm_set1_epi32(0x04040404));
    return (vpick){_mm_add_epi8(times, _mm_set1_epi32(0x03020100))};
}
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    _mm_storeu_ps(to, _mm_castsi128_ps(_mm_shuffle_epi8(_mm_castps_si128(a.v), pick.bytes)));
}

/* Members in pairs of two; a hit is three pairs, two hits are three registers. */
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
    const __m128 whole_i = _mm_castsi128_ps(_mm_cvttps_epi32(i.v)), whole_j = _mm_castsi128_ps(_mm_cvttps_epi32(j.v));
    const __m128 in_b = _mm_and_ps(b.v, _mm_castsi128_ps(_mm_set1_epi32(1)));
    float *to = (float *)hits;
    for (int half = 0; half < 2; half++, to += 12) {
        const __m128d ti = _mm_castps_pd(half ? _mm_unpackhi_ps(t.v, whole_i) : _mm_unpacklo_ps(t.v, whole_i));
        const __m128d jb = _mm_castps_pd(half ? _mm_unpackhi_ps(whole_j, in_b) : _mm_unpacklo_ps(whole_j, in_b));
        const __m128d uv = _mm_castps_pd(half ? _mm_unpackhi_ps(u.v, v.v) : _mm_unpacklo_ps(u.v, v.v));
        _mm_storeu_ps(to, _mm_castpd_ps(_mm_unpacklo_pd(ti, jb)));
        _mm_storeu_ps(to + 4, _mm_castpd_ps(_mm_shuffle_pd(uv, ti, 2)));
        _mm_storeu_ps(to + 8, _mm_castpd_ps(_mm_unpackhi_pd(jb, uv)));
    }
}

static inline vmask vm_set(bool a) { return (vmask){_mm_castsi128_ps(_mm_set1_epi32(-(int32_t)a))}; }

/* By fours: a transpose in which each step takes minima. */
CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    for (int k = 0; k < 16; k += 4) {
        const __m128 ab = _mm_min_ps(_mm_unpacklo_ps(a[k].v, a[k + 1].v), _mm_unpackhi_ps(a[k].v, a[k + 1].v));
        const __m128 cd = _mm_min_ps(_mm_unpacklo_ps(a[k + 2].v, a[k + 3].v), _mm_unpackhi_ps(a[k + 2].v, a[k + 3].v));
        _mm_storeu_ps(out + k, _mm_min_ps(_mm_movelh_ps(ab, cd), _mm_movehl_ps(cd, ab)));
    }
}

typedef struct vdouble {
    __m128d a, b; /* lanes 0 and 1, 2 and 3 */
} vdouble;

static inline vdouble vd_set(double a) { return (vdouble){_mm_set1_pd(a), _mm_set1_pd(a)}; }
static inline vdouble vd_from_vf(vfloat x) {
    return (vdouble){_mm_cvtps_pd(x.v), _mm_cvtps_pd(_mm_movehl_ps(x.v, x.v))};
}
static inline vfloat vf_from_vd(vdouble x) { return (vfloat){_mm_movelh_ps(_mm_cvtpd_ps(x.a), _mm_cvtpd_ps(x.b))}; }
static inline vdouble vd_add(vdouble x, vdouble y) { return (vdouble){_mm_add_pd(x.a, y.a), _mm_add_pd(x.b, y.b)}; }
static inline vdouble vd_sub(vdouble x, vdouble y) { return (vdouble){_mm_sub_pd(x.a, y.a), _mm_sub_pd(x.b, y.b)}; }
static inline vdouble vd_mul(vdouble x, vdouble y) { return (vdouble){_mm_mul_pd(x.a, y.a), _mm_mul_pd(x.b, y.b)}; }
static inline vdouble vd_div(vdouble x, vdouble y) { return (vdouble){_mm_div_pd(x.a, y.a), _mm_div_pd(x.b, y.b)}; }
static inline vdouble vd_min(vdouble x, vdouble y) { return (vdouble){_mm_min_pd(x.a, y.a), _mm_min_pd(x.b, y.b)}; }
static inline vdouble vd_max(vdouble x, vdouble y) { return (vdouble){_mm_max_pd(x.a, y.a), _mm_max_pd(x.b, y.b)}; }
static inline vdouble vd_select(vmask m, vdouble x, vdouble y) {
    const __m128d a = _mm_castps_pd(_mm_unpacklo_ps(m.v, m.v)), b = _mm_castps_pd(_mm_unpackhi_ps(m.v, m.v));
    return (vdouble){_mm_blendv_pd(y.a, x.a, a), _mm_blendv_pd(y.b, x.b, b)};
}

typedef struct vorder {
    int flip_x, flip_y;
    __m128i column; /* byte shuffle that turns a row round where flip_x */
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) {
    const __m128i same = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m128i turned = _mm_setr_epi8(12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3);
    return (vorder){up_x ? 0 : 3, up_y ? 0 : 3, up_x ? same : turned};
}

static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    const __m128i in_field_order = _mm_castps_si128(_mm_loadu_ps(row + (ptrdiff_t)k * step));
    return (vfloat){_mm_castsi128_ps(_mm_shuffle_epi8(in_field_order, o->column))};
}

#endif
