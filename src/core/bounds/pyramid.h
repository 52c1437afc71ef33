/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds pyramid: lowest and highest sample of ever larger blocks of cells.
 *
 * A node of level 0 covers a *block* of 4 × 4 cells; a node of level l + 1 covers 4 × 4 nodes of level l, which lie
 * together in memory as one *brick*: 16 lows, then 16 highs, two cache lines. The top level is one brick. Large
 * squares take 1.5 bytes a cell, other fields more for the partly filled bricks along their far borders. Nodes outside
 * the field and nodes with holes only have NaN, which compares false: no ray meets them, not even one whose heights
 * overflow.
 *
 * After the maximum mipmaps of Tevs, Ihrke and Seidel (2008) and pbrt-like min-max quadtrees, but 16 children wide,
 * so that one vector comparison tests all children of a node at once. Bounds of single cells are not stored: they
 * follow from the samples that the leaf test loads anyway.
 *
 * For the lane walk each node also has a *slab*: a plane fitted to its samples, and their largest distances below
 * and above it. Terrain is smooth at the scale of a block, so slabs of small nodes are much thinner than [low, high]
 * (papers/walks.md). */
#ifndef CELLWALK_CORE_PYRAMID_H
#define CELLWALK_CORE_PYRAMID_H

#include "field.h"

#include <math.h>

/* Lowest and highest of samples of which some are holes. With a the sample, a hole compares false and drops out;
 * compilers turn it into one instruction. */
static inline float lower(float a, float b) { return a < b ? a : b; }
static inline float higher(float a, float b) { return a > b ? a : b; }
static inline size_t least(size_t a, size_t b) { return a < b ? a : b; }

enum { PYRAMID_LEVELS_MAX = 12, BRICK_FLOATS = 32 };

/* A *tile* is a node of this level, and its cells along one side. */
enum { TILE_LEVEL = 2, TILE_SIDE = 64 };

/* Bound on the rounding error of a ray's height above a slab's plane, including that of the watertight test, as a
 * part of the numbers that the height is computed from: 32 u, of which papers/numerics.md accounts for 29. */
#define SLAB_ROUNDING 0x1p-19f

typedef struct cw_pyramid_level {
    float *bricks;  /* brick (x, y) at bricks + (y * across + x) * BRICK_FLOATS */
    int32_t across; /* bricks in a row */
    int32_t down;
    float side; /* cells along one side of a node */
    /* Highest sample of the nodes (x - 1, y - 1), (x, y - 1), (x - 1, y) and (x, y), as far as they exist, at
     * ahead[y * (4 * across + 1) + x], x <= 4 * across, y <= 4 * down. So a node has four of these numbers, one for
     * each quadrant of directions in which a ray may go on from it. */
    float *ahead;
} cw_pyramid_level;

/* Every sample of the node, and every point of its triangles, has
 *     low <= z - slope_x * (x - x0) - slope_y * (y - y0) <= high
 * (x0, y0) being the node's middle. Both are widened by the rounding error of a ray's height above the plane, for rays
 * that start within the field or no farther from it than it is large (papers/numerics.md). A node without samples has
 * low > high. */
typedef struct cw_pyramid_slab {
    float low, high, slope_x, slope_y;
} cw_pyramid_slab;

/* Sums from which the planes of larger nodes are fitted, and the steepest slope in a node, at any level: over the
 * samples that the node owns, as a tile does (count_holes). x and y count from its first sample. NaN if one of them is
 * a hole. */
typedef struct cw_pyramid_sum {
    double z, xz, yz; /* sums of z, x · z and y · z */
    double steepest;
    cw_pyramid_slab slab; /* of a tile, not yet set outward */
} cw_pyramid_sum;

struct cw_pyramid {
    int levels; /* >= 1 */
    /* Node (x, y) of level l at slab[first[l + 1] + y * n + x], with n the nodes in a row, (nx - 2) / side + 1. */
    cw_pyramid_slab *slab;
    int32_t first[16];
    float steepest; /* the largest slope of any slab, and of any triangle in it, in heights a cell */
    float high;     /* the field's highest sample */
    cw_pyramid_level level[PYRAMID_LEVELS_MAX];
    /* Of nodes of level TILE_LEVEL, which stand for tiles even if there are fewer levels, and above: in rows as
     * slabs are. */
    cw_pyramid_sum *sum[PYRAMID_LEVELS_MAX];
    uint32_t *holes; /* of each tile, in rows: in the samples that it owns */
    void *memory;
    size_t bytes;
};

/* Lowest of node (x, y) of a level; its highest is 16 floats further on. */
static inline float *cw_pyramid_node(const cw_pyramid_level *l, size_t x, size_t y) {
    return l->bricks + ((y / 4) * (size_t)l->across + x / 4) * BRICK_FLOATS + (y % 4) * 4 + x % 4;
}

/* Nodes in a row of level l, and rows of them; also beyond the pyramid's top. */
static inline size_t cw_pyramid_across(const cw_field *f, int l) { return ((f->nx - 2) >> (2 * l + 2)) + 1; }
static inline size_t cw_pyramid_down(const cw_field *f, int l) { return ((f->ny - 2) >> (2 * l + 2)) + 1; }

/* src/core/bounds/tile.c: everything below and at TILE_LEVEL that tile (x, y) determines. Different tiles may be
 * done at once. */
void cw_pyramid_tile(const cw_field *f, struct cw_pyramid *p, size_t x, size_t y);

/* src/core/bounds/slabs.c: sum and slab of node (x, y) of a level above TILE_LEVEL, from those of its tiles. */
void cw_pyramid_node_slab(const cw_field *f, struct cw_pyramid *p, int level, size_t x, size_t y);

/* Sets a slab outward, or level where that makes it no thicker than its node, which reaches from low to high: there
 * no room for a ray's place is needed (papers/numerics.md). Returns the largest slope in it. */
static inline float cw_slab_outward(cw_pyramid_slab *s, const cw_field *f, float low, float high) {
    if (!(s->low <= s->high)) return 0;
    const float slope = fabsf(s->slope_x) + fabsf(s->slope_y) + (s->high - s->low);
    const float pad = SLAB_ROUNDING * (2 * (float)(f->nx + f->ny) * slope);
    if (s->high - s->low + 2 * pad < high - low) {
        s->low -= pad;
        s->high += pad;
        return slope;
    }
    *s = (cw_pyramid_slab){low, high, 0, 0};
    return high - low;
}

/* The lowest and highest of the 16 children in a brick become its node's; NaN if there is none. */
static inline void cw_pyramid_set_bounds(float *node, float low, float high) {
    const bool some = low <= high;
    node[0] = some ? low : NAN;
    node[16] = some ? high : NAN;
}

static inline void cw_pyramid_bound_brick(const cw_pyramid_level *from, const cw_pyramid_level *to, size_t x,
                                          size_t y) {
    const float *brick = cw_pyramid_node(from, 4 * x, 4 * y);
    float low = INFINITY, high = -INFINITY;
    for (int k = 0; k < 16; k++) {
        low = lower(brick[k], low);
        high = higher(brick[16 + k], high);
    }
    cw_pyramid_set_bounds(cw_pyramid_node(to, x, y), low, high);
}

#endif
