/* SPDX-License-Identifier: Apache-2.0 */
/* How far a ray and the rays of the neighbouring samples, to the right and below, are apart (Igehy 1999). */
#ifndef CELLWALK_SCENE_SPREAD_H
#define CELLWALK_SCENE_SPREAD_H

#include "float3.h"

typedef struct ray_spread {
    float org[2][3], dir[2][3];
} ray_spread;

/* Changes of the point at t, in a plane with this normal, from one sample to the next. */
static inline void spread_on_plane(const ray_spread *spread, const float dir[3], float t, const float normal[3],
                                   float change[2][3]) {
    const float steepness = 1 / float3_dot(dir, normal);
    for (int k = 0; k < 2; k++) {
        float apart[3];
        for (int c = 0; c < 3; c++) apart[c] = spread->org[k][c] + t * spread->dir[k][c];
        const float further = float3_dot(apart, normal) * steepness;
        for (int c = 0; c < 3; c++) change[k][c] = apart[c] - further * dir[c];
        /* A ray that runs along the surface says nothing about the size of the sample's footprint. */
        if (!isfinite(float3_dot(change[k], change[k]))) change[k][0] = change[k][1] = change[k][2] = 0;
    }
}

/* The rays reflected where the point changes by change and the unit normal by turn. */
static inline void spread_reflect(const ray_spread *spread, const float dir[3], const float normal[3],
                                  float change[2][3], float turn[2][3], ray_spread *out) {
    const float along = float3_dot(dir, normal);
    for (int k = 0; k < 2; k++) {
        const float along_change = float3_dot(spread->dir[k], normal) + float3_dot(dir, turn[k]);
        for (int c = 0; c < 3; c++) {
            out->org[k][c] = change[k][c];
            out->dir[k][c] = spread->dir[k][c] - 2 * (along * turn[k][c] + along_change * normal[c]);
        }
    }
}

#endif
