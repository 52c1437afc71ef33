/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight on every sample: whether the sun is seen, how much of its disc, and how much light falls on the ground. */
#ifndef CELLWALK_TERRAIN_SHADOW_H
#define CELLWALK_TERRAIN_SHADOW_H

#include "terrain.h"

typedef struct sunlight sunlight;

typedef struct sunlight_desc {
    double azimuth, altitude; /* degrees */
    double radius;            /* of the disc in degrees; 0: the sun is a point */
    unsigned strips;          /* upright ones that the disc is cut into, up to 64; 0: 16 */
    double curvature;         /* as sight_init takes it; 0: the earth is flat */
    bool hillshade;           /* times the cosine of the angle between the sun and the ground's normal */
} sunlight_desc;

enum { SUNLIGHT_STRIPS_MOST = 64 };

/* The azimuths in which shadows are looked for, in degrees: how many there are. */
size_t sunlight_azimuths(const sunlight_desc *desc, double azimuths[SUNLIGHT_STRIPS_MOST]);

/* The terrain must stay. */
cw_status sunlight_create(const terrain *t, const sunlight_desc *desc, sunlight **light);
void sunlight_destroy(sunlight *light);

/* Once all of the sun is lower than a free horizon at the sample's height over the sea, the sample is in the shadow,
 * though nothing of the terrain may hide the sun at the raster's rim. */

/* Of a point without hillshade: lit[y * nx + x] is 1 in the sun, 0 in the shadow, 255 at a hole, for rows row to
 * row + rows - 1. A ray that touches the surface is in the shadow. */
cw_status sunlight_lit(sunlight *light, const cw_run *query, size_t row, size_t rows, uint8_t *lit);

/* Of any: the share of the light, 0 to 1; NaN at a hole. */
cw_status sunlight_share(sunlight *light, const cw_run *query, size_t row, size_t rows, float *share);

#endif
