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
    double curvature;     /* as cw_sight_init has it; not negative */
    sight_limits limits;  /* of the target */
} viewshed_desc;

typedef struct viewshed viewshed;

/* CW_ERROR_ARGUMENT if there is no ground at the place to stand on. Terrain and bounds must stay. */
cw_status cw_viewshed_create(const terrain *t, const sight_bounds *bounds, const viewshed_desc *desc, viewshed **v);
void cw_viewshed_destroy(viewshed *v);
const sight *cw_viewshed_sight(const viewshed *v);

/* As cw_viewshed. */
cw_status cw_viewshed_see(const viewshed *v, const cw_run *run, cw_area area, const cw_view *view);

#endif
