/* SPDX-License-Identifier: Apache-2.0 */
/* Fields and rays on which kernels could differ, for the rows of lanes.c. A field maker fills in the ground for its
 * number; ray makers write at most so many rays to it and return how many. */
#ifndef CELLWALK_TESTS_LANES_GROUNDS_H
#define CELLWALK_TESTS_LANES_GROUNDS_H

#include "rays.h"
#include "workload/ray_classes.h"

typedef struct ground {
    size_t number;        /* of the field within its row */
    workload_class class; /* of the row's rays, if they are the benchmark's */
    cw_field *field;
    test_field *shape; /* the samples of fields from fields.h */
    float *z;          /* all other samples: room for GROUND_SAMPLES */
    size_t nx, ny;
    size_t first;    /* towers beside nodes: columns before it are level, and rays do not go there */
    double slope[2]; /* planes: rise along each axis */
    double base;     /* their height at sample (0, 0) */
    double unit;     /* of a ray's distance from them */
    bool high; /* they are so far from zero and so level that a sample's rounding is more than their rise in a cell */
    bool up;   /* towers stand, or hang */
    uint32_t seed; /* of the benchmark's rays */
} ground;

enum { WIDE = (1 << 20) + 300, WIDE_ROWS = 13, GROUND_SAMPLES = WIDE * WIDE_ROWS };
enum { RUN_MAX = 4096, KNOWN = 5, KNOWN_RAYS = 51, CORNERS = 24, ALL_SHAPES = (FIELD_SIZES + 1) * FIELD_ALL_SHAPES };

/* A small whole number of either sign. */
static inline int few(random_state *r, int most) { return (int)random_below(r, 2 * (size_t)most + 1) - most; }

typedef cw_field *field_maker(ground *g, random_state *r);
typedef size_t ray_maker(const ground *g, cw_ray *rays, size_t most, random_state *r);

/* Every shape and size, and rays of the classes of rays.h: runs of any length, plain or in bundles of like rays. */
field_maker any_shape, large_shape, small_shape;
ray_maker random_rays, steep_rays, standing_rays, adversarial_rays, rays_in_turn;

/* Rays that simd/packet_kernel.c and src/scalar/cell.c guess to be short. Some of them are long. */
field_maker cliff;
ray_maker rays_over_cliff;

/* Rays on which kernels once differed: alone and among their like. */
field_maker known_field;
ray_maker known_rays;

/* Samples 2^20 to 2^60 times their neighbours. */
field_maker towers;
ray_maker rays_past_towers;

/* Planes of any slope and size, also of denormal heights or far from zero, plain, rippled, with fins across the rays'
 * way and with holes. Rays beside them, for hundreds of cells nearer than slabs can resolve. */
field_maker plane;
ray_maker rays_beside_plane;

/* Level ground with one sample that a ray touches in a cell which it only enters through a corner. */
field_maker corner_behind_hole;
ray_maker ray_through_corners;

/* Towers beside corners of nodes, and rays that climb from there. The wide field is so wide that floats at its end are
 * an eighth of a cell apart. */
field_maker towers_beside_nodes, wide_towers_beside_nodes;
ray_maker climbing_rays;

/* The benchmark's land and water, other each time or always the same, and a class of its rays. */
field_maker any_land, same_land, large_land;
ray_maker benchmark_rays;

#endif
