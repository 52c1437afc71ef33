/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds pyramid: lowest and highest sample of ever larger blocks of cells.
 *
 * A node of level 0 covers a *block* of 4 × 4 cells; a node of level l + 1 covers 4 × 4 nodes of level l, which lie
 * together in memory as one *brick*: 16 lows, then 16 highs, two cache lines. The top level is one brick. Any field shape
 * costs less than 1.5 bytes a cell plus the partly filled bricks along its far borders; nodes outside the field,
 * and those that hold nothing but holes, have NaN, which compares false: no ray meets them, not even one whose heights
 * overflow.
 *
 * After the maximum mipmaps of Tevs, Ihrke and Seidel (2008) and pbrt-like min-max quadtrees, but 16 children wide, so
 * that one vector comparison judges all children of a node at once. Level-0 bounds of single cells are not stored: they
 * follow from the samples that the leaf test loads anyway.
 *
 * For the lane walk each node has a *slab* as well: a plane fitted to its samples, and how far they lie below and above
 * it. Terrain is smooth at the scale of a block, so slabs are thinner than [low, high]: 0.4 times at a block, 0.5 at 16
 * cells, 0.9 at a whole field (fractal terrain, 1025²). */
#ifndef CELLWALK_CORE_PYRAMID_H
#define CELLWALK_CORE_PYRAMID_H

#include "field.h"

enum { PYRAMID_LEVELS_MAX = 12, BRICK_FLOATS = 32 };

/* How far rounding can put a ray, or what the watertight test makes of it, beside a slab: as a part of the numbers that
 * its height above the plane comes from. 32 u, of which papers/numerics.md accounts for 26. */
#define SLAB_ROUNDING 0x1p-19f

typedef struct cw_pyramid_level {
    float *bricks;  /* brick (x, y) at bricks + (y * across + x) * BRICK_FLOATS */
    int32_t across; /* bricks in a row */
    int32_t down;
    float side; /* cells along one side of a node */
    /* Highest sample of node (x, y) and its up to eight neighbours at around[y * 4 * across + x]: what a ray that starts
     * in the node cannot meet anything above of before it has gone a node's side. */
    float *around;
} cw_pyramid_level;

/* Every sample of the node, and every point of its triangles, has
 *     low <= z - slope_x * (x - x0) - slope_y * (y - y0) <= high
 * (x0, y0) being the node's middle. Both are set outward by what rounding does to a ray's height above the plane, as
 * papers/numerics.md derives, as long as the ray starts within the field or no farther from it than it is large. A node
 * without samples has low > high. */
typedef struct cw_pyramid_slab {
    float low, high, slope_x, slope_y;
} cw_pyramid_slab;

struct cw_pyramid {
    int levels; /* >= 1 */
    /* Node (x, y) of level l at slab[first[l + 1] + y * n + x], with n the nodes in a row, (nx - 2) / side + 1. */
    cw_pyramid_slab *slab;
    int32_t first[16];
    float steepest; /* the largest slope of any slab, and of any triangle in it, in heights a cell */
    float high;     /* the field's highest sample */
    cw_pyramid_level level[PYRAMID_LEVELS_MAX];
    void *memory;
    size_t bytes;
};

/* Lowest of node (x, y) of a level; its highest is 16 floats further on. */
static inline float *cw_pyramid_node(const cw_pyramid_level *l, size_t x, size_t y) {
    return l->bricks + ((y / 4) * (size_t)l->across + x / 4) * BRICK_FLOATS + (y % 4) * 4 + x % 4;
}

/* a < b ? a : b with a the sample: a hole compares false and drops out; compilers turn it into one instruction. */
static inline float lower(float a, float b) { return a < b ? a : b; }
static inline float higher(float a, float b) { return a > b ? a : b; }

/* src/core/slabs.c: fills p->slab and p->steepest, the rest being there. columns: 4 nx floats to work with. */
void cw_pyramid_build_slabs(struct cw_pyramid *p, const cw_field *f, float *columns);

#endif
