/* SPDX-License-Identifier: Apache-2.0 */
/* Half-precision floats: 1 bit of sign, 5 of exponent, 10 of mantissa. */
#ifndef CELLWALK_BASE_HALF_H
#define CELLWALK_BASE_HALF_H

#include <stdint.h>

/* A float's bits. */
typedef union half_bits {
    float f;
    uint32_t bits;
} half_bits;

/* Rounds to nearest, ties to even. By choices and not by branches, so that compilers make vectors of loops over it. */
static inline uint16_t half_from_float(float value) {
    const half_bits in = {value};
    const int32_t size = (int32_t)(in.bits & 0x7fffffff);
    /* Below 2^-14 halves are multiples of 2^-24, and so are floats in [0.5, 1): the addition rounds. */
    half_bits small = {.bits = (uint32_t)size};
    small.f += 0.5f;
    const int32_t tiny = (int32_t)small.bits - 0x3f000000;
    const int32_t normal = (size - (112 << 23) + 0xfff + (size >> 13 & 1)) >> 13;
    const int32_t number = size < 0x38800000 ? tiny : normal;
    const int32_t above = size > 0x7f800000 ? 0x7e00 : 0x7c00; /* NaN; infinity, from halfway between 65504 and 65536 */
    return (uint16_t)((in.bits >> 16 & 0x8000) | (uint32_t)(size >= 0x477ff000 ? above : number));
}

/* Exact for every number. Infinity and NaN become numbers of at least 65536: they must not occur in a sum of texels. */
static inline float half_number(uint16_t half) {
    half_bits value = {.bits = (uint32_t)(half & 0x7fff) << 13};
    value.f *= 0x1p112f; /* the difference of the exponents' biases; denormals get theirs right, too */
    value.bits |= (uint32_t)(half & 0x8000) << 16;
    return value.f;
}

#endif
