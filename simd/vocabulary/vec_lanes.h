/* SPDX-License-Identifier: Apache-2.0 */
/* What all vec_*.h of more than one lane have in common: words that take a register by quarters, four lanes each. Included at
 * their ends, since it needs of each
 *
 *     transpose(r, out)            4 × 4 transposes: lane c of quarter q of out[k] is lane k of quarter q of r[c]
 *     rf_load_quarters(at, step)   W / 4 quarters, from at[0], at[step] …
 *     lanes_out(index, m)          lanes one by one, those outside m as 0; none is negative */
#ifndef CELLWALK_SIMD_VEC_LANES_H
#define CELLWALK_SIMD_VEC_LANES_H

#include <stddef.h>

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

#endif
