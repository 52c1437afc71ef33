/* SPDX-License-Identifier: Apache-2.0 */
/* Turns the find of a leaf test into a hit, in double.
 *
 * Leaf tests decide in float which triangle a ray meets, and on which stretch of t. The hit is the root of the ray's
 * height above the triangle's plane, solved for here in coordinates relative to the cell and clamped to the stretch.
 * So the decision does not change, nor do watertightness and the order of hits along the ray, and t, u and v are as
 * precise as floats allow, at any distance.
 *
 * Rejected: interpolating t between the stretch's ends, whose heights are known. It is free, but near a ray's origin
 * its t is a thousand times less precise (papers/walks.md). */
#ifndef CELLWALK_SCALAR_REFINE_H
#define CELLWALK_SCALAR_REFINE_H

#include "ray.h"
#include "strict.h"

/* A place along one axis of a cell, within it. */
static inline float refine_within(float x) { return min_second(1, max_second(x, 0)); }

/* Of a find in cell (i, j). No branch depends on the triangle, since no CPU can foretell it. */
static inline cw_hit refine_hit(const cw_field *f, const ray_start *r, size_t i, size_t j, const strict_find *found) {
    /* The triangle's legs: along x in row j in A and j + 1 in B, along y in column i + 1 in A and i in B. */
    const size_t b = found->b, a = 1 - b;
    const float *z = f->z + j * f->stride + i, *leg_x = z + b * f->stride, *leg_y = z + a;
    const double slope_x = (double)leg_x[1] - (double)leg_x[0], slope_y = (double)leg_y[f->stride] - (double)leg_y[0];
    const double x = r->base[0] - (double)i, y = r->base[1] - (double)j;
    const double dx = (double)r->dir[0], dy = (double)r->dir[1];
    const double below = (slope_x * x + slope_y * y) - (r->base[2] - (double)z[0]);
    const double rise = (double)r->dir[2] - (slope_x * dx + slope_y * dy);
    /* NaN, where the ray lies in the plane, becomes the stretch's beginning. */
    const double t = min_second_d(max_second_d(below / rise, (double)found->t0), (double)found->t1);
    /* Never -0, since walks that mirror a ray do not distinguish it from 0. A has no place with y > x, B none with
     * x > y. */
    const float at_x = refine_within((float)(x + t * dx)), at_y = refine_within((float)(y + t * dy));
    const float least_x = (float)a * at_y, least_y = (float)b * at_x;
    return (cw_hit){
        .t = ray_t(r, t),
        .u = max_second(at_x, least_x) - least_x,
        .v = max_second(at_y, least_y) - least_y,
        .i = (int32_t)i,
        .j = (int32_t)j,
        .triangle = (uint32_t)(b ? CW_TRIANGLE_B : CW_TRIANGLE_A),
    };
}

/* The same for a Möller-Trumbore hit. Its t, counted from r's origin, does not change; u and v are those of the
 * place at t. */
static inline cw_hit refine_place(const cw_field *f, const ray_start *r, const cw_hit *hit) {
    const strict_find found = {hit->t, hit->t, hit->triangle == CW_TRIANGLE_B};
    return refine_hit(f, r, (size_t)hit->i, (size_t)hit->j, &found);
}

#endif
