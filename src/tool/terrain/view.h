/* SPDX-License-Identifier: Apache-2.0 */
/* A picture of a terrain: the scene that `cellwalk render` makes of a raster. */
#ifndef CELLWALK_TOOL_TERRAIN_VIEW_H
#define CELLWALK_TOOL_TERRAIN_VIEW_H

#include "product.h"
#include "scene.h"

typedef struct view_options {
    const char *from, *to, *sun, *time;
    double fov;       /* degrees; 0: not given */
    double haze;      /* visibility in metres; 0: not given */
    double water;     /* height in metres; NaN: not given */
    double curvature; /* factor */
    bool sky;
} view_options;

typedef struct view view;

/* Reads the raster and makes the scene. width and height are the picture's, or 0; smooth: for Phong normals. NULL after a
 * message, with *status the exit status. */
view *view_open(const view_options *options, const field_options *fields, const char *path, size_t width, size_t height,
                bool smooth, bool quiet, int *status);
scene *view_scene(const view *v);
void view_close(view *v);

#endif
