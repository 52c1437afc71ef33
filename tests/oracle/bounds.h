/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds of papers/numerics.md on what rounding does to a watertight hit, in double and under the names used there: whoever
 * judges an answer takes them from here. Doubles are off by 2^-27 of the bounds or less. */
#ifndef CELLWALK_ORACLE_BOUNDS_H
#define CELLWALK_ORACLE_BOUNDS_H

#include <math.h>

/* What the bounds depend on. Components of the direction that count as zero are zero. */
typedef struct bounds_ray {
    double ox, oy, oz, dx, dy, dz;
} bounds_ray;

/* The largest sample and the largest difference along an edge, border or diagonal, in size: among the cell and its eight
 * neighbours, and of the whole field where delta >= 1/2. */
typedef struct bounds_surface {
    double H, S;
} bounds_surface;

/* u: the relative rounding error of a float operation, and what the products of several such errors add. */
static inline double bounds_u(void) { return 0x1p-24 * (1 + 0x1p-19); }

/* P: |ox| + |oy| does not exceed it, and neither does |t dx| + |t dy| while the ray is over cell (i, j). */
static inline double bounds_P(const bounds_ray *r, double i, double j) { return fabs(r->ox) + fabs(r->oy) + i + j + 2; }

/* delta: how far the exact ray, at a hit's t, is beside the hit's triangle. */
static inline double bounds_delta(const bounds_ray *r, double P) {
    return 4 * bounds_u() * P + 0x1p-148 * (fabs(r->dx) + fabs(r->dy));
}

/* E at a crossing; a hit adds bounds_interpolation. */
static inline double bounds_E(const bounds_ray *r, double t, double P, bounds_surface s) {
    const double size = fabs(r->oz) + fabs(t * r->dz) + 4 * s.H + 9 * s.S * P;
    return bounds_u() * size + 0x1p-146 * (1 + fabs(r->dz) + s.S * (fabs(r->dx) + fabs(r->dy)));
}

/* E + 2 S delta. Beyond this a computed d has the sign of d(t), on whichever of the triangles within delta it is computed: two
 * planes that meet within delta of the place differ there by 2 S delta at most. */
static inline double bounds_clear(const bounds_ray *r, double t, double P, bounds_surface s) {
    return bounds_E(r, t, P, s) + 2 * s.S * bounds_delta(r, P);
}

/* A: the most that d can be where the slab of strict.h cuts the range off. H is the whole field's. */
static inline double bounds_A(const bounds_ray *r, double H) { return fabs(r->oz) + 5 * H; }

/* T: the longest range of t that the ray may spend in a cell; range is tmax - tmin. */
static inline double bounds_T(const bounds_ray *r, double P, double A, double range) {
    const double rounded = 1 + 6 * bounds_u() * P;
    return fmin(fmin(rounded / fabs(r->dx), rounded / fabs(r->dy)), fmin(range, 2 * A / fabs(r->dz)));
}

/* What interpolation between d at two crossings adds to E. */
static inline double bounds_interpolation(const bounds_ray *r, double T, double A, double S) {
    const double change = (fabs(r->dz) + S * (fabs(r->dx) + fabs(r->dy))) * T;
    return bounds_u() * fmin(7 * A, 5 * change);
}

#endif
