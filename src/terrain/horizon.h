/* SPDX-License-Identifier: Apache-2.0 */
/* The horizon all round: how high the terrain stands against the sky in each direction, and how much of the sky is
 * left. */
#ifndef CELLWALK_TERRAIN_HORIZON_H
#define CELLWALK_TERRAIN_HORIZON_H

#include "terrain.h"

typedef struct horizon horizon;

typedef struct horizon_desc {
    double start;        /* directions are start, start + 360 / count, … in degrees of the compass */
    size_t count;        /* from 1 to COMPASS_MOST */
    double max_distance; /* metres: terrain farther away does not count; 0: no limit */
    double curvature;    /* as sight_init takes it; 0: the earth is flat */
    /* Of the terrain upside down: for negative openness alone. Its samples and their bounds are held beside the terrain's. Only
     * without curvature. */
    bool below;
} horizon_desc;

/* The terrain must stay. */
cw_status horizon_create(const terrain *t, const horizon_desc *desc, horizon **h);
void horizon_destroy(horizon *h);
double horizon_azimuth(const horizon *h, size_t number);

/* The angle in degrees at which the highest point of the terrain in direction number stands above the level of the
 * sample, negative below it, for rows row to row + rows - 1. -90 where the terrain ends at the sample or nothing of
 * it is within the distance, NaN at a hole. */
cw_status horizon_angles(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *degrees);

/* The distance in metres to the nearest place at which that angle is reached, on the map as terrain_direction has it. NaN where
 * nothing of the terrain is within the distance, and at a hole. The place is a line's crossing of an edge between two samples, in double: the nearest one whose rise is the steepest but for the rounding of both (sight_nearest).
 */
cw_status horizon_distances(horizon *h, const cw_run *query, size_t number, size_t row, size_t rows, float *metres);

/* Openness in degrees (R. Yokoyama, M. Shirasawa, R. J. Pike, Photogrammetric Engineering and Remote Sensing 68 (2002) 257-265): the
 * mean over the directions in which there is terrain of the angle between the zenith and the horizon, 90 on a plane, more on a summit.
 * NaN at a hole and where there is none. Of a horizon with `below` it is the negative one: between the nadir and the lowest
 * point, more at the bottom of a pit. */
cw_status horizon_openness(horizon *h, const cw_run *query, size_t row, size_t rows, float *degrees,
                           terrain_progress *progress, void *context, bool *done);

/* The share of the light of an evenly bright sky that reaches level ground, 0 to 1: the mean over all directions of the
 * cosine squared of the horizon's angle, where that is above the level. NaN at a hole. progress may be NULL. */
cw_status horizon_sky_view(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                           terrain_progress *progress, void *context, bool *done);

/* The same for the ground as it leans (normal.h): the mean of the sky's brightness weighted with the cosine of the
 * angle to the ground's normal. The ground hides the sky behind it, and nothing below the level is sky. A tilted
 * plane has (1 + cos tilt) / 2. */
cw_status horizon_sky_view_tilted(horizon *h, const cw_run *query, size_t row, size_t rows, float *share,
                                  terrain_progress *progress, void *context, bool *done);

/* Degrees whose tangent is x, off by less than 10^-5 degrees, by operations that are the same on every CPU. */
float horizon_degrees(float x);

#endif
