/* SPDX-License-Identifier: Apache-2.0 */
/* A scene in memory, as the parser leaves it and the renderer reads it. */
#ifndef CELLWALK_SCENE_MODEL_H
#define CELLWALK_SCENE_MODEL_H

#include "scene.h"
#include "texture.h"
#include "transform.h"

typedef enum material_kind { MATTE, MIRROR } material_kind;

/* colour is Kd of a matte material (Lambert's law) and Kr of a mirror; a texture stands in its place. */
typedef struct material {
    material_kind kind;
    float colour[3];
    texture *image; /* NULL: colour */
} material;

typedef struct heightfield {
    cw_field *field; /* maps field space to the world; borrows samples */
    const float *samples;
    size_t nx, ny;
    bool borrowed;      /* field and samples are not the scene's */
    transform to_world; /* from object space, where the samples' x and y span [0, 1] and are u and v */
    material surface;
} heightfield;

/* Radius 1, z from -1 to 1, open ends. */
typedef struct cylinder {
    transform to_world; /* can be inverted */
    material surface;
} cylinder;

typedef struct point_light {
    double position[3];
    float intensity[3];
} point_light;

/* The background, where no shape is seen. Only scenes without mirrors and cylinders have one. */
typedef struct sky {
    float up[3];                /* the world's up in the camera's space */
    float horizon[3], above[3]; /* colours at the horizon and below, and straight above */
    /* A vault is brighter toward the sun, and below the horizon there is a plain in haze. */
    bool vault;
    float sun[3];     /* a unit vector toward it in the camera's space; not of length one: no sun */
    float plain[3];   /* its colour */
    float eye_height; /* of the camera over the plain */
    float plain_haze; /* as haze of the scene, for the plain */
} sky;

/* Level water that stands over the first height field wherever that is lower. It mirrors sky and land. */
typedef struct water {
    float level;     /* a height in field space */
    float colour[3]; /* light that comes out of it, where nothing is mirrored */
} water;

struct scene {
    size_t width, height;
    unsigned samples;          /* a pixel */
    double field_of_view;      /* degrees, over the shorter side */
    transform camera_to_world; /* the camera looks along +z, +y is up, +x right */

    heightfield *heightfields;
    cylinder *cylinders;
    point_light *lights;
    size_t heightfield_count, cylinder_count, light_count;
    sky *sky;     /* NULL: black */
    water *water; /* NULL: none; only with a sky */
    /* Light is halved on a way of 1 / haze, and the horizon's colour takes the place of the rest; 0: clear air. Only
     * with a sky. */
    float haze;

    /* Pointers, because materials point to them. */
    texture **textures;
    size_t texture_count;
};

/* Fills s, which is all zero, from a .pbrt file and all that it includes. On failure s may hold parts,
 * which are the caller's to free. */
bool pbrt_parse(const char *path, scene *s, scene_warn_fn *warn, void *warn_context, io_error *error);

#endif
