/* SPDX-License-Identifier: Apache-2.0 */
/* What the oracle's walk (oracle.c) hands to its judge (judge.c). */
#ifndef CELLWALK_TESTS_ORACLE_WALK_H
#define CELLWALK_TESTS_ORACLE_WALK_H

#include "bounds.h"
#include "oracle.h"

#include <gmp.h>

/* What a crossing is with: x = number, y = number, x - y = number, or t = constant. */
typedef enum crossing_kind { CROSSING_X, CROSSING_Y, CROSSING_DIAGONAL, CROSSING_CONSTANT } crossing_kind;

/* A t of interest. */
typedef struct crossing {
    crossing_kind kind;
    int32_t number;
    float constant;
    double t, error; /* |t - exact t| <= error */
} crossing;

/* A triangle's plane: height h at (i, j); rises a1 - a0 along x and b1 - b0 along y, which a and b are in double. */
typedef struct plane {
    double h, a1, a0, b1, b0, a, b;
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

/* Over the 3 × 3 cells around each cell. */
typedef struct cell_bounds {
    bounds_surface surface;
    bool all_solid; /* no hole and no border of the field within reach */
} cell_bounds;

enum { EXACT_NUMBERS = 9 };
struct oracle {
    const float *z;
    size_t nx, ny;
    bool holes;
    cell_bounds *cell;
    bounds_surface all;          /* over samples and edges */
    mpf_t number[EXACT_NUMBERS]; /* exact.c */

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

/* ---- exact.c: the present ray, with nothing rounded -------------------------------------------------------------- */

void exact_init(oracle *o);
void exact_clear(oracle *o);

/* Sign of a - b. */
int exact_order(oracle *o, const crossing *a, const crossing *b);

/* Sign of the ray's height above a triangle's plane at a crossing. */
int exact_side(oracle *o, const crossing *at, const oracle_triangle *t);

/* The t of a crossing, and that at which the ray meets a plane not parallel to it; off by less than 2^-50 relative. */
double exact_value(oracle *o, const crossing *at);
double exact_meet(oracle *o, const oracle_triangle *t);

/* Is x - y of the origin whole; *floor of it. */
bool exact_diagonal(oracle *o, int32_t *floor);

/* Is the ray at a hit's t within height of the triangle's plane and place of the triangle, along x or y or as x - y? */
bool exact_within(oracle *o, const oracle_triangle *t, double at, double height, double place);

#endif
