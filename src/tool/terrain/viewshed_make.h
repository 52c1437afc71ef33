/* SPDX-License-Identifier: Apache-2.0 */
/* The raster of `cellwalk viewshed`, observer after observer. */
#ifndef CELLWALK_TOOL_TERRAIN_VIEWSHED_MAKE_H
#define CELLWALK_TOOL_TERRAIN_VIEWSHED_MAKE_H

#include "observers.h"
#include "target.h"

typedef enum view_kind {
    VIEW_SEEN,   /* whether, or how many observers see the sample */
    VIEW_WEIGHT, /* the sum of their weights */
    VIEW_ANGLE,  /* at which angle above the eye's horizontal */
    VIEW_NEEDED  /* from which height above ground on a target is seen */
} view_kind;

typedef struct viewshed_request {
    observer_options observers;
    target_options target;
    double curvature; /* NaN if it was not given */
    view_kind kind;
    bool absolute;     /* of VIEW_NEEDED: heights */
    bool bands;        /* one for each observer */
    const char *table; /* a file with a line for each observer; NULL: none */
    bool full;         /* all of the raster, even with a greatest distance */
} viewshed_request;

bool viewshed_make(ground *g, const viewshed_request *request, io_error *error);

#endif
