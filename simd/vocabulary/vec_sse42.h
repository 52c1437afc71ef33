/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary for SSE4.2: 4 lanes, masks as all-ones lanes. Meanings are in vec_scalar.h. */
#ifndef CELLWALK_SIMD_VEC_SSE42_H
#define CELLWALK_SIMD_VEC_SSE42_H

#define W        4 /* lanes of a register */
#define X(name)  _mm_##name
#define I32      __m128i
#define HALF_REG __m128 /* its lower lanes */

#include "vec_x86.h"

/* There is no shift by a vector: times 2^by. */
static inline int_reg ri_shift_left(int_reg a, int_reg by) { return (int_reg){a.v * ri_from_rf(rf_power_of_2(by)).v}; }
/* Times 2^-by in floats, which hold the 24 bits of a and of the product. */
static inline int_reg ri_shift_right(int_reg a, int_reg by) {
    return ri_from_rf((float_reg){rf_from_ri(a).v * rf_power_of_2((int_reg){-by.v}).v});
}
static inline int_reg ri_lookup(const table_entry table[16], int_reg k) {
    const signed_lanes entry = {table[k.v[0]], table[k.v[1]], table[k.v[2]], table[k.v[3]]};
    return (int_reg){(int_lanes)entry};
}

static inline __m128 half_of(float_reg a, int k) { return k == 0 ? (__m128)a.v : _mm_movehl_ps(a.v, a.v); }
static inline float_reg of_halves(__m128 low, __m128 high) { return (float_reg){_mm_movelh_ps(low, high)}; }

#endif
