/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that are aimed at places that rounding can miss, and that pass through the surface by construction: they are
 * clearly above all samples and later clearly below all of them while over the field, or the reverse; those that start
 * near, above and below the surface right there. Those that graze a triangle cross it well inside, by more than the
 * bound on a computed height where they can. Rounding may spoil a ray: the exact oracle says whether it is clear at
 * both ends. Sines and powers are libm's, so another libm makes other rays. */
#ifndef CELLWALK_TESTS_STABILITY_AIMED_H
#define CELLWALK_TESTS_STABILITY_AIMED_H

#include "cellwalk.h"
#include "workload/random.h"

typedef enum aim {
    AIM_INSIDE,   /* at a place inside a triangle: the others' control */
    AIM_VERTEX,   /* at a sample */
    AIM_EDGE,     /* at a place on a border edge */
    AIM_DIAGONAL, /* at a place on a diagonal */
    AIM_BORDERS,  /* along a grid line, exactly above or on its edges and samples */
    AIM_AXIS,     /* along x or y between two grid lines */
    AIM_CORNERS,  /* over samples in whole steps, where x and y borders and diagonals are crossed at once */
    AIM_VERTICAL, /* straight up or down, at a sample, an edge, a diagonal or inside */
    AIM_STEEP,    /* all but vertical, down to directions so small that they count as zero */
    AIM_LONG,     /* across the whole field, hardly above its highest sample to hardly below its lowest */
    AIM_GRAZING,  /* at 1 to 1e-6 degrees to a triangle */
    AIM_COUNT
} aim;

/* Where a ray starts. */
typedef enum aim_start {
    START_OVER,   /* over the field */
    START_AFAR,   /* from twice the field's longer side to 10^7 times that before the place; vertical rays to 10^12
                   times, or of ten times the field's range of heights if that is less. Floats cannot aim well from
                   there: but for those in whole steps, most rays pass by the place, and hit elsewhere */
    START_NEAR,   /* at most two cells before the place along x and along y */
    START_BEHIND, /* over the field, at exactly the height of its lowest or highest sample, with a range that begins
                     far behind, at a power of 2 or at minus infinity */
    START_COUNT
} aim_start;

/* "inside", "vertex" … */
const char *aim_name(aim kind);

typedef struct aimed_field {
    const cw_field *field;
    size_t nx, ny;
    double low, high;
    /* Rays begin and end where they have just become clear of all samples; else many go on, far above or below. */
    bool bounded;
} aimed_field;

/* Of a field in cells, at least 4 samples a side and without holes, which must stay. */
aimed_field aimed_field_of(const cw_field *field);

typedef struct aimed_ray {
    cw_ray ray;
    double from, to; /* at t = from the ray is on one side of the surface, at t = to, within its range, on the other: */
    int side;        /* at from it is above if 1, below if -1 */
    cw_hit over[2];  /* above or below the plane of this triangle, at from and to; or, if i is negative, all samples */
} aimed_ray;

aimed_ray aimed_ray_make(aim kind, aim_start start, const aimed_field *f, random_state *r);

#endif
