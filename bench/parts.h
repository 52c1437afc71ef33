/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench parts: how fast are the pieces that the kernels are made of? */
#ifndef CELLWALK_BENCH_PARTS_H
#define CELLWALK_BENCH_PARTS_H

#include "cellwalk.h"

typedef enum part_kind {
    PART_PREPARE = 0,     /* make a ray ready for a walk: make_rays */
    PART_LEAF_WATERTIGHT, /* a ray against a cell: wt_cell */
    PART_LEAF_MOLLER_TRUMBORE,
    PART_NODE,      /* a step of the lane walk from node to node: stream_step */
    PART_REFILL,    /* a ray into a lane: refill_lane, and the lanes into registers: load_lanes */
    PART_GATHER,    /* a number a lane from anywhere: vf_gather */
    PART_PAIRS,     /* two neighbouring numbers a lane: vf_gather_pairs */
    PART_LOAD,      /* numbers that lie together, one a lane: vf_load */
    PART_BROADCAST, /* one number for all lanes: vf_set */
    PART_COUNT
} part_kind;

/* What the parts work on. Multiples of 16. Rays aimed at cells are few, as with all that a leaf test takes they have 168
 * bytes and are to stay in the first-level cache; the others are many, so that branches do not learn them by heart. */
enum { PARTS_RAYS = 2048, PARTS_AIMED = 128 };
typedef struct parts_work {
    const cw_field *field;          /* with its pyramid */
    const cw_ray *rays;             /* PARTS_RAYS, from above the field into it */
    const cw_ray *aimed;            /* PARTS_AIMED, number k at a point within triangle A of cell (i[k], j[k]) */
    const int32_t *cell_i, *cell_j; /* … */
    const float *table;             /* of what is gathered and loaded */
    const int32_t *places;          /* where; even numbers, far enough from the table's end to load 16 */
    size_t place_count;             /* a multiple of 64 */
    size_t hits;                    /* of the last leaf test: all of the aimed rays, or it has been set up wrongly */
    volatile float sink;            /* keeps the compiler from leaving work out */
    void (*keep)(const void *of);   /* looks at all of it, as far as the compiler can tell */
} parts_work;

/* Runs a part once over all that there is; how many operations that were: rays, tests, steps, numbers. */
typedef uint64_t parts_run(part_kind kind, parts_work *work);

/* parts.inc.c, compiled for each kernel of the pyramid; the second of each pair counts (src/core/count.h). */
parts_run parts_run_scalar, parts_count_scalar;
parts_run parts_run_sse42, parts_count_sse42;
parts_run parts_run_sse42_twice, parts_count_sse42_twice;
parts_run parts_run_avx2, parts_count_avx2;
parts_run parts_run_avx2_twice, parts_count_avx2_twice;
parts_run parts_run_avx512, parts_count_avx512;

int parts_main(char **arguments, int count);

#endif
