/* SPDX-License-Identifier: Apache-2.0 */
/* What include/cellwalk.h promises about a ray before anything is asked of it, for the paths without strict.h. */
#ifndef CELLWALK_SCALAR_RAY_H
#define CELLWALK_SCALAR_RAY_H

#include "cellwalk.h"

#include <float.h>
#include <math.h>

/* t is clamped to plus or minus this: half the largest float, so that the length of a t-range is a float too. */
static inline float ray_t_limit(void) { return FLT_MAX / 2; }

/* A direction component whose reciprocal is no float counts as zero. */
static inline float ray_direction(float d) { return fabsf(1.0f / d) <= FLT_MAX ? d : 0; }

/* False if d is so large that its reciprocal is denormal, or infinite, or NaN. */
static inline bool ray_direction_counts(float d) { return fabsf(1.0f / d) >= FLT_MIN; }

/* The ray with all that applied; false if it misses whatever the field. */
static inline bool ray_clean(cw_ray *out, const cw_ray *ray) {
    const float *o = ray->org, *d = ray->dir, limit = ray_t_limit();
    const float poison = (o[0] * 0 + o[1] * 0) + o[2] * 0;
    if (!(poison == 0 && ray->tmin <= ray->tmax)) return false;
    if (!(ray_direction_counts(d[0]) && ray_direction_counts(d[1]) && ray_direction_counts(d[2]))) return false;
    *out = *ray;
    for (int c = 0; c < 3; c++) out->dir[c] = ray_direction(d[c]);
    out->tmin = ray->tmin > -limit ? ray->tmin : -limit;
    out->tmax = ray->tmax < limit ? ray->tmax : limit;
    return out->dir[0] != 0 || out->dir[1] != 0 || out->dir[2] != 0;
}

#endif
