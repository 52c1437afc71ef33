/* SPDX-License-Identifier: Apache-2.0 */
/* Where in its pixel a sample lies: the first two dimensions of Sobol's sequence (Sobol' 1967), scrambled for each
 * pixel by Owen's nested permutations (Owen 1995) in the hashed form of Laine and Karras 2011. Any power of two of
 * consecutive samples is stratified in x, in y and in both; any other number is nearly so. */
#ifndef CELLWALK_SCENE_PATTERN_H
#define CELLWALK_SCENE_PATTERN_H

#include <stdint.h>

static inline uint32_t pattern_hash(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

static inline uint32_t reverse_bits(uint32_t x) {
    x = x << 16 | x >> 16;
    x = (x & 0x00ff00ff) << 8 | (x & 0xff00ff00) >> 8;
    x = (x & 0x0f0f0f0f) << 4 | (x & 0xf0f0f0f0) >> 4;
    x = (x & 0x33333333) << 2 | (x & 0xcccccccc) >> 2;
    return (x & 0x55555555) << 1 | (x & 0xaaaaaaaa) >> 1;
}

/* Numbers are kept with their bits reversed, as scrambling requires: each bit of the result depends on itself
 * and on the lower bits of x alone. */
static inline uint32_t scramble_reversed(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ x * 0x8d22f6e6u;
}

/* A sample's second dimension, whose matrix is Pascal's triangle modulo 2. The first is the sample's number itself: van
 * der Corput's, whose bits are reversed. */
static inline uint32_t pattern_second(uint32_t number) {
    uint32_t value = 0;
    for (uint32_t column = 0x80000000u; number != 0; number >>= 1, column ^= column >> 1)
        if (number & 1) value ^= column;
    return reverse_bits(value);
}

/* A pixel's seed for the first dimension, another one for another picture. That for the second is its hash. */
static inline uint32_t pattern_seed(uint32_t x, uint32_t y, uint32_t picture) {
    return pattern_hash(x + pattern_hash(y + pattern_hash(picture)));
}

/* In [0, 1): where a sample lies along one dimension; 24 bits, so that a float holds them. */
static inline float pattern_place(uint32_t dimension, uint32_t seed) {
    const uint32_t place = reverse_bits(scramble_reversed(dimension, seed));
    return (float)(int32_t)(place >> 8) * 0x1p-24f;
}

#endif
