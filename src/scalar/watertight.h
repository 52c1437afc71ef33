/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test. It follows the ray through the cell and compares the ray's height with the surface's
 * wherever the ray crosses an edge: the cell's border, the diagonal, the border again. Between two crossings the ray
 * is over one triangle and both heights are linear. So the ray meets the triangle if and only if it is not strictly
 * on one side at both.
 *
 * Invariant: the sign at an edge depends on the ray, the edge and its two samples alone. So the two triangles that
 * share an edge get the same sign there, in every cell, walk and packet. A ray that is above at one crossing and
 * below at a later one has two neighbouring crossings between which the sign changes, hence a hit: it cannot slip
 * through. (Möller-Trumbore tests each triangle separately, and near an edge may reject both.) The surface height on
 * an edge is clamped between the edge's samples, so the gate's comparison with the cell's lowest and highest sample
 * (strict.h) never contradicts it. A hole makes the height NaN and every comparison false: no hit.
 *
 * We know of no paper with this test. Rejected: Woop, Benthin and Wald 2013 (watertight edge functions), which needs
 * a shear per ray, three edge functions per triangle and a double-precision fallback if one is zero.
 * papers/watertight.md compares the two. */
#ifndef CELLWALK_SCALAR_WATERTIGHT_H
#define CELLWALK_SCALAR_WATERTIGHT_H

#include "strict.h"

/* Surface height at fraction f of the way from sample a to sample b, between the two; NaN if either is. */
static inline float wt_edge(float a, float b, float f) {
    const float z = a + f * (b - a);
    return max_second(min_second(a, b), min_second(max_second(a, b), z));
}

/* A coordinate of the ray in the cell at t, clamped to [0, 1]; from is its origin's. */
static inline float wt_within(float from, float dir, float t) {
    const float x = from + t * dir;
    return max_second(0, min_second(1, x));
}

/* Common to the tests at a cell's edges: the ray's origin relative to the cell's sample (i, j), and the cell's samples.
 * All heights in this file are relative to the origin's. */
typedef struct wt_ray {
    float x, y, dx, dy, dz;
    float h00, h10, h01, h11;
} wt_ray;

/* The ray's height above the surface (positive: above) at t on the border by which it enters or leaves. */
static inline float wt_border(const wt_ray *r, float t, bool x_border, bool high_side) {
    float a, b, f;
    if (x_border) {
        f = wt_within(r->y, r->dy, t);
        a = high_side ? r->h10 : r->h00;
        b = high_side ? r->h11 : r->h01;
    } else {
        f = wt_within(r->x, r->dx, t);
        a = high_side ? r->h01 : r->h00;
        b = high_side ? r->h11 : r->h10;
    }
    return t * r->dz - wt_edge(a, b, f);
}

/* The same at a t inside the cell, where the ray's range starts or ends: above the plane of the triangle there. */
static inline float wt_inside(const wt_ray *r, float t, bool *in_b) {
    const float x = wt_within(r->x, r->dx, t), y = wt_within(r->y, r->dy, t);
    *in_b = y > x;
    /* Along the longer leg first, then across: both are edges of the triangle that the place falls into. */
    const float corner = *in_b ? r->h01 : r->h10;
    const float longer = max_second(x, y), shorter = min_second(x, y);
    const float z = (r->h00 + longer * (corner - r->h00)) + shorter * (r->h11 - corner);
    const float low = min_second(r->h00, min_second(corner, r->h11));
    const float high = max_second(r->h00, max_second(corner, r->h11));
    return t * r->dz - max_second(low, min_second(high, z));
}

static inline bool wt_between(float da, float db) { return (da >= 0 && db <= 0) || (da <= 0 && db >= 0); }

static inline bool wt_cell(const strict_ray *ray, const strict_cell *c, strict_find *find) {
    const float x = ray->x.org - (float)c->i, y = ray->y.org - (float)c->j, oz = ray->oz;
    const wt_ray r = {x, y, ray->x.dir, ray->y.dir, ray->dz, c->h00 - oz, c->h10 - oz, c->h01 - oz, c->h11 - oz};
    const bool up_x = ray->x.step > 0, up_y = ray->y.step > 0;
    /* By which border: the staircase goes through the x border where both are crossed at once, so a cell entered at
     * such a corner is entered in y. Triangle B lies at the low x and the high y border. */
    const bool enter_x = c->x_in > c->y_in, leave_x = c->x_out <= c->y_out;
    bool in_b = enter_x ? up_x : !up_y, out_b = leave_x ? !up_x : up_y;
    const float in = max_second(c->x_in, c->y_in), out = min_second(c->x_out, c->y_out);
    const float da =
        in >= ray->t0 ? wt_border(&r, c->t0, enter_x, enter_x ? !up_x : !up_y) : wt_inside(&r, c->t0, &in_b);
    const float db =
        out <= ray->t1 ? wt_border(&r, c->t1, leave_x, leave_x ? up_x : up_y) : wt_inside(&r, c->t1, &out_b);
    *find = (strict_find){c->t0, c->t1, in_b};
    if (in_b == out_b) return wt_between(da, db);
    /* The diagonal, where x = y in the cell. A ray along it takes any t: the first comparison yields t1 for NaN. A
     * quotient, as the reciprocal of a difference of small directions need not be a float. */
    const float td = max_second(c->t0, min_second((r.y - r.x) / (r.dx - r.dy), c->t1));
    const float dd = td * r.dz - wt_edge(r.h00, r.h11, wt_within(r.x, r.dx, td));
    if (wt_between(da, dd)) {
        find->t1 = td;
        return true;
    }
    *find = (strict_find){td, c->t1, out_b};
    return wt_between(dd, db);
}

#endif
