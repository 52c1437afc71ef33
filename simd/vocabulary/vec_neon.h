/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for NEON of aarch64: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h.
 *
 * Minima and maxima are a comparison and a selection: FMIN yields NaN where either operand is one, FMINNM the other operand,
 * and both order zeros by sign; the vocabulary's yield the second operand in all these cases.
 *
 * Rejected: vec_sse42.h through SIMDe. It takes more instructions a ray (papers/arm.md), as SSE tells masks by their sign bits
 * alone and has no shift by a vector and no lookup in 64 bytes. */
#ifndef CELLWALK_SIMD_VEC_NEON_H
#define CELLWALK_SIMD_VEC_NEON_H

#include "cellwalk.h"
#include "inline.h"

#include <arm_neon.h>
#include <stddef.h>

#define W 4 /* lanes of a register */

typedef int32x4_t ints, int_lanes;
typedef float32x4_t float_lanes;
typedef struct float_reg {
    float32x4_t v;
} float_reg;
typedef struct int_reg {
    int32x4_t v;
} int_reg;
typedef uint32x4_t lane_mask;
typedef struct mask_reg {
    lane_mask v;
} mask_reg;

#include "vec_lanes.h"

static inline float_reg rf_set(float a) { return (float_reg){vdupq_n_f32(a)}; }
static inline float_reg rf_load(const float *a) { return (float_reg){vld1q_f32(a)}; }
static inline void rf_store(float *to, float_reg a) { vst1q_f32(to, a.v); }
static inline float_reg rf_min(float_reg a, float_reg b) {
    return (float_reg){vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v)};
}
static inline float_reg rf_max(float_reg a, float_reg b) {
    return (float_reg){vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v)};
}
static inline float_reg rf_abs(float_reg a) { return (float_reg){vabsq_f32(a.v)}; }
static inline float_reg rf_floor(float_reg a) { return (float_reg){vrndmq_f32(a.v)}; }

static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) {
    return (float_reg){vbslq_f32(m.v, a.v, b.v)};
}

static inline int_reg ri_set(int32_t a) { return (int_reg){vdupq_n_s32(a)}; }
static inline void ri_store(int32_t *to, int_reg a) { vst1q_s32(to, a.v); }
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) { return (int_reg){vbslq_s32(m.v, a.v, b.v)}; }
static inline int_reg ri_from_rf(float_reg a) { return (int_reg){vcvtq_s32_f32(a.v)}; }

static inline float_reg rf_from_ri(int_reg a) { return (float_reg){vcvtq_f32_s32(a.v)}; }
static inline int_reg ri_load(const int32_t *a) { return (int_reg){vld1q_s32(a)}; }
static inline int_reg ri_shift_right(int_reg a, int_reg by) { return (int_reg){vshlq_s32(a.v, vnegq_s32(by.v))}; }
static inline int_reg ri_shift_left(int_reg a, int_reg by) { return (int_reg){vshlq_s32(a.v, by.v)}; }
/* By bytes: those of entry k are 4 k to 4 k + 3. */
static inline int_reg ri_lookup(const int32_t table[16], int_reg k) {
    const uint8x16x4_t bytes = {{vreinterpretq_u8_s32(vld1q_s32(table)), vreinterpretq_u8_s32(vld1q_s32(table + 4)),
                                 vreinterpretq_u8_s32(vld1q_s32(table + 8)),
                                 vreinterpretq_u8_s32(vld1q_s32(table + 12))}};
    const int32x4_t at = vmlaq_s32(vdupq_n_s32(0x03020100), k.v, vdupq_n_s32(0x04040404));
    return (int_reg){vreinterpretq_s32_u8(vqtbl4q_u8(bytes, vreinterpretq_u8_s32(at)))};
}

static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){a.v & b.v}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){a.v | b.v}; }
static inline mask_reg rm_xor(mask_reg a, mask_reg b) { return (mask_reg){a.v ^ b.v}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){a.v & ~b.v}; }
static inline mask_reg rm_from_bits(unsigned bits) {
    const uint32x4_t bit = {1, 2, 4, 8};
    return (mask_reg){vtstq_u32(vdupq_n_u32(bits), bit)};
}
/* Four halves of lanes are one register of the integer unit. */
static inline bool rm_any(mask_reg a) { return vget_lane_u64(vreinterpret_u64_u16(vmovn_u32(a.v)), 0) != 0; }
static inline unsigned rm_bits(mask_reg a) {
    const uint32x4_t bit = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(a.v, bit));
}

/* Lanes taken out two at a time; those outside m as 0. */
static inline lane_indices lanes_out(int_reg index, mask_reg m) {
    const int64x2_t pairs = vreinterpretq_s64_s32(ri_where(m, index).v);
    const int64_t low = vgetq_lane_s64(pairs, 0), high = vgetq_lane_s64(pairs, 1);
    return (lane_indices){{(uint32_t)low, (uint32_t)(low >> 32), (uint32_t)high, (uint32_t)(high >> 32)}};
}

/* No gather instruction: lanes one by one, those outside m from base[0]. */
static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    const lane_indices at = lanes_out(index, m);
    float32x4_t r = vdupq_n_f32(base[at.k[0]]);
    r = vld1q_lane_f32(base + at.k[1], r, 1);
    r = vld1q_lane_f32(base + at.k[2], r, 2);
    r = vld1q_lane_f32(base + at.k[3], r, 3);
    return (float_reg){vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(r), m.v))};
}

CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    const lane_indices at = lanes_out(index, m);
    const float32x4_t low = vcombine_f32(vld1_f32(base + at.k[0]), vld1_f32(base + at.k[1]));
    const float32x4_t high = vcombine_f32(vld1_f32(base + at.k[2]), vld1_f32(base + at.k[3]));
    first->v = vuzp1q_f32(low, high);
    second->v = vuzp2q_f32(low, high);
}

static inline float_reg rf_load_quarters(const float *const *at, size_t step) { return (void)step, rf_load(at[0]); }
CW_INLINE void transpose(const float_reg r[4], float_reg out[4]) {
    float64x2_t even[2], odd[2];
    for (int h = 0; h < 2; h++) {
        even[h] = vreinterpretq_f64_f32(vtrn1q_f32(r[2 * h].v, r[2 * h + 1].v));
        odd[h] = vreinterpretq_f64_f32(vtrn2q_f32(r[2 * h].v, r[2 * h + 1].v));
    }
    out[0].v = vreinterpretq_f32_f64(vzip1q_f64(even[0], even[1]));
    out[1].v = vreinterpretq_f32_f64(vzip1q_f64(odd[0], odd[1]));
    out[2].v = vreinterpretq_f32_f64(vzip2q_f64(even[0], even[1]));
    out[3].v = vreinterpretq_f32_f64(vzip2q_f64(odd[0], odd[1]));
}

/* Members in pairs of two; a hit is three pairs, two hits are three registers. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
    const float32x4_t whole_i = vreinterpretq_f32_s32(vcvtq_s32_f32(i.v));
    const float32x4_t whole_j = vreinterpretq_f32_s32(vcvtq_s32_f32(j.v));
    const float32x4_t in_b = vreinterpretq_f32_u32(vshrq_n_u32(b.v, 31));
    float *to = (float *)hits;
    for (int half = 0; half < 2; half++, to += 12) {
        const float32x4_t ti = half ? vzip2q_f32(t.v, whole_i) : vzip1q_f32(t.v, whole_i);
        const float32x4_t jb = half ? vzip2q_f32(whole_j, in_b) : vzip1q_f32(whole_j, in_b);
        const float32x4_t uv = half ? vzip2q_f32(u.v, v.v) : vzip1q_f32(u.v, v.v);
        vst1q_f32(to, vcombine_f32(vget_low_f32(ti), vget_low_f32(jb)));
        vst1q_f32(to + 4, vcombine_f32(vget_low_f32(uv), vget_high_f32(ti)));
        vst1q_f32(to + 8, vcombine_f32(vget_high_f32(jb), vget_high_f32(uv)));
    }
}

typedef struct double_reg {
    float64x2_t v;
} double_reg;
#define DOUBLE_REGS 2

static inline double_reg rd_set(double a) { return (double_reg){vdupq_n_f64(a)}; }
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
