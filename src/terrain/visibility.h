/* SPDX-License-Identifier: Apache-2.0 */
/* How much every place sees: the ground in sight of an eye above each sample, along even directions.
 *
 * Along each direction the parts of the surface in sight are exact (cw_visible_add). The area is the sum over directions of
 * (2 π / count) ∫ t dt over the distances t in sight: papers/terrain.md has its error by the number of directions. */
#ifndef CELLWALK_TERRAIN_VISIBILITY_H
#define CELLWALK_TERRAIN_VISIBILITY_H

#include "terrain.h"

enum { VISIBILITY_DIRECTIONS_MOST = 3600 };

typedef struct visibility_desc {
    size_t directions;    /* 1 to VISIBILITY_DIRECTIONS_MOST; azimuths 0, 360 / directions, … */
    double eye_height;    /* metres above the sample, not negative */
    double target_height; /* of what must be seen, above the ground, not negative */
    double max_distance;  /* metres: what is farther away does not count; 0: no limit */
    double curvature;     /* as sight_init takes it; 0: the earth is flat */
    size_t every;         /* eyes are at every so many columns and rows of the rectangle, from its first ones on */
} visibility_desc;

/* For each eye, row by row, NaN at holes; any but azimuth may be NULL. */
typedef struct visibility_answers {
    float *area;     /* square kilometres in sight */
    float *share;    /* that area as a share of all within the raster and max_distance; holes count as not in sight */
    float *farthest; /* metres to the farthest place in sight; 0: there is none */
    float *azimuth;  /* of that place, in degrees; NaN: there is none. NULL if farthest is */
} visibility_answers;

/* The eyes of a rectangle of samples: ceil(nx / every) in a row. run's watch is not used; progress may be NULL.
 * CW_ERROR_ARGUMENT, _MEMORY, and those of run. */
cw_status visibility_find(const terrain *t, const visibility_desc *desc, const cw_run *run, cw_rectangle at,
                          const visibility_answers *to, terrain_progress *progress, void *context, bool *done);

#endif
