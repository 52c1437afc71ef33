/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary one lane wide, in plain C. Tests compare the other vocabularies with it, and CPUs without
 * SSE4.2 run it. It also documents the vocabulary: every vec_*.h has the same names with the same meaning, lane by
 * lane, bit for bit. Operators of C (vf_add, vi_and, vf_lt …) are in vocabulary.h, some words for all in vec_lanes.h.
 *
 * float_reg, int_reg and mask_reg are three distinct types, so that a mask cannot be used as a number by mistake.
 * Arithmetic is IEEE, rounded once an operation. Comparisons are false on NaN. */
#ifndef CELLWALK_SIMD_VEC_SCALAR_H
#define CELLWALK_SIMD_VEC_SCALAR_H

#define W 1 /* lanes of a register */

#include "vec_lanes.h"

#include <math.h>

/* a < b ? a : b and a > b ? a : b, so b where either is NaN. */
static inline float_reg rf_min(float_reg a, float_reg b) { return (float_reg){a.v < b.v ? a.v : b.v}; }
static inline float_reg rf_max(float_reg a, float_reg b) { return (float_reg){a.v > b.v ? a.v : b.v}; }
static inline float_reg rf_abs(float_reg a) { return (float_reg){fabsf(a.v)}; }
static inline float_reg rf_floor(float_reg a) { return (float_reg){floorf(a.v)}; }

/* m ? a : b */
static inline float_reg rf_select(mask_reg m, float_reg a, float_reg b) { return m.v ? a : b; }
static inline int_reg ri_select(mask_reg m, int_reg a, int_reg b) { return m.v ? a : b; }
/* Toward zero; a within int32. */
static inline int_reg ri_from_rf(float_reg a) { return (int_reg){(uint32_t)(int32_t)a.v}; }
static inline float_reg rf_from_ri(int_reg a) { return (float_reg){(float)(int32_t)a.v}; }
/* table[k] of 16 entries, k in [0, 15] */
static inline float_reg rf_lookup(const float table[16], int_reg k) { return rf_set(table[k.v]); }
static inline int_reg ri_lookup(const int32_t table[16], int_reg k) { return ri_set(table[k.v]); }
static inline int_reg ri_where(mask_reg m, int_reg a) { return (int_reg){m.v ? a.v : 0}; }
/* sign: 0 or -0 */
static inline float_reg rf_flip(float_reg a, float_reg sign) { return (float_reg){signbit(sign.v) ? -a.v : a.v}; }
static inline float_reg rf_power_of_2(int_reg k) { /* k in [-126, 127] */
    const union {
        uint32_t bits;
        float v;
    } a = {(k.v + 127) << 23};
    return (float_reg){a.v};
}

/* Rejected: & and |, of which GCC makes up to a fifth more instructions. */
static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){a.v && b.v}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){a.v || b.v}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){a.v && !b.v}; } /* a and not b */
static inline mask_reg rm_set(bool a) { return (mask_reg){a}; }
/* Lane k = bit k; further bits are ignored. */
static inline mask_reg rm_from_bits(unsigned bits) { return (mask_reg){bits & 1}; }
static inline bool rm_any(mask_reg a) { return a.v; }
static inline unsigned rm_bits(mask_reg a) { return a.v; } /* bit k = lane k */

/* base[index] where m, else 0; indices of lanes outside m are not used. */
static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    return (float_reg){m.v ? base[(int32_t)index.v] : 0};
}

/* base[index] and base[index + 1] where m, else base[0] and base[1]. */
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    const int32_t k = m.v ? (int32_t)index.v : 0;
    first->v = base[k];
    second->v = base[k + 1];
}

/* base[4 index] to base[4 index + 3] where m, else base[0] to base[3]; base + 4 k is aligned to 16 bytes. */
CW_INLINE void rf_gather_quads(const float *base, int_reg index, mask_reg m, float_reg out[4]) {
    const float *from = base + 4 * (ptrdiff_t)(m.v ? (int32_t)index.v : 0);
    for (int c = 0; c < 4; c++) out[c].v = from[c];
}

/* Four floats from each lane's address. */
CW_INLINE void rf_load_quads(const float *const at[1], float_reg out[4]) {
    for (int c = 0; c < 4; c++) out[c].v = at[0][c];
}

/* W hits of consecutive lanes, from one vector each of t, u, v, i, j, triangle to an array of structures. i and j
 * are whole numbers; triangle is B where b. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
    *hits = (cw_hit){.t = t.v, .i = (int32_t)i.v, .j = (int32_t)j.v, .triangle = b.v, .u = u.v, .v = v.v};
}

/* The lowest lane of each of 16 vectors. No lane is NaN. */
CW_INLINE void rf_lowest_of_each(const float_reg a[16], float out[16]) {
    for (int k = 0; k < 16; k++) out[k] = a[k].v;
}

/* Doubles, for numbers that are computed once a ray or once a hit. One register of them, or two if W > 1, has the lanes
 * of one of floats, in order. These are the lanes of register k. */
static inline double_reg rd_from_rf(float_reg a, int k) { return (void)k, (double_reg){(double)a.v}; }
static inline float_reg rf_from_rd(double_reg a) { return (float_reg){(float)a.v}; } /* to nearest */
/* As rf_min and rf_max. */
static inline double_reg rd_min(double_reg a, double_reg b) { return (double_reg){a.v < b.v ? a.v : b.v}; }
static inline double_reg rd_max(double_reg a, double_reg b) { return (double_reg){a.v > b.v ? a.v : b.v}; }
/* Where the lanes of register k in m are set, a, else b. */
static inline double_reg rd_select(mask_reg m, int k, double_reg a, double_reg b) { return (void)k, m.v ? a : b; }

/* Lanes k W to k W + W - 1 of a block of 4 × 4 floats, by rows, which begin step floats apart from row on. */
static inline float_reg rf_load_block(const float *row, ptrdiff_t step, size_t k) {
    return (float_reg){row[(ptrdiff_t)(k >> 2) * step + (ptrdiff_t)(k & 3)]};
}

#endif
