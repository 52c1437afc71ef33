/* SPDX-License-Identifier: Apache-2.0 */
/* A picture of a terrain: the scene that `cellwalk render` makes of a raster. */
#ifndef CELLWALK_TOOL_TERRAIN_VIEW_H
#define CELLWALK_TOOL_TERRAIN_VIEW_H

#include "product.h"
#include "scene.h"
#include "sight.h"

typedef struct view {
    /* Options. */
    const char *from, *to, *sun, *time;
    double fov;       /* degrees; 0: not given */
    double haze;      /* visibility in metres; 0: not given */
    double water;     /* height in metres; NaN: not given */
    double curvature; /* factor */
    bool sky, smooth, quiet;
    size_t width, height; /* of the picture; 0: not given */
    /* By view_check: as numbers. */
    io_place eye, target;
    double sun_at[2], seconds;
    /* The work. */
    ground ground;        /* not lowered */
    raster_field lowered; /* by curvature: that rays meet */
    sight earth;          /* by how much it was: 0 without curvature */
    float *filled;        /* the file's samples without holes, where smooth normals require it */
    scene *scene;
} view;

/* Checks the options; false after a message. */
bool view_check(view *v);

/* Reads the raster and makes the scene. The view is to be closed in any case. */
bool view_open(view *v, const field_options *fields, const char *path, io_error *error);
void view_close(view *v);

#endif
