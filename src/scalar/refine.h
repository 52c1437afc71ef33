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

static inline cw_hit refine_hit(const ray_start *r, const strict_cell *c, const strict_find *found) {
    /* Along the triangle's legs: the longer coordinate of its points is that along x in A and along y in B. */
    const int l = found->b ? 1 : 0, s = 1 - l;
    const double org[2] = {r->base[0] - (double)c->i, r->base[1] - (double)c->j};
    const double corner = (double)(found->b ? c->h01 : c->h10);
    const double first = corner - (double)c->h00, second = (double)c->h11 - corner;
    const double dl = (double)r->dir[l], ds = (double)r->dir[s];
    const double below = (first * org[l] + second * org[s]) - (r->base[2] - (double)c->h00);
    const double rise = (double)r->dir[2] - (first * dl + second * ds);
    /* NaN, where the ray lies in the plane, becomes the stretch's beginning. */
    const double t = min_second_d(max_second_d(below / rise, (double)found->t0), (double)found->t1);
    const float longer = (float)(org[l] + t * dl), shorter = (float)(org[s] + t * ds);
    /* Never -0, since walks that mirror a ray do not distinguish it from 0. */
    const float across = max_second(min_second(1, shorter), 0), along = max_second(min_second(1, longer), across);
    return (cw_hit){
        .t = ray_t(r, t),
        .u = found->b ? across : along - across,
        .v = found->b ? along - across : across,
        .i = (int32_t)c->i,
        .j = (int32_t)c->j,
        .triangle = found->b ? CW_TRIANGLE_B : CW_TRIANGLE_A,
    };
}

/* The same for a Möller-Trumbore hit. Its t, counted from r's origin, does not change; u and v are those of the
 * place at t. */
static inline cw_hit refine_place(const cw_field *f, const ray_start *r, const cw_hit *hit) {
    const size_t i = (size_t)hit->i, j = (size_t)hit->j;
    const float *h = f->z + j * f->stride + i;
    const strict_cell c = {.i = i, .j = j, .h00 = h[0], .h10 = h[1], .h01 = h[f->stride], .h11 = h[f->stride + 1]};
    return refine_hit(r, &c, &(strict_find){hit->t, hit->t, hit->triangle == CW_TRIANGLE_B});
}

#endif
