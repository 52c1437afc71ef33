/* SPDX-License-Identifier: Apache-2.0 */
/* What the oracle's walk (oracle.c) hands to its judge (judge.c). */
#ifndef CELLWALK_TESTS_ORACLE_WALK_H
#define CELLWALK_TESTS_ORACLE_WALK_H

#include "bounds.h"
#include "exact.h"
#include "oracle.h"

/* A plane in double: height h at (i, j), a along x, b along y. */
typedef struct plane {
    double h, a, b;
    double high; /* largest sample, in size */
} plane;

/* The ray between two crossings: over one triangle, or along an edge between two, or still on a vertex of six. */
typedef struct segment {
    crossing from, to;
    unsigned count;              /* triangles of the field that it is over, holes or not */
    unsigned whole;              /* triangles that it would be over if the field had no end */
    unsigned solid;              /* of count; the first is the one that the sides are those of */
    oracle_triangle triangle[6]; /* solid ones first */
    int side_from, side_to;      /* sign of d */
} segment;

/* Bounds over the 3 × 3 cells around each cell. */
typedef struct cell_bounds {
    double low, high; /* samples */
    double slope;     /* largest difference along an edge, in size */
    bool all_solid;   /* no hole and no border of the field within reach */
} cell_bounds;

struct oracle {
    const float *z;
    size_t nx, ny;
    bool holes;
    double low, top; /* over samples */
    cell_bounds *cell;
    cell_bounds all;
    exact numbers;

    cw_ray ray; /* with the header's conventions applied */
    double ox, oy, oz, dx, dy, dz;
    bounds_ray bounds;
    segment *segment;
    size_t segments;
    oracle_truth truth;
};

bool oracle_solid(const oracle *o, int32_t i, int32_t j, uint32_t triangle);
plane oracle_plane(const oracle *o, const oracle_triangle *t);

/* d(t) above a triangle's plane, in double. */
double oracle_height(const oracle *o, const oracle_triangle *t, double at);

/* judge.c: looks for the clear pass among the segments. */
void oracle_find_pass(oracle *o);

/* rational.c, in rational numbers: is the present ray at a hit's t within height of the triangle's plane and within place of
 * the triangle, measured along x or y or as x - y? */
bool oracle_exactly_within(const oracle *o, const oracle_triangle *t, double at, double height, double place);

#endif
