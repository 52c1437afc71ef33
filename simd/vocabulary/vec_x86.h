/* SPDX-License-Identifier: Apache-2.0 */
/* What vec_sse42.h, vec_avx2.h and vec_avx512.h have in common: words whose intrinsics differ in their registers' names
 * alone. X(name) is the intrinsic of that name. */
#ifndef CELLWALK_SIMD_VEC_X86_H
#define CELLWALK_SIMD_VEC_X86_H

#define OTHER_SHIFTS
#include "vec_lanes.h"

#include <immintrin.h>

static inline float_reg rf_min(float_reg a, float_reg b) { return (float_reg){X(min_ps)(a.v, b.v)}; }
static inline float_reg rf_max(float_reg a, float_reg b) { return (float_reg){X(max_ps)(a.v, b.v)}; }
static inline float_reg rf_floor(float_reg a) { return (float_reg){X(floor_ps)(a.v)}; }
static inline double_reg rd_min(double_reg a, double_reg b) { return (double_reg){X(min_pd)(a.v, b.v)}; }
static inline double_reg rd_max(double_reg a, double_reg b) { return (double_reg){X(max_pd)(a.v, b.v)}; }

#if W > 4 /* not as operators, with which the lane walk takes longer on AVX-512 */
static inline int_reg ri_shift_right(int_reg a, int_reg by) {
    return (int_reg){(int_lanes)X(srlv_epi32)((I32)a.v, (I32)by.v)};
}
static inline int_reg ri_shift_left(int_reg a, int_reg by) {
    return (int_reg){(int_lanes)X(sllv_epi32)((I32)a.v, (I32)by.v)};
}
#endif

/* Half k of a register, in the lanes of one half as wide; and the register of two halves. */
static inline HALF_REG half_of(float_reg a, int k);
static inline float_reg of_halves(HALF_REG low, HALF_REG high);
static inline double_reg rd_from_rf(float_reg a, int k) { return (double_reg){X(cvtps_pd)(half_of(a, k))}; }
static inline float_reg rf_from_rd(double_reg low, double_reg high) {
    return of_halves(X(cvtpd_ps)(low.v), X(cvtpd_ps)(high.v));
}

#if W < 16
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){X(blendv_ps)(b.v, a.v, (float_lanes)m.v)};
}
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) {
    return (int_reg){(int_lanes)X(blendv_epi8)((I32)b.v, (I32)a.v, (I32)m.v)};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    const HALF_REG half = half_of((float_reg){(float_lanes)m.v}, k);
    return (double_reg){X(blendv_pd)(b.v, a.v, (double_lanes)X(cvtepi32_epi64)((__m128i)half))};
}
/* As comparisons leave them, for integer operations would wait longer. */
#define MASK_WORD(word, of, first, second)                                                                             \
    static inline mask_reg word(mask_reg a, mask_reg b) {                                                              \
        return (mask_reg){(lane_mask)X(of)((float_lanes)first.v, (float_lanes)second.v)};                              \
    }
MASK_WORD(rm_and, and_ps, a, b)
MASK_WORD(rm_or, or_ps, a, b)
MASK_WORD(rm_andnot, andnot_ps, b, a)
#undef MASK_WORD
static inline bool rm_any(mask_reg a) { return X(movemask_ps)((float_lanes)a.v) != 0; }
static inline unsigned rm_bits(mask_reg a) { return (unsigned)X(movemask_ps)((float_lanes)a.v); }
#endif

#endif
