/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary: the words of an instruction set (vec_*.h) for vectors of REGISTERS registers each.
 *
 * CELLWALK_VOCABULARY is the header of the instruction set, from simd/isas.cmake. It has W lanes a register, types
 * float_reg, int_reg, mask_reg and double_reg, and the words rf_min, rm_and and so on for one register. Here vf_min is
 * rf_min for each register of a vector, and so for all others, and vf_add is the operator +. vec_scalar.h says what
 * each word means.
 *
 * Why two registers: a step of the lane walk is one chain of some forty dependent operations, longer than the CPU can
 * look ahead, so one register leaves most of its units idle. Two in lockstep, operation by operation, are two chains at
 * once. Rejected: vectors that take turns step by step, since the CPU still sees one chain at a time. */
#ifndef CELLWALK_SIMD_VOCABULARY_H
#define CELLWALK_SIMD_VOCABULARY_H

#include CELLWALK_VOCABULARY

#include <string.h>

/* Names with the instruction set's width: CW_CODE(pyramid) is cw_pyramid1, cw_pyramid4, cw_pyramid8 or cw_pyramid16. */
#define CW_PASTE(kind, width)   cw_##kind##width
#define CW_CODE_OF(kind, width) CW_PASTE(kind, width)
#define CW_CODE(kind)           CW_CODE_OF(kind, W)

/* W: lanes of a register. LANES: lanes of a vector. */
enum { LANES = REGISTERS * W };

/* What is there for a second register alone. */
#if REGISTERS == 1
#define SECOND(...)
#else
#define SECOND(...) __VA_ARGS__
#endif

/* Rejected: arrays of registers and loops over them, which GCC copies through memory. Words are inlined as those
 * of registers are, or GCC does not inline these before it takes vectors apart. */
typedef struct vfloat {
    float_reg a;
    SECOND(float_reg b;)
} vfloat;
typedef struct vint {
    int_reg a;
    SECOND(int_reg b;)
} vint;
typedef struct vmask {
    mask_reg a;
    SECOND(mask_reg b;)
} vmask;

/* Doubles: of(d, half, r, how) makes member d of the result from that half of register r. One lane has no halves. */
#if W == 1
#define UPPER(...)
#else
#define UPPER(...) __VA_ARGS__
#endif
typedef struct vdouble {
    double_reg a0;
    UPPER(double_reg a1;)
    SECOND(double_reg b0; UPPER(double_reg b1;))
} vdouble;
#define DOUBLES(of, how)                                                                                               \
    (vdouble) { of(a0, 0, a, how) UPPER(, of(a1, 1, a, how)) SECOND(, of(b0, 0, b, how) UPPER(, of(b1, 1, b, how))) }

/* A word that does the same in each lane, of one to three vectors. */
#define ONE(result, word, of, type)                                                                                    \
    static inline result word(type x) { return (result){of(x.a) SECOND(, of(x.b))}; }
#define TWO(result, word, of, left, right)                                                                             \
    static inline result word(left x, right y) { return (result){of(x.a, y.a) SECOND(, of(x.b, y.b))}; }
#define THREE(result, word, of, first, type)                                                                           \
    static inline result word(first x, type y, type z) {                                                               \
        return (result){of(x.a, y.a, z.a) SECOND(, of(x.b, y.b, z.b))};                                                \
    }
#define SAME(result, word, of, type)                                                                                   \
    static inline result word(type x) { return (result){of(x) SECOND(, of(x))}; }
/* At any address. */
#define MEMORY(vector, load, store, type, memory)                                                                      \
    static inline vector load(const type *from) {                                                                      \
        return (vector){{*(const memory *)from} SECOND(, {*(const memory *)(from + W)})};                              \
    }                                                                                                                  \
    static inline void store(type *to, vector x) {                                                                     \
        *(memory *)to = x.a.v;                                                                                         \
        SECOND(*(memory *)(to + W) = x.b.v;)                                                                           \
    }

/* A word that is an operator of C, which compilers have for vectors too. */
/* clang-format off: a word a line */
#define OPERATOR(type, lanes, word, sign)                                                                              \
    static inline type word(type x, type y) {                                                                          \
        return (type){{(lanes)(x.a.v sign y.a.v)} SECOND(, {(lanes)(x.b.v sign y.b.v)})};                              \
    }
#define COMPARISON(word, sign, name)                                                                                   \
    static inline vmask word(vfloat x, vfloat y) {                                                                     \
        return (vmask){{COMPARE(x.a.v, sign, y.a.v, name)} SECOND(, {COMPARE(x.b.v, sign, y.b.v, name)})};             \
    }
SAME(vfloat, vf_set, rf_set, float)
SAME(vint, vi_set, ri_set, int32_t)
SAME(vmask, vm_set, rm_set, bool)
MEMORY(vfloat, vf_load, vf_store, float, float_memory)
MEMORY(vint, vi_load, vi_store, int32_t, int_memory)
THREE(vfloat, vf_select, rf_select, vmask, vfloat)
THREE(vint, vi_select, ri_select, vmask, vint)
OPERATOR(vfloat, float_lanes, vf_add, +)
OPERATOR(vfloat, float_lanes, vf_sub, -)
OPERATOR(vfloat, float_lanes, vf_mul, *)
OPERATOR(vfloat, float_lanes, vf_div, /)
THREE(vfloat, vf_mul_sub, rf_mul_sub, vfloat, vfloat)
TWO(vfloat, vf_min, rf_min, vfloat, vfloat)
TWO(vfloat, vf_max, rf_max, vfloat, vfloat)
TWO(vfloat, vf_flip, rf_flip, vfloat, vfloat)
ONE(vfloat, vf_abs, rf_abs, vfloat)
ONE(vfloat, vf_floor, rf_floor, vfloat)
ONE(vfloat, vf_from_vi, rf_from_ri, vint)
ONE(vfloat, vf_power_of_2, rf_power_of_2, vint)
ONE(vint, vi_from_vf, ri_from_rf, vfloat)
COMPARISON(vf_lt, <, LT)
COMPARISON(vf_le, <=, LE)
COMPARISON(vf_gt, >, GT)
COMPARISON(vf_ge, >=, GE)
COMPARISON(vf_eq, ==, EQ)
OPERATOR(vint, int_lanes, vi_add, +)
OPERATOR(vint, int_lanes, vi_sub, -)
OPERATOR(vint, int_lanes, vi_mul, *)
OPERATOR(vint, int_lanes, vi_and, &)
OPERATOR(vint, int_lanes, vi_or, |)
OPERATOR(vint, int_lanes, vi_xor, ^)
TWO(vint, vi_shift_left, ri_shift_left, vint, vint)
TWO(vint, vi_shift_right, ri_shift_right, vint, vint)
TWO(vint, vi_where, ri_where, vmask, vint)
TWO(vmask, vi_eq, ri_eq, vint, vint)
TWO(vmask, vm_and, rm_and, vmask, vmask)
TWO(vmask, vm_or, rm_or, vmask, vmask)
OPERATOR(vmask, lane_mask, vm_xor, ^)
TWO(vmask, vm_andnot, rm_andnot, vmask, vmask)
static inline vmask vm_not(vmask x) { return vm_xor(x, vm_set(true)); }
#define SET(d, half, r, word)    word(x)
#define HALF(d, half, r, word)   word(x.r, half)
#define SELECT(d, half, r, word) word(m.r, half, x.d, y.d)
#define BOTH(d, half, r, word)   word(x.d, y.d)
#define SIGN(d, half, r, sign)                                                                                         \
    { x.d.v sign y.d.v }
static inline vdouble vd_set(double x) { return DOUBLES(SET, rd_set); }
static inline vdouble vd_from_vf(vfloat x) { return DOUBLES(HALF, rd_from_rf); }
static inline vdouble vd_select(vmask m, vdouble x, vdouble y) { return DOUBLES(SELECT, rd_select); }
static inline vdouble vd_min(vdouble x, vdouble y) { return DOUBLES(BOTH, rd_min); }
static inline vdouble vd_max(vdouble x, vdouble y) { return DOUBLES(BOTH, rd_max); }
static inline vdouble vd_add(vdouble x, vdouble y) { return DOUBLES(SIGN, +); }
static inline vdouble vd_sub(vdouble x, vdouble y) { return DOUBLES(SIGN, -); }
static inline vdouble vd_mul(vdouble x, vdouble y) { return DOUBLES(SIGN, *); }
static inline vdouble vd_div(vdouble x, vdouble y) { return DOUBLES(SIGN, /); }
static inline vfloat vf_from_vd(vdouble x) {
    return (vfloat){rf_from_rd(x.a0 UPPER(, x.a1)) SECOND(, rf_from_rd(x.b0 UPPER(, x.b1)))};
}
static inline vfloat vf_lookup(const float table[16], vint k) {
    return (vfloat){rf_lookup(table, k.a) SECOND(, rf_lookup(table, k.b))};
}
static inline vint vi_lookup(const int32_t table[16], vint k) {
    return (vint){ri_lookup(table, k.a) SECOND(, ri_lookup(table, k.b))};
}
/* clang-format on */

#undef ONE
#undef TWO
#undef THREE
#undef OPERATOR
#undef COMPARISON
#undef SAME
#undef MEMORY
#undef SET
#undef HALF
#undef SELECT
#undef BOTH
#undef SIGN

static inline vmask vm_from_bits(unsigned bits) {
    return (vmask){rm_from_bits(bits) SECOND(, rm_from_bits(bits >> W))};
}
/* Lanes 0 to n - 1. */
static inline vmask vm_first(size_t n) { return vm_from_bits(n < LANES ? (1u << n) - 1 : ~0u); }
static inline bool vm_any(vmask x) { return rm_any((mask_reg){(lane_mask)(x.a.v SECOND(| x.b.v))}); }
static inline unsigned vm_bits(vmask a) { return rm_bits(a.a) SECOND(| rm_bits(a.b) << W); }

/* Lane k of a vector in memory. */
static inline float vf_lane(const vfloat *a, unsigned k) {
    float lane;
    memcpy(&lane, (const char *)a + k * sizeof lane, sizeof lane);
    return lane;
}

static inline vfloat vf_gather(const float *base, vint index, vmask m) {
    return (vfloat){rf_gather(base, index.a, m.a) SECOND(, rf_gather(base, index.b, m.b))};
}
CW_INLINE void vf_gather_pairs(const float *base, vint index, vmask m, vfloat *first, vfloat *second) {
    rf_gather_pairs(base, index.a, m.a, &first->a, &second->a);
    SECOND(rf_gather_pairs(base, index.b, m.b, &first->b, &second->b);)
}

/* Puts n vectors together from their registers. */
CW_INLINE void join(const float_reg *first, const float_reg *second, vfloat *out, size_t n) {
    (void)second;
    for (size_t k = 0; k < n; k++) out[k] = (vfloat){first[k] SECOND(, second[k])};
}
CW_INLINE void vf_gather_quads(const float *base, vint index, vmask m, vfloat out[4]) {
    float_reg quad[REGISTERS][4];
    rf_gather_quads(base, index.a, m.a, quad[0]);
    SECOND(rf_gather_quads(base, index.b, m.b, quad[1]);)
    join(quad[0], quad[REGISTERS - 1], out, 4);
}

/* Rays anywhere, a pointer a lane, to one vector each of org x y z, tmin, dir x y z, tmax. */
CW_INLINE void vf_load_each_ray(const cw_ray *const rays[LANES], vfloat out[8]) {
    float_reg quad[REGISTERS][8];
    for (int r = 0; r < REGISTERS; r++)
        for (int half = 0; half < 2; half++) {
            const float *at[W];
            for (int k = 0; k < W; k++) at[k] = (const float *)rays[r * W + k] + 4 * half;
            rf_load_quads(at, quad[r] + 4 * half);
        }
    join(quad[0], quad[REGISTERS - 1], out, 8);
}
/* The same of consecutive rays. */
CW_INLINE void vf_load_rays(const cw_ray *rays, vfloat out[8]) {
    const cw_ray *at[LANES];
    for (int k = 0; k < LANES; k++) at[k] = rays + k;
    vf_load_each_ray(at, out);
}
CW_INLINE void vf_store_hits(cw_hit *hits, vfloat t, vfloat u, vfloat v, vfloat i, vfloat j, vmask b) {
    rf_store_hits(hits, t.a, u.a, v.a, i.a, j.a, b.a);
    SECOND(rf_store_hits(hits + W, t.b, u.b, v.b, i.b, j.b, b.b);)
}

CW_INLINE void vf_lowest_of_each(const vfloat a[16], float out[16]) {
    float_reg lowest[16];
    for (int k = 0; k < 16; k++) {
        lowest[k] = a[k].a;
        SECOND(lowest[k] = rf_min(lowest[k], a[k].b);)
    }
    rf_lowest_of_each(lowest, out);
}

static inline vfloat vf_load_block(const float *row, ptrdiff_t step, size_t k) {
    return (vfloat){rf_load_block(row, step, REGISTERS * k) SECOND(, rf_load_block(row, step, 2 * k + 1))};
}

#undef DOUBLES
#undef UPPER
#undef SECOND

#endif
