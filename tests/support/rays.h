/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that are hard for a tracer: aimed at places that are exact in theory and rounded in practice. */
#ifndef CELLWALK_TESTS_RAYS_H
#define CELLWALK_TESTS_RAYS_H

#include "fields.h"

typedef enum ray_class {
    RAY_RANDOM,   /* through two points of the field's box */
    RAY_VERTEX,   /* from above or below through a sample */
    RAY_EDGE,     /* through a point on a border edge between two samples */
    RAY_DIAGONAL, /* through a point on a diagonal */
    RAY_ALONG,    /* within a vertical plane that holds borders or diagonals, some along the edge itself */
    RAY_AXIS,     /* parallel to x or y in the plane, at any height */
    RAY_VERTICAL, /* x and y stand still; on a vertex, on an edge or inside a cell */
    RAY_GRAZING,  /* at 1 to 1e-6 degrees to the triangle that it meets */
    RAY_IN_PLANE, /* within a triangle's plane, as far as floats allow */
    RAY_OUTSIDE,  /* from up to 1000 cells off */
    RAY_FAR,      /* from up to 10^8 cells off */
    RAY_AFAR,     /* from up to 10^7 cells off to the side, and 10^25 times the field's height above or below */
    RAY_NEAR,     /* starts within 2 cells of the surface, down to 10^-4 */
    RAY_TINY,     /* components of the direction 2^-10 to 2^-70 of others */
    RAY_ZEROS,    /* components 0, -0, denormal or as small as counts as zero */
    RAY_SCALED,   /* direction of length 1e-30 to 1e30, or of any length that a float can have */
    RAY_RANGE,    /* the t-range starts or ends on the surface, or within a cell, or is a point */
    RAY_BEHIND, /* from the exact height of the field's lowest or highest sample, with a range that begins far behind */
    RAY_MOVED,  /* from outside, by little more than where rays are moved; a range that begins or ends at the surface */
    RAY_LATTICE,    /* small integers, halves and quarters throughout, so that ties are exact */
    RAY_NOT_FINITE, /* NaN or infinity somewhere */
    RAY_CLASSES
} ray_class;

cw_ray ray_make(ray_class kind, const test_field *f, random_state *r);

/* The same ray for a field whose map is the identity. */
cw_user_ray ray_for_user(const cw_ray *ray);

/* To stdout, components as hexadecimal floats. */
void ray_print(const cw_ray *ray);
void hit_print(const char *who, const cw_hit *hit);

/* The same bits throughout. */
bool hit_same(const cw_hit *a, const cw_hit *b);

#endif
