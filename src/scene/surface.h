/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray met a shape, and how the surface lies there. */
#ifndef CELLWALK_SCENE_SURFACE_H
#define CELLWALK_SCENE_SURFACE_H

#include "model.h"

typedef struct surface {
    double point[3];
    double offset;    /* a ray that starts here leaves out [0, offset): surface_offset times the way to here */
    float normal[3];  /* of the flat surface, unit length, on either side */
    float shading[3]; /* the Phong normal where that is wanted, else the same */
    float object[3];  /* the point in a cylinder's own space */
} surface;

/* Rounding puts a point a little off its surface; a ray to or from it skips this part of the way it came. A triangle's
 * share is larger because a point within half a cell of the horizon may see neighbours at such distances. */
static const double surface_offset_field = 1e-3, surface_offset_cylinder = 5e-4;

/* t of a hit on the side of a cylinder with tmin <= t <= tmax, else infinity. */
double cylinder_hit(const cylinder *c, const cw_user_ray *ray);

/* Whether the ray meets the cylinder's side at all. */
bool cylinder_blocks(const cylinder *c, const cw_user_ray *ray);

/* turn is NULL, or takes the changes of the shading normal along the texture coordinates. */
void surface_of_field(const heightfield *h, const cw_hit *hit, bool phong, surface *s, float turn[2][3]);
void surface_of_cylinder(const cylinder *c, const cw_user_ray *ray, double t, surface *s);

/* Texture coordinates. */
void surface_uv_of_field(const heightfield *h, const cw_hit *hit, float uv[2]);
void surface_uv_of_cylinder(const surface *s, float uv[2]);

/* Changes of the texture coordinates where the point changes by change. */
void surface_uv_change_on_field(const heightfield *h, float change[2][3], float uv_change[2][2]);
void surface_uv_change_on_cylinder(const cylinder *c, const surface *s, float change[2][3], float uv_change[2][2]);

#endif
