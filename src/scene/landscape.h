/* SPDX-License-Identifier: Apache-2.0 */
/* A scene of one height field under sun and sky, made in memory instead of read from a file. */
#ifndef CELLWALK_SCENE_LANDSCAPE_H
#define CELLWALK_SCENE_LANDSCAPE_H

#include "scene.h"

typedef struct landscape_desc {
    /* Owned by the caller; both must live as long as the scene. Rays meet the field; normals are computed from the
     * samples. */
    cw_field *field;
    const float *samples;
    size_t nx, ny;
    double to_world[3][4]; /* from field space; can be inverted; up is the world's z */
    /* Of the ground, from field space's y = 0, the first row, to its end. Taken over if that succeeds. */
    io_image *colours;
    double eye[3], target[3];   /* in the world; not the same place */
    double field_of_view;       /* degrees, over the picture's shorter side */
    double sun[3], sun_light;   /* a unit vector toward it; brightness of a white surface across its rays, 0 to 1 */
    double sky_light;           /* brightness of a level white surface lit by the sky alone */
    float horizon[3], above[3]; /* colours of the sky, which is seen where no ground is */
    bool vault;                 /* a sky that is brighter toward the sun, and a plain below the horizon */
    float plain[3];             /* the plain's colour */
    double visibility;          /* > 0: haze leaves 2 % of the contrast at this distance in the world; 0: clear air */
    const double *water_level;  /* NULL, or the height of water in the samples' numbers */
    size_t width, height;
    unsigned samples_a_pixel;
} landscape_desc;

/* NULL on failure. */
scene *landscape_create(const landscape_desc *desc, io_error *error);

#endif
