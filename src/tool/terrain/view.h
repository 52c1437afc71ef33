/* SPDX-License-Identifier: Apache-2.0 */
/* A picture of a terrain: the scene that `cellwalk render` makes of a raster. */
#ifndef CELLWALK_TOOL_TERRAIN_VIEW_H
#define CELLWALK_TOOL_TERRAIN_VIEW_H

#include "product.h"
#include "scene.h"

typedef struct view_options {
    const char *dem; /* NULL: the operand, if it is no scene */
    const char *from, *to, *sun, *time;
    double fov;       /* degrees; 0: not given */
    double haze;      /* visibility in metres; 0: not given */
    double water;     /* height in metres; NaN: not given */
    double curvature; /* factor; NaN: not given */
    bool sky;
    raster_options raster;
} view_options;

enum { VIEW_OPTION_COUNT = 10 + RASTER_OPTION_COUNT };
void view_rows(view_options *v, option_spec rows[VIEW_OPTION_COUNT]);

/* The name of an option that was given and that a scene has no use for, or NULL. */
const char *view_only(const view_options *v);

typedef struct view view;

/* Reads the raster and makes the scene. width and height are the picture's, or 0; smooth: for Phong normals. NULL after a
 * message, with *status the exit status. */
view *view_open(view_options *options, const char *path, const cw_run *query, size_t width, size_t height, bool smooth,
                bool quiet, int *status);
scene *view_scene(const view *v);
void view_close(view *v);

#endif
