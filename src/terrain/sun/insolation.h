/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight over a day or a year: direct light on every sample, summed over many places of the sun. */
#ifndef CELLWALK_TERRAIN_INSOLATION_H
#define CELLWALK_TERRAIN_INSOLATION_H

#include "sun.h"
#include "terrain.h"

typedef struct insolation insolation;

typedef struct insolation_desc {
    /* Azimuths are the map's. Places at or below the level give no light. Copied. */
    const sun_position *suns;
    size_t count;
    double hours; /* that each of them stands for */
    /* Copied; or NULL. In place of hours, one for each sun; its light is then its weight on a surface that faces it,
     * whatever the air. */
    const double *weights;
    double linke;     /* turbidity (sun.h) */
    double curvature; /* as cw_sight_init takes it; 0: the earth is flat */
    /* 0: shadows are exact, in the direction of each sun. Else the sun casts its shadow from the nearest of so many
     * directions evenly all round, so that suns that share one also share one horizon: its azimuth is off by up to
     * 180 / directions degrees. At most COMPASS_MOST (compass.h). */
    size_t directions;
} insolation_desc;

/* The terrain must stay. */
cw_status cw_insolation_create(const terrain *t, const insolation_desc *desc, insolation **sum);
void cw_insolation_destroy(insolation *sum);

/* In how many directions the terrain is looked at. */
size_t cw_insolation_directions(const insolation *sum);
/* One of them: its azimuth, and the altitude of the lowest sun there, in degrees. */
void cw_insolation_direction(const insolation *sum, size_t number, double *azimuth, double *lowest);

/* Hours in which the middle of the sun is seen, or the sum of the weights of suns that are; NaN at a hole. */
cw_status cw_insolation_hours(insolation *sum, const cw_run *run, cw_area area, float *hours);

/* Energy of the direct light on the surface as it leans, in Wh/m² of surface. Samples below -1000 m and above
 * 10000 m count as being there. NaN at a hole, and at a sample of no triangle, which has no lean. */
cw_status cw_insolation_direct(insolation *sum, const cw_run *run, cw_area area, float *energy);

/* Energy of the diffuse light of the whole sky on level ground, in Wh/m²: the same at all heights. */
double cw_insolation_diffuse(const insolation *sum);

#endif
