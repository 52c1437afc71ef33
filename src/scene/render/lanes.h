/* SPDX-License-Identifier: Apache-2.0 */
/* Computations on single paths: functions of floats that loops over paths are made of. Compilers turn such a
 * loop into vectors of any width, and the bits stay the same: each operation is IEEE's and rounds once, nothing is
 * fused or put in another order (src/flags.cmake), choices are by ?: and not by branches. */
#ifndef CELLWALK_SCENE_LANES_H
#define CELLWALK_SCENE_LANES_H

#include "plan.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* A function that is compiled into each place where it is called, with the constants that it is called with. */
#define LANE_INLINE static inline __attribute__((always_inline))

/* A row of a map times a vector, and times a point. */
LANE_INLINE float lane_turn(const float row[4], float x, float y, float z) {
    return row[0] * x + row[1] * y + row[2] * z;
}
LANE_INLINE float lane_move(const float row[4], float x, float y, float z) { return lane_turn(row, x, y, z) + row[3]; }

LANE_INLINE float lane_dot(float ax, float ay, float az, float bx, float by, float bz) {
    return ax * bx + ay * by + az * bz;
}

/* A row of the metric times a vector. */
LANE_INLINE float lane_row(const float g[6], int row, float x, float y, float z) {
    return row == 0   ? g[0] * x + g[5] * y + g[4] * z
           : row == 1 ? g[5] * x + g[1] * y + g[3] * z
                      : g[4] * x + g[3] * y + g[2] * z;
}

/* The square of a vector's length. */
LANE_INLINE float lane_square(const float g[6], float x, float y, float z) {
    return lane_dot(x, y, z, lane_row(g, 0, x, y, z), lane_row(g, 1, x, y, z), lane_row(g, 2, x, y, z));
}

/* The largest whole number not above x, for |x| < 2^31. */
LANE_INLINE int32_t lane_floor(float x) {
    const int32_t k = (int32_t)x;
    return k - (x < (float)k);
}

/* The smallest whole number not below x, for |x| < 2^31. */
LANE_INLINE int32_t lane_ceil(float x) {
    const int32_t k = (int32_t)x;
    return k + (x > (float)k);
}

/* 2^-x for x >= 0, to 2^-22 of itself, and 2^-126 beyond 126: a polynomial fitted at Chebyshev's points of [0, 1] times
 * an exact power. libm's own function takes another way on another CPU. */
LANE_INLINE float lane_halved(float x) {
    const float most = x < 126 ? x : 126;
    const int32_t whole = (int32_t)most;
    const float rest = most - (float)whole;
    float sum = 0.000109387524f;
    sum = sum * rest - 0.00127571622f;
    sum = sum * rest + 0.00958005845f;
    sum = sum * rest - 0.0554910353f;
    sum = sum * rest + 0.240224355f;
    sum = sum * rest - 0.693147047f;
    sum = sum * rest + 1.0f;
    const uint32_t bits = (uint32_t)(127 - whole) << 23;
    float power;
    memcpy(&power, &bits, sizeof power);
    return sum * power;
}

/* Two arrays as one in which they take turns. Vectors of any width have instructions for it. */
LANE_INLINE void lane_weave(const float *restrict a, const float *restrict b, size_t n, float *restrict out) {
    for (size_t k = 0; k < n; k++) {
        out[2 * k] = a[k];
        out[2 * k + 1] = b[k];
    }
}

/* An array's even places, then its odd ones. */
LANE_INLINE void lane_unweave(const float *restrict a, size_t n, float *restrict out) {
    for (size_t k = 0; k < n / 2; k++) {
        out[k] = a[2 * k];
        out[n / 2 + k] = a[2 * k + 1];
    }
}

#endif
