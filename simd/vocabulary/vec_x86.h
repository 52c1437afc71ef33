/* SPDX-License-Identifier: Apache-2.0 */
/* What vec_sse42.h, vec_avx2.h and vec_avx512.h have in common: types, and words whose intrinsics differ in their registers'
 * names alone. X(name) and X_INT(name) are the intrinsics of that name, on floats or doubles and on whole registers of integers.
 * F32, F64 and I32 are the registers. */
#ifndef CELLWALK_SIMD_VEC_X86_H
#define CELLWALK_SIMD_VEC_X86_H

#include "cellwalk.h"
#include "inline.h"

#include <immintrin.h>
#include <stddef.h>

typedef I32 ints;
typedef uint32_t int_lanes __attribute__((vector_size(4 * W))); /* as the intrinsics add them: sums wrap around */

typedef struct float_reg {
    F32 v;
} float_reg;
typedef struct int_reg {
    I32 v;
} int_reg;
typedef struct double_reg {
    F64 v;
} double_reg;
#define DOUBLE_REGS 2

static inline float_reg rf_set(float a) { return (float_reg){X(set1_ps)(a)}; }
static inline float_reg rf_load(const float *a) { return (float_reg){X(loadu_ps)(a)}; }
static inline void rf_store(float *to, float_reg a) { X(storeu_ps)(to, a.v); }
static inline float_reg rf_min(float_reg a, float_reg b) { return (float_reg){X(min_ps)(a.v, b.v)}; }
static inline float_reg rf_max(float_reg a, float_reg b) { return (float_reg){X(max_ps)(a.v, b.v)}; }
static inline float_reg rf_floor(float_reg a) { return (float_reg){X(floor_ps)(a.v)}; }
static inline float_reg rf_flip(float_reg a, float_reg sign) { return (float_reg){X(xor_ps)(a.v, sign.v)}; }
static inline float_reg rf_from_ri(int_reg a) { return (float_reg){X(cvtepi32_ps)(a.v)}; }
static inline float_reg rf_power_of_2(int_reg k) {
    return (float_reg){(F32)X(slli_epi32)(X(add_epi32)(k.v, X(set1_epi32)(127)), 23)};
}
static inline int_reg ri_set(int32_t a) { return (int_reg){X(set1_epi32)(a)}; }
static inline int_reg ri_load(const int32_t *a) { return (int_reg){X_INT(loadu)((const I32 *)a)}; }
static inline void ri_store(int32_t *to, int_reg a) { X_INT(storeu)((I32 *)to, a.v); }
static inline int_reg ri_from_rf(float_reg a) { return (int_reg){X(cvttps_epi32)(a.v)}; }
static inline double_reg rd_set(double a) { return (double_reg){X(set1_pd)(a)}; }
static inline double_reg rd_min(double_reg a, double_reg b) { return (double_reg){X(min_pd)(a.v, b.v)}; }
static inline double_reg rd_max(double_reg a, double_reg b) { return (double_reg){X(max_pd)(a.v, b.v)}; }

/* 4 × 4 transposes within quarters, halves or the whole of a register. */
CW_INLINE void transpose(const F32 r[4], float_reg out[4]) {
    const F32 a = X(unpacklo_ps)(r[0], r[1]), b = X(unpackhi_ps)(r[0], r[1]);
    const F32 c = X(unpacklo_ps)(r[2], r[3]), d = X(unpackhi_ps)(r[2], r[3]);
    out[0].v = X(shuffle_ps)(a, c, 0x44);
    out[1].v = X(shuffle_ps)(a, c, 0xee);
    out[2].v = X(shuffle_ps)(b, d, 0x44);
    out[3].v = X(shuffle_ps)(b, d, 0xee);
}

#if W < 16 /* masks as all-ones lanes; AVX-512 has registers for them */
typedef struct mask_reg {
    F32 v;
} mask_reg;

static inline float_reg rf_abs(float_reg a) { return (float_reg){X(andnot_ps)(X(set1_ps)(-0.0f), a.v)}; }
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){X(blendv_ps)(b.v, a.v, m.v)};
}
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) {
    return (int_reg){X(blendv_epi8)(b.v, a.v, (I32)m.v)};
}
static inline int_reg ri_where(mask_reg m, int_reg a) { return (int_reg){X_INT(and)(a.v, (I32)m.v)}; }
static inline mask_reg ri_eq(int_reg a, int_reg b) { return (mask_reg){(F32)X(cmpeq_epi32)(a.v, b.v)}; }
static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){X(and_ps)(a.v, b.v)}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){X(or_ps)(a.v, b.v)}; }
static inline mask_reg rm_xor(mask_reg a, mask_reg b) { return (mask_reg){X(xor_ps)(a.v, b.v)}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){X(andnot_ps)(b.v, a.v)}; }
static inline mask_reg rm_set(bool a) { return (mask_reg){(F32)X(set1_epi32)(-(int32_t)a)}; }
static inline mask_reg rm_not(mask_reg a) { return rm_xor(a, rm_set(true)); }
static inline bool rm_any(mask_reg a) { return X(movemask_ps)(a.v) != 0; }
static inline unsigned rm_bits(mask_reg a) { return (unsigned)X(movemask_ps)(a.v); }
#endif

#endif
