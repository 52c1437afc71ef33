/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test. Follow the ray through the cell and compare its height with the surface's wherever it
 * crosses an edge: the cell's border, the diagonal, the border again. Between two crossings the ray is above one
 * triangle, both heights are linear, and the ray meets the triangle if and only if it is not strictly on one side at
 * both.
 *
 * Invariant: what is computed at an edge depends on the ray, the edge and its two samples alone, so the two triangles
 * that share an edge see the same sign there, whichever cell, walk or packet asks. A ray that is above at one crossing
 * and below at a later one has a pair of neighbouring crossings with a change between, hence a hit: it cannot slip
 * through. (Möller-Trumbore decides each triangle by itself, and near an edge both may say no.) The surface height on an
 * edge is clamped between the edge's samples, so the gate's comparison with the cell's lowest and highest sample
 * (strict.h) never contradicts it. A hole makes the height NaN and every comparison false: no hit.
 *
 * Rejected: Woop, Benthin and Wald 2013 (watertight edge functions), which needs a shear per ray, three edge functions
 * per triangle and a double-precision fallback where one is zero; papers/watertight.md has the comparison. */
#ifndef CELLWALK_SCALAR_WATERTIGHT_H
#define CELLWALK_SCALAR_WATERTIGHT_H

#include "moller_trumbore.h"
#include "strict.h"

/* Surface height at fraction f of the way from sample a to sample b, between the two; NaN if either is. */
static inline float wt_edge(float a, float b, float f) {
    const float z = a + f * (b - a);
    return max_second(min_second(a, b), min_second(max_second(a, b), z));
}

/* The place of the ray at t within the cell, each coordinate in [0, 1]. */
static inline float wt_within(const strict_axis *a, float t, float low) {
    const float x = (a->org + t * a->dir) - low;
    return max_second(0, min_second(1, x));
}

/* Above (positive), on (0) or below the surface where the ray is at t on the border that it enters or leaves by. */
static inline float wt_border(const strict_ray *r, const strict_cell *c, float t, bool x_border, bool high_side) {
    float a, b, f;
    if (x_border) {
        f = wt_within(&r->y, t, (float)c->j);
        a = high_side ? c->h10 : c->h00;
        b = high_side ? c->h11 : c->h01;
    } else {
        f = wt_within(&r->x, t, (float)c->i);
        a = high_side ? c->h01 : c->h00;
        b = high_side ? c->h11 : c->h10;
    }
    return strict_height(r, t) - wt_edge(a, b, f);
}

/* The same at a t inside the cell, where the ray's range starts or ends: on triangle B's plane or A's, as it falls. */
static inline float wt_inside(const strict_ray *r, const strict_cell *c, float t, bool *in_b) {
    const float x = wt_within(&r->x, t, (float)c->i), y = wt_within(&r->y, t, (float)c->j);
    *in_b = y > x;
    /* Along the longer leg first, then across: both are edges of the triangle that the place falls into. */
    const float corner = *in_b ? c->h01 : c->h10;
    const float longer = max_second(x, y), shorter = min_second(x, y);
    const float z = (c->h00 + longer * (corner - c->h00)) + shorter * (c->h11 - corner);
    const float low = min_second(c->h00, min_second(corner, c->h11));
    const float high = max_second(c->h00, max_second(corner, c->h11));
    return strict_height(r, t) - max_second(low, min_second(high, z));
}

/* t in [ta, tb] where the difference of heights, da at ta and db at tb, vanishes; call it only if the two are not
 * strictly on one side. */
static inline float wt_root(float ta, float da, float tb, float db) {
    const float s = da == 0 ? 0 : da / (da - db);
    return min_second(tb, ta + (tb - ta) * s);
}

static inline bool wt_between(float da, float db) { return (da >= 0 && db <= 0) || (da <= 0 && db >= 0); }

static inline bool wt_cell(const strict_ray *r, const strict_cell *c, cw_hit *hit) {
    const bool up_x = r->x.step > 0, up_y = r->y.step > 0;
    /* By which border: the staircase goes through the x border where both are crossed at once, so a cell entered at
     * such a corner is entered in y. Triangle B lies at the low x and the high y border. */
    const bool enter_x = c->x_in > c->y_in, leave_x = c->x_out <= c->y_out;
    bool in_b = enter_x ? up_x : !up_y, out_b = leave_x ? !up_x : up_y;
    const float in = max_second(c->x_in, c->y_in), out = min_second(c->x_out, c->y_out);
    const float da =
        in >= r->begin ? wt_border(r, c, c->t0, enter_x, enter_x ? !up_x : !up_y) : wt_inside(r, c, c->t0, &in_b);
    const float db =
        out <= r->end ? wt_border(r, c, c->t1, leave_x, leave_x ? up_x : up_y) : wt_inside(r, c, c->t1, &out_b);
    float ta = c->t0, tb = c->t1, d0 = da, d1 = db;
    bool b = in_b;
    bool found;
    if (in_b == out_b) {
        found = wt_between(da, db);
    } else {
        /* The diagonal x - i = y - j. A ray along it takes any t: the first comparison yields t1 for NaN. A quotient, as
         * the reciprocal of a difference of small directions need not be a float. */
        const float k = (float)c->i - (float)c->j;
        float td = (k - (r->x.org - r->y.org)) / (r->x.dir - r->y.dir);
        td = max_second(c->t0, min_second(td, c->t1));
        const float dd = strict_height(r, td) - wt_edge(c->h00, c->h11, wt_within(&r->x, td, (float)c->i));
        found = wt_between(da, dd);
        if (found) {
            tb = td;
            d1 = dd;
        } else {
            found = wt_between(dd, db);
            ta = td;
            d0 = dd;
            b = out_b;
        }
    }
    if (!found) return false;
    const float t = wt_root(ta, d0, tb, d1);
    const float x = wt_within(&r->x, t, (float)c->i), y = wt_within(&r->y, t, (float)c->j);
    const float along = b ? y - x : x - y; /* rounding may put the place a little across the diagonal */
    *hit = (cw_hit){
        .t = t,
        .u = b ? x : max_second(0, along),
        .v = b ? max_second(0, along) : y,
        .i = (int32_t)c->i,
        .j = (int32_t)c->j,
        .triangle = b ? CW_TRIANGLE_B : CW_TRIANGLE_A,
    };
    return true;
}

#endif
