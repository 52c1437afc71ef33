/* SPDX-License-Identifier: Apache-2.0 */
/* What all vec_*.h of more than one lane have in common, included once these have types: words that follow from operators of C on
 * vectors, and words that take a register by quarters, four lanes each. */
#ifndef CELLWALK_SIMD_VEC_LANES_H
#define CELLWALK_SIMD_VEC_LANES_H

#include <stddef.h>

/* 4 × 4 transposes: lane c of quarter q of out[k] becomes lane k of quarter q of r[c]. */
CW_INLINE void transpose(const float_reg r[4], float_reg out[4]);
/* W / 4 quarters, from at[0], at[step] … */
static inline float_reg rf_load_quarters(const float *const *at, size_t step);
/* Lanes one by one, those outside m as 0; none is negative. */
typedef struct lane_indices {
    uint32_t k[W];
} lane_indices;
static inline lane_indices lanes_out(int_reg index, mask_reg m);
static inline int_reg ri_set(int32_t a);
static inline float_reg rf_min(float_reg a, float_reg b);
static inline void rf_store(float *to, float_reg a);
static inline int_reg ri_where(mask_reg m, int_reg a);

static inline float_reg rf_flip(float_reg a, float_reg sign) {
    return (float_reg){(float_lanes)((int_lanes)a.v ^ (int_lanes)sign.v)};
}
static inline float_reg rf_power_of_2(int_reg k) { return (float_reg){(float_lanes)(((int_lanes)k.v + 127) << 23)}; }

#if W < 16 /* masks as all-ones lanes; AVX-512 has registers for them */
#define MASK_OF(comparison) ((mask_reg){(lane_mask)(comparison)})
static inline mask_reg rf_lt(float_reg a, float_reg b) { return MASK_OF(a.v < b.v); }
static inline mask_reg rf_le(float_reg a, float_reg b) { return MASK_OF(a.v <= b.v); }
static inline mask_reg rf_gt(float_reg a, float_reg b) { return MASK_OF(a.v > b.v); }
static inline mask_reg rf_ge(float_reg a, float_reg b) { return MASK_OF(a.v >= b.v); }
static inline mask_reg rf_eq(float_reg a, float_reg b) { return MASK_OF(a.v == b.v); }
static inline mask_reg ri_eq(int_reg a, int_reg b) { return MASK_OF((int_lanes)a.v == (int_lanes)b.v); }
static inline int_reg ri_where(mask_reg m, int_reg a) { return (int_reg){(ints)((int_lanes)a.v & (int_lanes)m.v)}; }
static inline mask_reg rm_not(mask_reg a) { return MASK_OF(~(int_lanes)a.v); }
static inline mask_reg rm_set(bool a) { return MASK_OF(ri_set(-(int32_t)a).v); }
#undef MASK_OF
#endif

CW_INLINE void rf_load_quads(const float *const at[W], float_reg out[4]) {
    float_reg r[4];
    for (int q = 0; q < 4; q++) r[q] = rf_load_quarters(at + q, 4);
    transpose(r, out);
}

/* Indices are doubled as a vector, so that an address's own factor of 8 makes 16 bytes of them. */
CW_INLINE void rf_gather_quads(const float *base, int_reg index, mask_reg m, float_reg out[4]) {
    const int_reg twice = {(ints)((int_lanes)index.v + (int_lanes)index.v)};
    const lane_indices k = lanes_out(twice, m);
    const float *at[W];
    for (int q = 0; q < W; q++) at[q] = base + 2 * (size_t)k.k[q];
    rf_load_quads(at, out);
}

static inline float_reg rf_load_block(const float *row, ptrdiff_t step, size_t k) {
    const float *at[W / 4];
    for (size_t h = 0; h < W / 4; h++) at[h] = row + (ptrdiff_t)(k * (W / 4) + h) * step;
    return rf_load_quarters(at, 1);
}

/* By fours: the minima of transposes, and of their quarters. */
CW_INLINE void rf_lowest_of_each(const float_reg a[16], float out[16]) {
    for (int k = 0; k < 16; k += 4) {
        float_reg r[4];
        float lowest[W];
        transpose(a + k, r);
        rf_store(lowest, rf_min(rf_min(r[0], r[1]), rf_min(r[2], r[3])));
        for (int c = 0; c < 4; c++) {
            out[k + c] = lowest[c];
            for (int q = 4; q < W; q += 4) out[k + c] = lowest[q + c] < out[k + c] ? lowest[q + c] : out[k + c];
        }
    }
}

#endif
