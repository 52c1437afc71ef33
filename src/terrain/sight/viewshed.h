/* SPDX-License-Identifier: Apache-2.0 */
/* Visibility from a place: for each sample, whether the straight line from the observer's eye to it, or to something of a
 * given height on it, passes above the surface. A line that touches it on the way is blocked. */
#ifndef CELLWALK_TERRAIN_VIEWSHED_H
#define CELLWALK_TERRAIN_VIEWSHED_H

#include "view_limits.h"

typedef struct viewshed_desc {
    double place[2];      /* of the observer, in field coordinates; may lie outside the field */
    double height;        /* of the eye in metres, above the ground, or absolute */
    bool absolute;        /* must be, if the place is outside or over a hole */
    double target_height; /* metres above the ground */
    double curvature;     /* as sight_init has it; not negative */
    sight_limits limits;  /* of the target */
} viewshed_desc;

typedef struct viewshed viewshed;

/* CW_ERROR_ARGUMENT if there is no ground at the place to stand on. Terrain and bounds must stay. */
cw_status viewshed_create(const terrain *t, const sight_bounds *bounds, const viewshed_desc *desc, viewshed **v);
void viewshed_destroy(viewshed *v);
const sight *viewshed_sight(const viewshed *v);

/* Adds 1 to seen[j * nx + i] where sample (i, j) is seen. *done: false if progress ended it. progress may be NULL. */
cw_status viewshed_count(const viewshed *v, const cw_run *query, uint16_t *seen, terrain_progress *progress,
                         void *context, bool *done);

/* The same, but adds weight. */
cw_status viewshed_weigh(const viewshed *v, const cw_run *query, double weight, double *sums,
                         terrain_progress *progress, void *context, bool *done);

/* The target's angle above the eye's horizontal, in degrees, at each sample that is seen; NaN elsewhere. */
cw_status viewshed_angles(const viewshed *v, const cw_run *query, float *angles, terrain_progress *progress,
                          void *context, bool *done);

/* The height above ground, in metres, that is needed at each sample to be seen, 0 where the ground is seen itself, NaN at
 * holes and outside the limits, which must not have vertical angles. */
cw_status viewshed_heights(const viewshed *v, const cw_run *query, float *heights, terrain_progress *progress,
                           void *context, bool *done);

#endif
