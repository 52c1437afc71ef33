/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds of papers/numerics.md on what rounding does to a watertight hit, in double and under the names used there:
 * every judge of an answer takes them from here. Doubles are off by 2^-27 of the bounds or less, but for a ray from so
 * far away that its own place is: bounds_evaluation says by how much. */
#ifndef CELLWALK_ORACLE_BOUNDS_H
#define CELLWALK_ORACLE_BOUNDS_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* u: the relative rounding error of a float operation, and what the products of several such errors add. */
static inline double bounds_u(void) { return 0x1p-24 * (1 + 0x1p-19); }

/* What the bounds depend on. Components of the direction that count as zero are zero. */
typedef struct bounds_ray {
    double org[3], dir[3]; /* as given */
    double from[3];        /* where the library traces it from: org, or near the field's box if that is far away, */
    double spare[3];       /* up to so much before it */
    double start, early;   /* t of a moved ray there, and up to so much before it */
    bool moved;
} bounds_ray;

/* The lowest and highest sample and the largest difference along an edge, border or diagonal, in size: among the cell
 * and its eight neighbours, and of the whole field where delta >= 1/2. */
typedef struct bounds_surface {
    double low, high, S;
} bounds_surface;

/* The rule of include/cellwalk.h on which rays are moved, in the floats that it is decided in. */
static inline bool bounds_is_far(const double org[3], size_t nx, size_t ny, double low, double high) {
    const float range = (float)high - (float)low, middle_x = 0.5f * (float)(nx - 1), middle_y = 0.5f * (float)(ny - 1);
    const float middle_z = 0.5f * ((float)low + (float)high);
    return fabsf((float)org[0] - middle_x) > (float)(nx - 1) || fabsf((float)org[1] - middle_y) > (float)(ny - 1) ||
           (range > 0 && fabsf((float)org[2] - middle_z) > 8 * range);
}

/* low and high are the field's. A moved ray starts where it enters the field's box, or before that by 3.1 · 2^-22 of
 * the distance or by 1.5 · 2^-5 of its way through the box, but no farther outside than rays are that are not moved. */
static inline bounds_ray bounds_ray_of(const double org[3], const double dir[3], size_t nx, size_t ny, double low,
                                       double high) {
    bounds_ray r = {.moved = low <= high && bounds_is_far(org, nx, ny, low, high)};
    const double box_low[3] = {0, 0, low}, box_high[3] = {(double)(nx - 1), (double)(ny - 1), high};
    const double most[3] = {0.5 * box_high[0], 0.5 * box_high[1], high > low ? 8 * (high - low) : (double)INFINITY};
    double in = -(double)INFINITY, out = (double)INFINITY;
    for (int c = 0; c < 3; c++) {
        r.org[c] = r.from[c] = org[c];
        r.dir[c] = dir[c];
        if (dir[c] == 0) continue;
        const double a = (box_low[c] - org[c]) / dir[c], b = (box_high[c] - org[c]) / dir[c];
        in = fmax(in, fmin(a, b));
        out = fmin(out, fmax(a, b));
    }
    for (int c = 0; c < 3 && r.moved; c++) {
        r.from[c] = fmin(box_high[c], fmax(box_low[c], org[c] + in * dir[c]));
        r.start = in;
        r.early = fmax(3.1 * 0x1p-22 * (fabs(in) + (double)FLT_MIN), 1.5 * 0x1p-5 * fmax(0, out - in));
        r.spare[c] = fmin(dir[c] == 0 ? 0 : r.early * fabs(dir[c]), most[c]);
    }
    return r;
}

/* D: |x - i| + |y - j| does not exceed it for the place that the ray is traced from, and neither does |t dx| + |t dy|
 * from there while the ray is over cell (i, j). */
static inline double bounds_D(const bounds_ray *r, double i, double j) {
    return fabs(r->from[0] - i) + r->spare[0] + fabs(r->from[1] - j) + r->spare[1] + 2;
}

/* delta0: how far to the side a moved ray is off by rounding its new origin, along x and y together: as x - y it is. */
static inline double bounds_delta0(const bounds_ray *r) {
    return r->moved ? bounds_u() * (fabs(r->from[0]) + r->spare[0] + fabs(r->from[1]) + r->spare[1]) : 0;
}

/* delta: how far the exact ray is beside the triangle of a hit, at all t that the leaf test takes it to be over it. */
static inline double bounds_delta(const bounds_ray *r, double D) {
    return 4 * bounds_u() * D + bounds_delta0(r) + 0x1p-148 * (fabs(r->dir[0]) + fabs(r->dir[1]));
}

static inline double bounds_Z(const bounds_ray *r, bounds_surface s) {
    return fmax(fabs(s.low - r->from[2]), fabs(s.high - r->from[2])) + r->spare[2];
}

/* E: beyond this the computed d has the exact d's sign, on the triangle that the leaf test assigns to the place. */
static inline double bounds_E(const bounds_ray *r, double D, bounds_surface s) {
    const double u = bounds_u();
    const double moved =
        r->moved ? bounds_delta0(r) * s.S + u * (fabs(r->from[2]) + r->spare[2] + bounds_Z(r, s) + s.S * D) : 0;
    const double denormal = 0x1p-146 * (1 + fabs(r->dir[2]) + s.S * (fabs(r->dir[0]) + fabs(r->dir[1])));
    return u * (4 * bounds_Z(r, s) + 7.5 * s.S * D) + moved + denormal;
}

/* E + 2 S delta. Beyond this a computed d has the sign of d(t), on whichever of the triangles within delta it is
 * computed: two planes that meet within delta of the place differ there by 2 S delta at most. */
static inline double bounds_clear(const bounds_ray *r, double D, bounds_surface s) {
    return bounds_E(r, D, s) + 2 * s.S * bounds_delta(r, D);
}

/* By how much an end of the range at t is off, once it is counted from where a moved ray is traced from. */
static inline double bounds_end(const bounds_ray *r, double t) {
    return r->moved ? bounds_u() * (fabs(t - r->start) + r->early) : 0;
}

/* By how much the one rounding of t moves a hit along the ray: to the side, and in height over a plane over which the
 * ray's height changes by slope a unit of t. */
static inline double bounds_place_of_t(const bounds_ray *r, double t) {
    return bounds_u() * fabs(t) * (fabs(r->dir[0]) + fabs(r->dir[1]));
}
static inline double bounds_height_of_t(double t, double slope) { return bounds_u() * fabs(t * slope); }

/* By how much a place, and a height above the surface, computed from org and t in double may be off. */
static inline double bounds_place_evaluation(const bounds_ray *r, double t) {
    return 0x1p-51 * (fabs(r->org[0]) + fabs(r->org[1]) + fabs(t * r->dir[0]) + fabs(t * r->dir[1]));
}
static inline double bounds_height_evaluation(const bounds_ray *r, double t, bounds_surface s) {
    const double sample = fmax(fabs(s.low), fabs(s.high));
    return 0x1p-51 * (fabs(r->org[2]) + fabs(t * r->dir[2]) + sample) + 2 * s.S * bounds_place_evaluation(r, t);
}

#endif
