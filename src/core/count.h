/* SPDX-License-Identifier: Apache-2.0 */
/* Counts the steps of walks. Calls of count_step are empty unless CELLWALK_COUNT is defined. The build compiles the
 * kernels a second time with it, for cellwalk-bench alone. So counts are of the same source that is timed, and timed
 * code does not count. Both give the same hits. */
#ifndef CELLWALK_CORE_COUNT_H
#define CELLWALK_CORE_COUNT_H

#include <stdint.h>

/* Events, each with the lanes (or rays of a tile) that took part in it. */
typedef enum count_kind {
    COUNT_RAY,          /* vectors of rays made ready; lanes: rays that may hit */
    COUNT_CLIMB,        /* levels that climbing rays looked at */
    COUNT_FLAT,         /* steps from cell to cell */
    COUNT_STREAM,       /* turns of the lane walk; lanes: those that hold a ray */
    COUNT_NODE,         /* of these, steps from node to node; lanes: those that take it, the rest wait at cells */
    COUNT_ROUND,        /* of these, rounds of cell tests; lanes: those that wait for it */
    COUNT_RELOAD,       /* stops of the lane walk to refill; lanes: those that hold a ray then */
    COUNT_REFILL,       /* rays put into a lane */
    COUNT_SHARED,       /* tiles and groups that share a walk; lanes: their rays */
    COUNT_SHARED_NODE,  /* nodes that these opened */
    COUNT_SHARED_BLOCK, /* blocks of 4 × 4 cells that they came to; lanes: rays concerned */
    COUNT_SHARED_CELL,  /* cells that a packet looked at together */
    COUNT_APART,        /* places where they fall apart; lanes: rays that go on alone */
    COUNT_LEAF,         /* leaf tests: ray against the two triangles of a cell; lanes: rays that passed the gate */
    COUNT_VOXEL,        /* voxels of the 3D grid */
    COUNT_TRIANGLE,     /* triangles tested in them */
    COUNT_KINDS
} count_kind;

#ifdef CELLWALK_COUNT

typedef struct count_sum {
    uint64_t events, lanes;
} count_sum;

/* Defined by the program that links the counting objects. Not thread-safe. */
extern count_sum cw_counts[COUNT_KINDS];

/* One event in which these lanes take part. */
static inline void count_step(count_kind kind, uint64_t lanes) {
    cw_counts[kind].events++;
    cw_counts[kind].lanes += (uint64_t)__builtin_popcountll(lanes);
}

#else

static inline __attribute__((always_inline)) void count_step(count_kind kind, uint64_t lanes) {
    (void)kind, (void)lanes;
}

#endif

#endif
