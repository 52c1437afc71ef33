/* SPDX-License-Identifier: Apache-2.0 */
/* Half-precision floats: 1 bit of sign, 5 of exponent, 10 of mantissa. */
#ifndef CELLWALK_IO_HALF_H
#define CELLWALK_IO_HALF_H

#include <stdint.h>
#include <string.h>

/* Rounds to nearest, ties to even. */
static inline uint16_t half_from_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    const uint32_t size = bits & 0x7fffffff;
    uint32_t half;
    if (size > 0x7f800000) {
        half = 0x7e00; /* NaN */
    } else if (size >= 0x477ff000) {
        half = 0x7c00; /* from halfway between 65504 and 65536 */
    } else if (size < 0x38800000) {
        /* Below 2^-14 halves are multiples of 2^-24, and so are floats in [0.5, 1): the addition rounds. */
        float magnitude;
        memcpy(&magnitude, &size, sizeof magnitude);
        magnitude += 0.5f;
        memcpy(&half, &magnitude, sizeof half);
        half -= 0x3f000000;
    } else {
        half = (size - (112u << 23) + 0xfff + (size >> 13 & 1)) >> 13;
    }
    return (uint16_t)(sign | half);
}

/* Exact for every number. Infinity and NaN become numbers of at least 65536: nobody wants them in a sum of texels. */
static inline float half_number(uint16_t half) {
    const uint32_t size = (uint32_t)(half & 0x7fff) << 13, sign = (uint32_t)(half & 0x8000) << 16;
    float value;
    memcpy(&value, &size, sizeof value);
    value *= 0x1p112f; /* the difference of the exponents' biases; denormals get theirs right, too */
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits |= sign;
    memcpy(&value, &bits, sizeof value);
    return value;
}

#endif
