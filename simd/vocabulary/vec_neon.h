/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for NEON of aarch64: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h.
 *
 * Minima and maxima are a comparison and a selection: FMIN yields NaN where either operand is one, FMINNM the other
 * operand, and both order zeros by sign; the vocabulary's yield the second operand in all these cases.
 *
 * Rejected: vec_sse42.h through SIMDe. It takes more instructions a ray (papers/arm.md), as SSE tells masks by their
 * sign bits alone and has no shift by a vector and no lookup in 64 bytes. */
#ifndef CELLWALK_SIMD_VEC_NEON_H
#define CELLWALK_SIMD_VEC_NEON_H

#define W 4 /* lanes of a register */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "lanes and bytes are numbered as they lie in memory");

#include "vec_lanes.h"

#include <arm_neon.h>

static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){vbslq_f32(m.v, a.v, b.v)};
}
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) { return (int_reg){vbslq_u32(m.v, a.v, b.v)}; }
static inline float_reg rf_min(float_reg a, float_reg b) { return rf_select((mask_reg){vcltq_f32(a.v, b.v)}, a, b); }
static inline float_reg rf_max(float_reg a, float_reg b) { return rf_select((mask_reg){vcgtq_f32(a.v, b.v)}, a, b); }
static inline float_reg rf_floor(float_reg a) { return (float_reg){vrndmq_f32(a.v)}; }
/* By bytes: those of entry k are 4 k to 4 k + 3. */
static inline int_reg ri_lookup(const table_entry table[16], int_reg k) {
    uint8x16x4_t bytes;
    for (int part = 0; part < 4; part++) bytes.val[part] = vld1q_u8((const uint8_t *)(table + 4 * part));
    const uint32x4_t at = k.v * 0x04040404 + 0x03020100;
    return (int_reg){vreinterpretq_u32_u8(vqtbl4q_u8(bytes, vreinterpretq_u8_u32(at)))};
}

/* Four halves of lanes are one register of the integer unit. */
static inline bool rm_any(mask_reg a) { return vget_lane_u64(vreinterpret_u64_u16(vmovn_u32(a.v)), 0) != 0; }
static inline unsigned rm_bits(mask_reg a) { return vaddvq_u32(vandq_u32(a.v, (uint32x4_t){1, 2, 4, 8})); }

static inline double_reg rd_from_rf(float_reg a, int k) {
    return (double_reg){k == 0 ? vcvt_f64_f32(vget_low_f32(a.v)) : vcvt_high_f64_f32(a.v)};
}
static inline float_reg rf_from_rd(double_reg low, double_reg high) {
    return (float_reg){vcvt_high_f32_f64(vcvt_f32_f64(low.v), high.v)};
}
static inline double_reg rd_min(double_reg a, double_reg b) {
    return (double_reg){vbslq_f64(vcltq_f64(a.v, b.v), a.v, b.v)};
}
static inline double_reg rd_max(double_reg a, double_reg b) {
    return (double_reg){vbslq_f64(vcgtq_f64(a.v, b.v), a.v, b.v)};
}
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) {
    const uint32x4_t twice = k == 0 ? vzip1q_u32(m.v, m.v) : vzip2q_u32(m.v, m.v);
    return (double_reg){vbslq_f64(vreinterpretq_u64_u32(twice), a.v, b.v)};
}

#endif
