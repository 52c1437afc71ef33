/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray met a shape, and how the surface lies there. */
#ifndef CELLWALK_SCENE_SURFACE_H
#define CELLWALK_SCENE_SURFACE_H

#include "model.h"

/* How far a ray and the rays of the neighbouring samples, to the right and below, are apart (Igehy 1999). */
typedef struct ray_spread {
    float org[2][3], dir[2][3];
} ray_spread;

typedef struct surface {
    const material *material;
    double point[3];
    double normal[3];  /* of the flat surface, unit length, on either side */
    double shading[3]; /* the Phong normal where that is wanted, else the same */
    double offset;     /* a ray that starts here leaves out [0, offset): SURFACE_OFFSET times the way to here */
} surface;

/* Rounding puts a point a little off its surface; a ray to or from it skips this part of the way it came. A triangle's
 * share is larger because a point within half a cell of the horizon may see neighbours at such distances. */
static const double surface_offset_field = 1e-3, surface_offset_cylinder = 5e-4;

/* t of a hit on the side of a cylinder with tmin <= t <= tmax, else infinity. */
double cylinder_hit(const cylinder *c, const double org[3], const double dir[3], double tmin, double tmax);

void surface_of_field(const heightfield *h, const cw_hit *hit, bool phong, surface *s);
void surface_of_cylinder(const cylinder *c, const double org[3], const double dir[3], double t, surface *s);

/* Changes of the point on the tangent plane from one sample to the next, to the right and below. */
void surface_spread(const surface *s, const double org[3], const double dir[3], const ray_spread *spread,
                    double change[2][3]);

/* Texture coordinates and their changes with the point. */
void surface_uv_of_field(const heightfield *h, const cw_hit *hit, const surface *s, double change[2][3],
                         double uv[2], double uv_change[2][2]);
void surface_uv_of_cylinder(const cylinder *c, const surface *s, double change[2][3], double uv[2],
                            double uv_change[2][2]);

/* Changes of the Phong normal with the point. */
void surface_normal_change(const heightfield *h, const cw_hit *hit, const surface *s, double change[2][3],
                           double normal_change[2][3]);

#endif
