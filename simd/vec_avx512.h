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
#ifdef CELLWALK_UNFUSED
static inline vfloat vf_fma(vfloat a, vfloat b, vfloat c) { return vf_add(vf_mul(a, b), c); }
static inline vfloat vf_fnma(vfloat a, vfloat b, vfloat c) { return vf_sub(c, vf_mul(a, b)); }
#else
static inline vfloat vf_fma(vfloat a, vfloat b, vfloat c) { return (vfloat){_mm512_fmadd_ps(a.v, b.v, c.v)}; }
static inline vfloat vf_fnma(vfloat a, vfloat b, vfloat c) { return (vfloat){_mm512_fnmadd_ps(a.v, b.v, c.v)}; }
#endif
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

static inline void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    const __m512i safe = _mm512_maskz_mov_epi32(m.v, index.v);
    first->v = _mm512_i32gather_ps(safe, base, sizeof(float));
    second->v = _mm512_i32gather_ps(safe, base + 1, sizeof(float));
}

/* Lanes k and k + 4, k + 8, k + 12 share a register in quarters, as in vf_load_rays. */
static inline void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
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
static inline void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    for (int half = 0; half < 2; half++) {
        enum { RAY = sizeof(cw_ray) / sizeof(float) };
        __m512 r[4];
        for (int k = 0; k < 4; k++) {
            const float *from = (const float *)(rays + k) + 4 * half;
            r[k] = _mm512_castps128_ps512(_mm_loadu_ps(from));
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps(from + 4 * RAY), 1);
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps(from + 8 * RAY), 2);
            r[k] = _mm512_insertf32x4(r[k], _mm_loadu_ps(from + 12 * RAY), 3);
        }
        const __m512 low01 = _mm512_unpacklo_ps(r[0], r[1]), high01 = _mm512_unpackhi_ps(r[0], r[1]);
        const __m512 low23 = _mm512_unpacklo_ps(r[2], r[3]), high23 = _mm512_unpackhi_ps(r[2], r[3]);
        out[4 * half + 0].v = _mm512_shuffle_ps(low01, low23, 0x44);
        out[4 * half + 1].v = _mm512_shuffle_ps(low01, low23, 0xee);
        out[4 * half + 2].v = _mm512_shuffle_ps(high01, high23, 0x44);
        out[4 * half + 3].v = _mm512_shuffle_ps(high01, high23, 0xee);
    }
}

static inline vmask vm_set(bool a) { return (vmask){(__mmask16)(a ? 0xffff : 0)}; }

static inline float vf_lowest(vfloat a, vmask m) { return _mm512_mask_reduce_min_ps(m.v, a.v); }
static inline float vf_highest(vfloat a, vmask m) { return _mm512_mask_reduce_max_ps(m.v, a.v); }

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
