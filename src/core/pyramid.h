/* SPDX-License-Identifier: Apache-2.0 */
/* The bounds pyramid: lowest and highest sample of ever larger blocks of cells.
 *
 * A node of level 0 covers a *block* of 4 × 4 cells; a node of level l + 1 covers 4 × 4 nodes of level l, which lie
 * together in memory as one *brick*: 16 lows, then 16 highs, two cache lines. The top level is one brick. Any field shape
 * costs less than 1.5 bytes a cell plus the partly filled bricks along its far borders; nodes outside the field have
 * low > high, which no ray meets.
 *
 * After the maximum mipmaps of Tevs, Ihrke and Seidel (2008) and pbrt-like min-max quadtrees, but 16 children wide, so
 * that one vector comparison judges all children of a node at once. Level-0 bounds of single cells are not stored: they
 * follow from the samples that the leaf test loads anyway. */
#ifndef CELLWALK_CORE_PYRAMID_H
#define CELLWALK_CORE_PYRAMID_H

#include "cellwalk.h"

enum { PYRAMID_LEVELS_MAX = 12, BRICK_FLOATS = 32 };

typedef struct cw_pyramid_level {
    float *bricks;  /* brick (x, y) at bricks + (y * across + x) * BRICK_FLOATS */
    int32_t across; /* bricks in a row */
    int32_t down;
    float side; /* cells along one side of a node */
    /* Highest sample of node (x, y) and its up to eight neighbours at around[y * 4 * across + x]: what a ray that starts
     * in the node cannot meet anything above of before it has gone a node's side. */
    float *around;
} cw_pyramid_level;

struct cw_pyramid {
    int levels; /* >= 1 */
    /* The same bounds once more for the lane walk, whose lanes are at different levels: node (x, y) of level l has its low
     * and high at pairs[2 * (first[l] + y * across + x)], one stride for all levels. */
    float *pairs;
    int32_t across;
    int32_t first[PYRAMID_LEVELS_MAX];
    float high; /* the field's highest sample */
    cw_pyramid_level level[PYRAMID_LEVELS_MAX];
    void *memory;
    size_t bytes;
};

#endif
