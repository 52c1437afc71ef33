/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for NEON of aarch64: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h.
 *
 * Minima and maxima are a comparison and a selection: FMIN yields NaN where either operand is one, FMINNM the other operand,
 * and both order zeros by sign; the vocabulary's yield the second operand in all these cases.
 *
 * Rejected: vec_sse42.h through SIMDe. It takes more instructions a ray (papers/arm.md), as SSE tells masks by their sign bits
 * alone and has no loads that transpose, no shift by a vector and no lookup in 64 bytes. */
#ifndef CELLWALK_SIMD_VEC_NEON_H
#define CELLWALK_SIMD_VEC_NEON_H

#include "cellwalk.h"

#include <arm_neon.h>
#include <stddef.h>

enum { W = 4 };

typedef struct vfloat {
    float32x4_t v;
} vfloat;
typedef struct vint {
    int32x4_t v;
} vint;
typedef struct vmask {
    uint32x4_t v;
} vmask;

static inline vfloat vf_set(float a) { return (vfloat){vdupq_n_f32(a)}; }
static inline vfloat vf_load(const float *a) { return (vfloat){vld1q_f32(a)}; }
static inline void vf_store(float *to, vfloat a) { vst1q_f32(to, a.v); }
static inline vfloat vf_add(vfloat a, vfloat b) { return (vfloat){vaddq_f32(a.v, b.v)}; }
static inline vfloat vf_sub(vfloat a, vfloat b) { return (vfloat){vsubq_f32(a.v, b.v)}; }
static inline vfloat vf_mul(vfloat a, vfloat b) { return (vfloat){vmulq_f32(a.v, b.v)}; }
static inline vfloat vf_div(vfloat a, vfloat b) { return (vfloat){vdivq_f32(a.v, b.v)}; }
static inline vfloat vf_min(vfloat a, vfloat b) { return (vfloat){vbslq_f32(vcltq_f32(a.v, b.v), a.v, b.v)}; }
static inline vfloat vf_max(vfloat a, vfloat b) { return (vfloat){vbslq_f32(vcgtq_f32(a.v, b.v), a.v, b.v)}; }
static inline vfloat vf_abs(vfloat a) { return (vfloat){vabsq_f32(a.v)}; }
static inline vfloat vf_floor(vfloat a) { return (vfloat){vrndmq_f32(a.v)}; }

static inline vmask vf_lt(vfloat a, vfloat b) { return (vmask){vcltq_f32(a.v, b.v)}; }
static inline vmask vf_le(vfloat a, vfloat b) { return (vmask){vcleq_f32(a.v, b.v)}; }
static inline vmask vf_gt(vfloat a, vfloat b) { return (vmask){vcgtq_f32(a.v, b.v)}; }
static inline vmask vf_ge(vfloat a, vfloat b) { return (vmask){vcgeq_f32(a.v, b.v)}; }
static inline vmask vf_eq(vfloat a, vfloat b) { return (vmask){vceqq_f32(a.v, b.v)}; }
static inline vfloat vf_select(vmask m, vfloat a, vfloat b) { return (vfloat){vbslq_f32(m.v, a.v, b.v)}; }

static inline vint vi_set(int32_t a) { return (vint){vdupq_n_s32(a)}; }
static inline void vi_store(int32_t *to, vint a) { vst1q_s32(to, a.v); }
static inline vint vi_add(vint a, vint b) { return (vint){vaddq_s32(a.v, b.v)}; }
static inline vint vi_mul(vint a, vint b) { return (vint){vmulq_s32(a.v, b.v)}; }
static inline vint vi_select(vmask m, vint a, vint b) { return (vint){vbslq_s32(m.v, a.v, b.v)}; }
static inline vint vi_from_vf(vfloat a) { return (vint){vcvtq_s32_f32(a.v)}; }

static inline vfloat vf_from_vi(vint a) { return (vfloat){vcvtq_f32_s32(a.v)}; }
static inline vint vi_load(const int32_t *a) { return (vint){vld1q_s32(a)}; }
static inline vint vi_and(vint a, vint b) { return (vint){vandq_s32(a.v, b.v)}; }
static inline vint vi_or(vint a, vint b) { return (vint){vorrq_s32(a.v, b.v)}; }
static inline vint vi_xor(vint a, vint b) { return (vint){veorq_s32(a.v, b.v)}; }
static inline vint vi_sub(vint a, vint b) { return (vint){vsubq_s32(a.v, b.v)}; }
static inline vint vi_shift_right(vint a, vint by) { return (vint){vshlq_s32(a.v, vnegq_s32(by.v))}; }
static inline vint vi_shift_left(vint a, vint by) { return (vint){vshlq_s32(a.v, by.v)}; }
static inline vmask vi_eq(vint a, vint b) { return (vmask){vceqq_s32(a.v, b.v)}; }
/* By bytes: those of entry k are 4 k to 4 k + 3. */
static inline vint vi_lookup(const int32_t table[16], vint k) {
    const uint8x16x4_t bytes = {{vreinterpretq_u8_s32(vld1q_s32(table)), vreinterpretq_u8_s32(vld1q_s32(table + 4)),
                                 vreinterpretq_u8_s32(vld1q_s32(table + 8)),
                                 vreinterpretq_u8_s32(vld1q_s32(table + 12))}};
    const int32x4_t at = vmlaq_s32(vdupq_n_s32(0x03020100), k.v, vdupq_n_s32(0x04040404));
    return (vint){vreinterpretq_s32_u8(vqtbl4q_u8(bytes, vreinterpretq_u8_s32(at)))};
}

static inline vint vi_where(vmask m, vint a) { return (vint){vandq_s32(a.v, vreinterpretq_s32_u32(m.v))}; }
static inline vfloat vf_flip(vfloat a, vfloat sign) {
    return (vfloat){vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(a.v), vreinterpretq_u32_f32(sign.v)))};
}
static inline vfloat vf_power_of_2(vint k) {
    return (vfloat){vreinterpretq_f32_s32(vshlq_n_s32(vaddq_s32(k.v, vdupq_n_s32(127)), 23))};
}

static inline vmask vm_and(vmask a, vmask b) { return (vmask){vandq_u32(a.v, b.v)}; }
static inline vmask vm_or(vmask a, vmask b) { return (vmask){vorrq_u32(a.v, b.v)}; }
static inline vmask vm_xor(vmask a, vmask b) { return (vmask){veorq_u32(a.v, b.v)}; }
static inline vmask vm_andnot(vmask a, vmask b) { return (vmask){vbicq_u32(a.v, b.v)}; }
static inline vmask vm_not(vmask a) { return (vmask){vmvnq_u32(a.v)}; }
static inline vmask vm_set(bool a) { return (vmask){vdupq_n_u32(-(uint32_t)a)}; }
static inline vmask vm_first(size_t n) {
    const uint32x4_t lane = {0, 1, 2, 3};
    return (vmask){vcltq_u32(lane, vdupq_n_u32((uint32_t)n))};
}
static inline vmask vm_from_bits(unsigned bits) {
    const uint32x4_t bit = {1, 2, 4, 8};
    return (vmask){vtstq_u32(vdupq_n_u32(bits), bit)};
}
/* Four halves of lanes are one register of the integer unit. */
static inline bool vm_any(vmask a) { return vget_lane_u64(vreinterpret_u64_u16(vmovn_u32(a.v)), 0) != 0; }
static inline unsigned vm_bits(vmask a) {
    const uint32x4_t bit = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(a.v, bit));
}

/* Lanes taken out two at a time; those outside m as 0. */
typedef struct lane_indices {
    int32_t k[4];
} lane_indices;
static inline lane_indices lanes_out(vint index, vmask m) {
    const int64x2_t pairs = vreinterpretq_s64_s32(vi_where(m, index).v);
    const int64_t low = vgetq_lane_s64(pairs, 0), high = vgetq_lane_s64(pairs, 1);
    return (lane_indices){{(int32_t)low, (int32_t)(low >> 32), (int32_t)high, (int32_t)(high >> 32)}};
}

/* No gather instruction: lanes one by one, those outside m from base[0]. */
static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    const lane_indices at = lanes_out(index, m);
    float32x4_t r = vdupq_n_f32(base[at.k[0]]);
    r = vld1q_lane_f32(base + at.k[1], r, 1);
    r = vld1q_lane_f32(base + at.k[2], r, 2);
    r = vld1q_lane_f32(base + at.k[3], r, 3);
    return (vfloat){vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(r), m.v))};
}

CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    const lane_indices at = lanes_out(index, m);
    const float32x4_t low = vcombine_f32(vld1_f32(base + at.k[0]), vld1_f32(base + at.k[1]));
    const float32x4_t high = vcombine_f32(vld1_f32(base + at.k[2]), vld1_f32(base + at.k[3]));
    first->v = vuzp1q_f32(low, high);
    second->v = vuzp2q_f32(low, high);
}

/* Columns of the 4 × 4 floats of which a, b, c and d are the rows. */
CW_INLINE void transpose(float32x4_t a, float32x4_t b, float32x4_t c, float32x4_t d, vfloat out[4]) {
    const float64x2_t ab_even = vreinterpretq_f64_f32(vtrn1q_f32(a, b)),
                      ab_odd = vreinterpretq_f64_f32(vtrn2q_f32(a, b));
    const float64x2_t cd_even = vreinterpretq_f64_f32(vtrn1q_f32(c, d)),
                      cd_odd = vreinterpretq_f64_f32(vtrn2q_f32(c, d));
    out[0].v = vreinterpretq_f32_f64(vzip1q_f64(ab_even, cd_even));
    out[1].v = vreinterpretq_f32_f64(vzip1q_f64(ab_odd, cd_odd));
    out[2].v = vreinterpretq_f32_f64(vzip2q_f64(ab_even, cd_even));
    out[3].v = vreinterpretq_f32_f64(vzip2q_f64(ab_odd, cd_odd));
}

CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    const lane_indices at = lanes_out(index, m);
    float32x4_t r[4];
    for (int q = 0; q < 4; q++) r[q] = vld1q_f32(base + 4 * (ptrdiff_t)at.k[q]);
    transpose(r[0], r[1], r[2], r[3], out);
}

CW_INLINE void vf_load_each_ray(const cw_ray *const rays[4], vfloat out[8]) {
    float32x4_t r[4];
    for (int half = 0; half < 2; half++) {
        for (int k = 0; k < 4; k++) r[k] = vld1q_f32((const float *)rays[k] + 4 * half);
        transpose(r[0], r[1], r[2], r[3], out + 4 * half);
    }
}
/* A load that deals floats out to four registers leaves in each, of two rays, the members k and k + 4. */
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    const float32x4x4_t low = vld4q_f32((const float *)rays), high = vld4q_f32((const float *)(rays + 2));
    for (int k = 0; k < 4; k++) {
        out[k].v = vuzp1q_f32(low.val[k], high.val[k]);
        out[4 + k].v = vuzp2q_f32(low.val[k], high.val[k]);
    }
}

typedef struct vpick {
    uint8x16_t bytes;
} vpick;
/* The bytes of lane k are 4 k to 4 k + 3. */
static inline vpick vpick_make(vmask m) {
    static const uint8_t first[16][4] = {
        {0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {2, 0, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}, {0, 1, 2, 0},
        {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0}, {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};
    uint32_t lanes;
    __builtin_memcpy(&lanes, first[vm_bits(m)], sizeof lanes);
    const uint8x8_t each = vreinterpret_u8_u32(vdup_n_u32(lanes));
    const uint32x4_t four = vmovl_u16(vget_low_u16(vmovl_u8(each))); /* a lane's number in each */
    const uint32x4_t at = vmlaq_u32(vdupq_n_u32(0x03020100), four, vdupq_n_u32(0x04040404));
    return (vpick){vreinterpretq_u8_u32(at)};
}
static inline void vf_store_picked(float *to, vfloat a, vpick pick) {
    vst1q_f32(to, vreinterpretq_f32_u8(vqtbl1q_u8(vreinterpretq_u8_f32(a.v), pick.bytes)));
}

/* Members in pairs of two; a hit is three pairs, two hits are three registers. */
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
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

/* By fours, neighbours at a time. */
CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    for (int k = 0; k < 16; k += 4) {
        const float32x4_t ab = vpminq_f32(a[k].v, a[k + 1].v), cd = vpminq_f32(a[k + 2].v, a[k + 3].v);
        vst1q_f32(out + k, vpminq_f32(ab, cd));
    }
}

typedef struct vdouble {
    float64x2_t a, b; /* lanes 0 and 1, 2 and 3 */
} vdouble;

static inline vdouble vd_set(double a) { return (vdouble){vdupq_n_f64(a), vdupq_n_f64(a)}; }
static inline vdouble vd_from_vf(vfloat x) {
    return (vdouble){vcvt_f64_f32(vget_low_f32(x.v)), vcvt_high_f64_f32(x.v)};
}
static inline vfloat vf_from_vd(vdouble x) { return (vfloat){vcvt_high_f32_f64(vcvt_f32_f64(x.a), x.b)}; }
static inline vdouble vd_add(vdouble x, vdouble y) { return (vdouble){vaddq_f64(x.a, y.a), vaddq_f64(x.b, y.b)}; }
static inline vdouble vd_sub(vdouble x, vdouble y) { return (vdouble){vsubq_f64(x.a, y.a), vsubq_f64(x.b, y.b)}; }
static inline vdouble vd_mul(vdouble x, vdouble y) { return (vdouble){vmulq_f64(x.a, y.a), vmulq_f64(x.b, y.b)}; }
static inline vdouble vd_div(vdouble x, vdouble y) { return (vdouble){vdivq_f64(x.a, y.a), vdivq_f64(x.b, y.b)}; }
static inline vdouble vd_min(vdouble x, vdouble y) {
    return (vdouble){vbslq_f64(vcltq_f64(x.a, y.a), x.a, y.a), vbslq_f64(vcltq_f64(x.b, y.b), x.b, y.b)};
}
static inline vdouble vd_max(vdouble x, vdouble y) {
    return (vdouble){vbslq_f64(vcgtq_f64(x.a, y.a), x.a, y.a), vbslq_f64(vcgtq_f64(x.b, y.b), x.b, y.b)};
}
static inline vdouble vd_select(vmask m, vdouble x, vdouble y) {
    const uint64x2_t a = vreinterpretq_u64_u32(vzip1q_u32(m.v, m.v)), b = vreinterpretq_u64_u32(vzip2q_u32(m.v, m.v));
    return (vdouble){vbslq_f64(a, x.a, y.a), vbslq_f64(b, x.b, y.b)};
}

typedef struct vorder {
    int flip_x, flip_y;
    uint8x16_t column; /* byte shuffle that turns a row round where flip_x */
} vorder;

static inline vorder vorder_make(bool up_x, bool up_y) {
    const uint8x16_t same = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    const uint8x16_t turned = {12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3};
    return (vorder){up_x ? 0 : 3, up_y ? 0 : 3, up_x ? same : turned};
}

static inline vfloat vf_load_block(const float *row, ptrdiff_t step, const vorder *o, size_t k) {
    const uint8x16_t in_field_order = vreinterpretq_u8_f32(vld1q_f32(row + (ptrdiff_t)k * step));
    return (vfloat){vreinterpretq_f32_u8(vqtbl1q_u8(in_field_order, o->column))};
}

#endif
