/* SPDX-License-Identifier: Apache-2.0 */
/* The least and the greatest of many floats. */
#ifndef CELLWALK_BASE_EXTREMES_H
#define CELLWALK_BASE_EXTREMES_H

#include <math.h>
#include <stddef.h>

/* Of n floats; NaN counts as none. INFINITY and -INFINITY where none are left. Each lane keeps its own: where there may
 * be NaN, compilers make vectors of that, and not of one number for all. */
static inline void extremes_of(const float *z, size_t n, float *low, float *high) {
    enum { LANES = 32 };
    float lows[LANES], highs[LANES];
    for (size_t k = 0; k < LANES; k++) {
        lows[k] = INFINITY;
        highs[k] = -INFINITY;
    }
    for (; n >= LANES; n -= LANES, z += LANES)
        for (size_t k = 0; k < LANES; k++) {
            lows[k] = z[k] < lows[k] ? z[k] : lows[k];
            highs[k] = z[k] > highs[k] ? z[k] : highs[k];
        }
    *low = INFINITY;
    *high = -INFINITY;
    for (size_t k = 0; k < n; k++) {
        *low = z[k] < *low ? z[k] : *low;
        *high = z[k] > *high ? z[k] : *high;
    }
    for (size_t k = 0; k < LANES; k++) {
        *low = lows[k] < *low ? lows[k] : *low;
        *high = highs[k] > *high ? highs[k] : *high;
    }
}

#endif
