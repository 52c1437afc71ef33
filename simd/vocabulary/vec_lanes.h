/* SPDX-License-Identifier: Apache-2.0 */
/* For all vec_*.h, once W is defined: types, and words that compilers express in all instruction sets, by C operators
 * on vectors and by shuffles within quarters, four lanes each. Meanings for W > 1: vec_scalar.h, but for rf_mul_sub. */
#ifndef CELLWALK_SIMD_VEC_LANES_H
#define CELLWALK_SIMD_VEC_LANES_H

#include "cellwalk.h"

#include <stddef.h>

#if !defined(__clang__) && __GNUC__ < 12
#error "the kernels need GCC 12 or newer, or Clang"
#endif

/* Registers of a vector: 1, or 2 if the file that includes the vocabulary has defined it so. */
#ifndef REGISTERS
#define REGISTERS 1
#endif

/* For bodies that take constant arguments (leaf test, kind of query) or a ray by pointer: unless it is inlined, a
 * compiler keeps the choice at run time and writes the ray's sixteen vectors to the stack for the call. */
#define CW_INLINE static inline __attribute__((always_inline))

/* For bodies of which one copy serves all callers, whatever constants they pass. */
#ifdef __clang__
#define CW_ONE_COPY __attribute__((noinline))
#else
#define CW_ONE_COPY __attribute__((noipa))
#endif

#if W == 1
typedef float float_lanes, float_memory;
typedef int32_t signed_lanes;
typedef uint32_t int_lanes, int_memory;
typedef double double_lanes;
typedef bool lane_mask;
#else
#define VECTOR __attribute__((vector_size(4 * W)))
typedef VECTOR float float_lanes;
typedef VECTOR int32_t signed_lanes;
typedef VECTOR uint32_t int_lanes;  /* sums wrap around */
typedef VECTOR double double_lanes; /* half of the lanes */
/* At any address. Rejected: memcpy to a register, of which GCC makes more instructions. */
typedef VECTOR __attribute__((aligned(4), may_alias)) float float_memory;
typedef VECTOR __attribute__((aligned(4), may_alias)) uint32_t int_memory;
#if W < 16
typedef int_lanes lane_mask; /* all bits of a lane */
#else
typedef uint16_t lane_mask; /* a bit a lane, in a register for masks */
#endif
#undef VECTOR
#endif

typedef struct float_reg {
    float_lanes v;
} float_reg;
typedef struct int_reg {
    int_lanes v;
} int_reg;
typedef struct mask_reg {
    lane_mask v;
} mask_reg;
typedef struct double_reg {
    double_lanes v;
} double_reg;

/* Four floats, also where a register has one. */
typedef float quarter __attribute__((vector_size(16)));
typedef float quarter_memory __attribute__((vector_size(16), aligned(4), may_alias));
static inline quarter load_quarter(const float *from) { return *(const quarter_memory *)from; }

/* Bit k is the sign of float k of a quarter. */
static inline unsigned quarter_signs(quarter a) {
#ifdef __SSE__
    return (unsigned)__builtin_ia32_movmskps(a);
#else
    typedef uint32_t bits __attribute__((vector_size(16)));
    const bits b = (bits)a >> 31;
    return b[0] | b[1] << 1 | b[2] << 2 | b[3] << 3;
#endif
}

/* Float k of a quarter; GCC compiles a[k] through memory. */
#define QUARTER_FLOAT(a, k) (__builtin_shufflevector(a, a, k, k, k, k)[0])

/* A number in all lanes. Compilers leave the difference out, which keeps -0. */
static inline float_reg rf_set(float a) { return (float_reg){a - (float_lanes){0}}; }
static inline int_reg ri_set(int32_t a) { return (int_reg){(uint32_t)a + (int_lanes){0}}; }
static inline double_reg rd_set(double a) { return (double_reg){a - (double_lanes){0}}; }

/* by in [0, 31]; to the right, a in [0, 2^24]. */
#ifndef OTHER_SHIFTS
static inline int_reg ri_shift_right(int_reg a, int_reg by) { return (int_reg){a.v >> by.v}; }
static inline int_reg ri_shift_left(int_reg a, int_reg by) { return (int_reg){a.v << by.v}; }
#endif

#if W < 16
/* a b - c. The caller sees to it that a b is exact: so it may be fused with the same bits. */
static inline float_reg rf_mul_sub(float_reg a, float_reg b, float_reg c) { return (float_reg){a.v * b.v - c.v}; }
#define COMPARE(a, sign, b, name) ((lane_mask)((a)sign(b)))
static inline mask_reg ri_eq(int_reg a, int_reg b) { return (mask_reg){COMPARE(a.v, ==, b.v, EQ)}; }
#endif

#if W > 1
static inline float_reg rf_min(float_reg a, float_reg b);
static inline int_reg ri_where(mask_reg m, int_reg a);

#if !defined X || W == 16
static inline mask_reg rm_and(mask_reg a, mask_reg b) { return (mask_reg){(lane_mask)(a.v & b.v)}; }
static inline mask_reg rm_or(mask_reg a, mask_reg b) { return (mask_reg){(lane_mask)(a.v | b.v)}; }
static inline mask_reg rm_andnot(mask_reg a, mask_reg b) { return (mask_reg){(lane_mask)(a.v & ~b.v)}; }
#endif

static inline float_reg rf_abs(float_reg a) { return (float_reg){(float_lanes)((int_lanes)a.v & 0x7fffffff)}; }
static inline float_reg rf_flip(float_reg a, float_reg sign) {
    return (float_reg){(float_lanes)((int_lanes)a.v ^ (int_lanes)sign.v)};
}
static inline float_reg rf_power_of_2(int_reg k) { return (float_reg){(float_lanes)((k.v + 127) << 23)}; }
static inline float_reg rf_from_ri(int_reg a) {
    return (float_reg){__builtin_convertvector((signed_lanes)a.v, float_lanes)};
}
static inline int_reg ri_from_rf(float_reg a) {
    return (int_reg){(int_lanes) __builtin_convertvector(a.v, signed_lanes)};
}

#if W < 16
static inline mask_reg rm_set(bool a) { return (mask_reg){ri_set(-(int32_t)a).v}; }
static inline mask_reg rm_from_bits(unsigned bits) {
    static const uint32_t each[] = {1, 2, 4, 8, 16, 32, 64, 128};
    const int_lanes bit = *(const int_memory *)each;
    return (mask_reg){(lane_mask)(((bits + (int_lanes){0}) & bit) == bit)};
}
static inline int_reg ri_where(mask_reg m, int_reg a) { return (int_reg){a.v & m.v}; }
#endif

/* Lanes one by one, those outside m as 0; none is negative. Two at a time, which halves the number of extractions. (GCC
 * builds an array of all in memory, and loads then wait for it.) */
typedef struct lane_indices {
    uint32_t k[W];
} lane_indices;
static inline lane_indices lanes_out(int_reg index, mask_reg m) {
    typedef uint64_t pairs __attribute__((vector_size(4 * W)));
    const pairs pair = (pairs)ri_where(m, index).v;
    lane_indices out;
    for (int p = 0; p < W / 2; p++) {
        out.k[2 * p] = (uint32_t)pair[p];
        out.k[2 * p + 1] = (uint32_t)(pair[p] >> 32);
    }
    return out;
}

#if W == 4 /* without a gather instruction, lanes one by one, those outside m from base[0] */
static inline float_reg rf_gather(const float *base, int_reg index, mask_reg m) {
    const lane_indices at = lanes_out(index, m);
    const float_lanes each = {base[at.k[0]], base[at.k[1]], base[at.k[2]], base[at.k[3]]};
    return (float_reg){(float_lanes)((int_lanes)each & m.v)};
}
#endif

typedef int32_t table_entry __attribute__((may_alias)); /* or the bits of a float */
static inline int_reg ri_lookup(const table_entry table[16], int_reg k);
static inline float_reg rf_lookup(const float table[16], int_reg k) {
    return (float_reg){(float_lanes)ri_lookup((const table_entry *)table, k).v};
}

/* The register put together from its quarters. */
#if W == 4
static inline float_reg of_quarters(const quarter q[1]) { return (float_reg){q[0]}; }
static inline quarter quarter_of(float_reg a, int h) { return (void)h, a.v; }
#else
static inline float_reg of_quarters(const quarter q[W / 4]);
static inline quarter quarter_of(float_reg a, int h);
#endif

/* In each quarter four of its lanes, 0 to 3 of a and 4 to 7 of b. */
#define LANE(q, k)              ((k) < 4 ? 4 * (q) + (k) : W + 4 * (q) + (k)-4)
#define FOUR(q, k0, k1, k2, k3) LANE(q, k0), LANE(q, k1), LANE(q, k2), LANE(q, k3)
#if W == 4
#define PICK(a, b, ...) __builtin_shufflevector(a, b, FOUR(0, __VA_ARGS__))
#elif W == 8
#define PICK(a, b, ...) __builtin_shufflevector(a, b, FOUR(0, __VA_ARGS__), FOUR(1, __VA_ARGS__))
#else
#define PICK(a, b, ...)                                                                                                \
    __builtin_shufflevector(a, b, FOUR(0, __VA_ARGS__), FOUR(1, __VA_ARGS__), FOUR(2, __VA_ARGS__),                    \
                            FOUR(3, __VA_ARGS__))
#endif

/* 4 × 4 transposes: lane c of quarter q of out[k] becomes lane k of quarter q of r[c]. */
CW_INLINE void transpose(const float_reg r[4], float_reg out[4]) {
    const float_lanes a = PICK(r[0].v, r[1].v, 0, 4, 1, 5), b = PICK(r[0].v, r[1].v, 2, 6, 3, 7);
    const float_lanes c = PICK(r[2].v, r[3].v, 0, 4, 1, 5), d = PICK(r[2].v, r[3].v, 2, 6, 3, 7);
    out[0].v = PICK(a, c, 0, 1, 4, 5);
    out[1].v = PICK(a, c, 2, 3, 6, 7);
    out[2].v = PICK(b, d, 0, 1, 4, 5);
    out[3].v = PICK(b, d, 2, 3, 6, 7);
}

/* W / 4 quarters, from at[0], at[step] … */
static inline float_reg rf_load_quarters(const float *const *at, size_t step) {
    quarter q[W / 4];
    for (size_t h = 0; h < W / 4; h++) q[h] = load_quarter(at[h * step]);
    return of_quarters(q);
}

CW_INLINE void rf_load_quads(const float *const at[W], float_reg out[4]) {
    float_reg r[4];
    for (int q = 0; q < 4; q++) r[q] = rf_load_quarters(at + q, 4);
    transpose(r, out);
}

/* Indices are doubled as a vector, so that an address's own factor of 8 makes 16 bytes of them. */
CW_INLINE void rf_gather_quads(const float *base, int_reg index, mask_reg m, float_reg out[4]) {
    const lane_indices k = lanes_out((int_reg){index.v + index.v}, m);
    const float *at[W];
    for (int q = 0; q < W; q++) at[q] = base + 2 * (size_t)k.k[q];
    rf_load_quads(at, out);
}

/* Each pair as one 8-byte load; shuffles then separate the two floats. CPUs that split a gather into dozens of
 * operations take less time for both vectors this way than for one gather, and other CPUs no more. */
CW_INLINE void rf_gather_pairs(const float *base, int_reg index, mask_reg m, float_reg *first, float_reg *second) {
    typedef double two_floats __attribute__((aligned(4), may_alias)); /* no arithmetic, so their bits stay */
    typedef double two_pairs __attribute__((vector_size(16)));
    const lane_indices at = lanes_out(index, m);
    quarter q[2][W / 4]; /* lanes 4 h and 4 h + 1; the two after them */
    for (int p = 0; p < W / 2; p++) {
        const two_floats *a = (const two_floats *)(base + at.k[2 * p]),
                         *b = (const two_floats *)(base + at.k[2 * p + 1]);
        q[p % 2][p / 2] = (quarter)(two_pairs){*a, *b};
    }
    const float_lanes low = of_quarters(q[0]).v, high = of_quarters(q[1]).v;
    first->v = PICK(low, high, 0, 2, 4, 6);
    second->v = PICK(low, high, 1, 3, 5, 7);
}

/* Members in pairs of two; a hit is three pairs, four hits are quarters of six registers. */
CW_INLINE void rf_store_hits(cw_hit *hits, float_reg t, float_reg u, float_reg v, float_reg i, float_reg j,
                             mask_reg b) {
    const float_lanes whole_i = (float_lanes)ri_from_rf(i).v, whole_j = (float_lanes)ri_from_rf(j).v;
    const float_lanes in_b = (float_lanes)ri_where(b, ri_set(1)).v;
    float_lanes r[6];
    for (int half = 0; half < 2; half++) {
        const float_lanes ti = half ? PICK(t.v, whole_i, 2, 6, 3, 7) : PICK(t.v, whole_i, 0, 4, 1, 5);
        const float_lanes jb = half ? PICK(whole_j, in_b, 2, 6, 3, 7) : PICK(whole_j, in_b, 0, 4, 1, 5);
        const float_lanes uv = half ? PICK(u.v, v.v, 2, 6, 3, 7) : PICK(u.v, v.v, 0, 4, 1, 5);
        r[3 * half] = PICK(ti, jb, 0, 1, 4, 5);
        r[3 * half + 1] = PICK(uv, ti, 0, 1, 6, 7);
        r[3 * half + 2] = PICK(jb, uv, 2, 3, 6, 7);
    }
    for (int k = 0; k < 6; k++)
        for (int h = 0; h < W / 4; h++)
            *(quarter_memory *)((float *)hits + 24 * h + 4 * k) = quarter_of((float_reg){r[k]}, h);
}

static inline float_reg rf_load_block(const float *row, ptrdiff_t step, size_t k) {
    const float *at[W / 4];
    for (size_t h = 0; h < W / 4; h++) at[h] = row + (ptrdiff_t)(k * (W / 4) + h) * step;
    return rf_load_quarters(at, 1);
}

/* By fours: the minima of transposes, and of their quarters. */
CW_INLINE void rf_lowest_of_each(const float_reg a[16], float out[16]) {
    enum { QUARTERS = W / 4 };
    float_reg each[4];
    for (int k = 0; k < 4; k++) {
        float_reg r[4];
        transpose(a + 4 * k, r);
        each[k] = rf_min(rf_min(r[0], r[1]), rf_min(r[2], r[3]));
    }
    for (int k = 0; k < 4; k += QUARTERS) {
        float_reg lowest;
        for (int h = 0; h < QUARTERS; h++) {
            quarter q[QUARTERS];
            for (int c = 0; c < QUARTERS; c++) q[c] = quarter_of(each[k + c], h);
            lowest = h == 0 ? of_quarters(q) : rf_min(lowest, of_quarters(q));
        }
        *(float_memory *)(out + 4 * k) = lowest.v;
    }
}
#undef LANE
#undef FOUR
#undef PICK
#endif

#endif
