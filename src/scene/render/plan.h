/* SPDX-License-Identifier: Apache-2.0 */
/* The steps that a scene requires of the renderer, found once before a rendering: its shapes' spaces, the maps between
 * them, and which features occur at all. Code that a scene does not require is not run.
 *
 * A space is where coordinates are small and exact: a height field's own, with unit cells, a cylinder's own, the
 * camera's. A ray begins in the space of its origin's shape, its home, and is moved from there to each shape that it
 * may meet by one affine map. Shading stays in the shape's space: the sign of a normal times a vector is the same in
 * all spaces, and lengths are measured by a metric, the product of the linear map to the world with its transpose. So
 * nothing depends on where in the world a scene lies, and floats do. */
#ifndef CELLWALK_SCENE_PLAN_H
#define CELLWALK_SCENE_PLAN_H

#include "model.h"

/* Homes of rays: the camera, then the shapes in their order. */
enum { PLAN_CAMERA = 0 };
static inline size_t plan_home(size_t shape) { return shape + 1; }

/* Rows of an affine map. */
typedef struct plan_map {
    float m[3][4];
} plan_map;

/* A symmetric matrix: xx, yy, zz, yz, xz, xy. */
typedef struct plan_metric {
    float g[6];
} plan_metric;

/* Height fields come first, then cylinders. */
typedef struct plan_shape {
    const heightfield *field; /* NULL: a cylinder */
    const material *surface;
    bool sends;            /* light can come from here: some light is there, or it is a mirror that is not black */
    float low[3], high[3]; /* a box around it */
    /* Of the world's lengths of vectors and of covectors such as normals, both in this space. */
    plan_metric metric, inverse;
    float offset;      /* a ray that starts here leaves out this share of the way to here */
    float uv_scale[2]; /* of a field: u and v are x and y times these */
    float step[2][3];  /* from one sample of the picture to the next, at depth 1 */
} plan_shape;

/* A space's way to the world and back. */
typedef struct plan_space {
    transform to_world;
    double back[3][3]; /* inverse of the linear part */
} plan_space;

typedef struct plan {
    const scene *scene;
    size_t width, height; /* of the picture */
    unsigned samples;     /* a pixel */
    uint32_t seed;
    bool smooth; /* Phong normals on height fields */

    size_t shape_count, field_count, light_count;
    plan_shape *shapes;
    plan_space *spaces; /* [home] */

    plan_metric camera_metric;
    double corner[2], pixel; /* the picture's upper left corner and a pixel's side, at depth 1 */

    /* The sky's vectors in the first field's space, for what water mirrors: times a direction there of length one in
     * the world, its sine over the horizon and its cosine to the sun. */
    float up[3], sun[3];

    bool mirrors; /* paths go on, and carry their share of the light */
    bool spreads; /* mirrored paths carry how far their neighbours are apart, for textures that they may meet */
    bool general; /* nothing is left out */
} plan;

/* False when out of memory. */
bool plan_make(plan *p, const scene *s, const scene_render_options *options);
void plan_free(plan *p);

/* Found for each wave anew: tables of them for n shapes would hold n² items. */
plan_map plan_map_to(const plan *p, size_t shape, size_t home);

/* A light's place in the space of a shape. */
void plan_light(const plan *p, size_t shape, size_t light, float place[3]);

/* Whether this cylinder may stand between the light and a home that is a shape. */
bool plan_blocks(const plan *p, size_t light, size_t home, size_t cylinder);

#endif
