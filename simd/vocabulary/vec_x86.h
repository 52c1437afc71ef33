/* SPDX-License-Identifier: Apache-2.0 */
/* What vec_sse42.h, vec_avx2.h and vec_avx512.h have in common: types, and words whose intrinsics differ in their registers'
 * names alone. X(name) and X_INT(name) are the intrinsics of that name, on floats or doubles and on whole registers of integers.
 * F32, F64, I32 and LANE_MASK are the registers. */
#ifndef CELLWALK_SIMD_VEC_X86_H
#define CELLWALK_SIMD_VEC_X86_H

#include "cellwalk.h"
#include "inline.h"

#include <immintrin.h>
#include <stddef.h>

typedef I32 ints;
typedef F32 float_lanes;
typedef uint32_t int_lanes __attribute__((vector_size(4 * W))); /* as the intrinsics add them: sums wrap around */

typedef struct float_reg {
    F32 v;
} float_reg;
typedef struct int_reg {
    I32 v;
} int_reg;
typedef LANE_MASK lane_mask;
typedef struct mask_reg {
    lane_mask v;
} mask_reg;
typedef struct double_reg {
    F64 v;
} double_reg;
#define DOUBLE_REGS 2

#include "vec_lanes.h"

static inline float_reg rf_set(float a) { return (float_reg){X(set1_ps)(a)}; }
static inline float_reg rf_load(const float *a) { return (float_reg){X(loadu_ps)(a)}; }
static inline void rf_store(float *to, float_reg a) { X(storeu_ps)(to, a.v); }
static inline float_reg rf_min(float_reg a, float_reg b) { return (float_reg){X(min_ps)(a.v, b.v)}; }
static inline float_reg rf_max(float_reg a, float_reg b) { return (float_reg){X(max_ps)(a.v, b.v)}; }
static inline float_reg rf_floor(float_reg a) { return (float_reg){X(floor_ps)(a.v)}; }
static inline float_reg rf_from_ri(int_reg a) { return (float_reg){X(cvtepi32_ps)(a.v)}; }
static inline int_reg ri_set(int32_t a) { return (int_reg){X(set1_epi32)(a)}; }
static inline int_reg ri_load(const int32_t *a) { return (int_reg){X_INT(loadu)((const I32 *)a)}; }
static inline void ri_store(int32_t *to, int_reg a) { X_INT(storeu)((I32 *)to, a.v); }
static inline int_reg ri_from_rf(float_reg a) { return (int_reg){X(cvttps_epi32)(a.v)}; }
static inline double_reg rd_set(double a) { return (double_reg){X(set1_pd)(a)}; }
static inline double_reg rd_min(double_reg a, double_reg b) { return (double_reg){X(min_pd)(a.v, b.v)}; }
static inline double_reg rd_max(double_reg a, double_reg b) { return (double_reg){X(max_pd)(a.v, b.v)}; }

CW_INLINE void transpose(const float_reg r[4], float_reg out[4]) {
    const F32 a = X(unpacklo_ps)(r[0].v, r[1].v), b = X(unpackhi_ps)(r[0].v, r[1].v);
    const F32 c = X(unpacklo_ps)(r[2].v, r[3].v), d = X(unpackhi_ps)(r[2].v, r[3].v);
    out[0].v = X(shuffle_ps)(a, c, 0x44);
    out[1].v = X(shuffle_ps)(a, c, 0xee);
    out[2].v = X(shuffle_ps)(b, d, 0x44);
    out[3].v = X(shuffle_ps)(b, d, 0xee);
}

#if W < 16 /* masks as all-ones lanes; AVX-512 has registers for them */
static inline float_reg rf_abs(float_reg a) { return (float_reg){X(andnot_ps)(X(set1_ps)(-0.0f), a.v)}; }
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){X(blendv_ps)(b.v, a.v, m.v)};
}
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) {
    return (int_reg){X(blendv_epi8)(b.v, a.v, (I32)m.v)};
}
static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){X(and_ps)(a.v, b.v)}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){X(or_ps)(a.v, b.v)}; }
static inline mask_reg rm_xor(mask_reg a, mask_reg b) { return (mask_reg){X(xor_ps)(a.v, b.v)}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){X(andnot_ps)(b.v, a.v)}; }
static inline bool rm_any(mask_reg a) { return X(movemask_ps)(a.v) != 0; }
static inline unsigned rm_bits(mask_reg a) { return (unsigned)X(movemask_ps)(a.v); }
#endif

/* Quarters are registers too. */
static inline float_reg of_quarters(const __m128 q[W / 4]);
static inline void to_quarters(F32 r, __m128 q[W / 4]);

static inline float_reg rf_load_quarters(const float *const *at, size_t step) {
    __m128 q[W / 4];
    for (size_t h = 0; h < W / 4; h++) q[h] = _mm_loadu_ps(at[h * step]);
    return of_quarters(q);
}

/* Each pair as one 8-byte load; shuffles then separate the two floats. CPUs that split a gather into dozens of
 * operations take less time for both vectors this way than for one gather, and other CPUs no more. An integer load: _mm_load_sd would
 * claim that a double lies there, aligned. */
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    const lane_indices at = lanes_out(index, m);
    __m128 q[2][W / 4]; /* lanes 4 h and 4 h + 1; the two after them */
    for (int p = 0; p < W / 2; p++) {
        const __m128 one = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(base + at.k[2 * p])));
        q[p % 2][p / 2] = _mm_loadh_pi(one, (const __m64 *)(base + at.k[2 * p + 1]));
    }
    const F32 low = of_quarters(q[0]).v, high = of_quarters(q[1]).v;
    first->v = X(shuffle_ps)(low, high, 0x88);
    second->v = X(shuffle_ps)(low, high, 0xdd);
}

/* Members in pairs of two; a hit is three pairs, four hits are quarters of six registers. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
    enum { SECOND_FIRST = 0xaa & ((1 << W / 2) - 1) };
    const F32 whole_i = (F32)ri_from_rf(i).v, whole_j = (F32)ri_from_rf(j).v, in_b = (F32)ri_where(b, ri_set(1)).v;
    F32 r[6];
    for (int half = 0; half < 2; half++) {
        const F64 ti = (F64)(half ? X(unpackhi_ps)(t.v, whole_i) : X(unpacklo_ps)(t.v, whole_i));
        const F64 jb = (F64)(half ? X(unpackhi_ps)(whole_j, in_b) : X(unpacklo_ps)(whole_j, in_b));
        const F64 uv = (F64)(half ? X(unpackhi_ps)(u.v, v.v) : X(unpacklo_ps)(u.v, v.v));
        r[3 * half] = (F32)X(unpacklo_pd)(ti, jb);
        r[3 * half + 1] = (F32)X(shuffle_pd)(uv, ti, SECOND_FIRST);
        r[3 * half + 2] = (F32)X(unpackhi_pd)(jb, uv);
    }
    for (int k = 0; k < 6; k++) {
        __m128 q[W / 4];
        to_quarters(r[k], q);
        for (int h = 0; h < W / 4; h++) _mm_storeu_ps((float *)hits + 24 * h + 4 * k, q[h]);
    }
}

#endif
