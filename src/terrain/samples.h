/* SPDX-License-Identifier: Apache-2.0 */
/* Access to a field's samples without a copy, and the rounding within which a place on a ray is a sample's. */
#ifndef CELLWALK_TERRAIN_SAMPLES_H
#define CELLWALK_TERRAIN_SAMPLES_H

#include "cellwalk.h"

/* How far rounding can put a place on the ray off, as a part of the distance from the start along the longer axis:
 * the direction's components, their quotient and the product are each off by 2^-53. A place nearer to a sample than
 * that is the sample's: it would be wrong to read the one beyond, which may not exist. */
#define PLACE_ROUNDING 0x1p-50

typedef struct samples {
    const float *z; /* sample (i, j) is z[j * stride + i]; a hole is NaN */
    size_t nx, ny, stride, holes;
    float low, high; /* high < low: all are holes */
} samples;

static inline samples samples_of(const cw_field *field) {
    const cw_field_info info = cw_field_describe(field);
    const float *z = cw_field_row(field, 0);
    return (samples){z, info.nx, info.ny, (size_t)(cw_field_row(field, 1) - z), info.holes, info.low, info.high};
}

#endif
