/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors of three floats, for what only decides how bright a sample is: directions, normals, differentials. Points stay
 * in double, because a scene may lie far from its origin. */
#ifndef CELLWALK_SCENE_FLOAT3_H
#define CELLWALK_SCENE_FLOAT3_H

#include <math.h>

static inline float float3_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void float3_from(const double v[3], float out[3]) {
    for (int c = 0; c < 3; c++) out[c] = (float)v[c];
}

static inline void float3_normalise(float v[3]) {
    const float scale = 1 / sqrtf(float3_dot(v, v));
    for (int c = 0; c < 3; c++) v[c] *= scale;
}

#endif
