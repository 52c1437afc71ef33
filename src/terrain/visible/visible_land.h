/* SPDX-License-Identifier: Apache-2.0 */
/* The land turned toward a direction, its bounds, and where rays of the direction cross its edges. */
#ifndef CELLWALK_TERRAIN_VISIBLE_LAND_H
#define CELLWALK_TERRAIN_VISIBLE_LAND_H

#include "large.h"
#include "run.h"
#include "samples.h"
#include "visible.h"
#include "visible_job.h"

#include <stdatomic.h>

/* Arrays that are kept from direction to direction. BOUND is level 0's. */
enum { LAND, LEVEL, WAYS, BOUND, ARRAYS = BOUND + VISIBLE_LEVELS };

struct cw_visible {
    struct samples samples;
    const visible_code *code; /* for the present direction's run */
    size_t i, j, every, nx;   /* eyes: the first one's sample, the gaps, and how many of them stand in a row */
    struct {
        float *at;
        size_t count;
    } array[ARRAYS];

    /* The land, turned: columns of the same remainder by `every` stand together. */
    bool turned, transposed, rotated;
    size_t across, down;       /* columns and rows of the land */
    size_t before;             /* columns that stand before its first, so that eyes are in columns 0, every, … */
    ptrdiff_t segment, stride; /* columns of one remainder; a row */
    atomic_bool has_level;     /* blocks */
    double aside[2];           /* of the rays that the bounds are right for */
    bool bounded;
};

/* Floats before the first row and after the last one: bounds of the outermost columns are looked for there. */
enum { AROUND = 256 };

/* Turns the land so that the direction leads to greater rows. Its rays go aside by -1 to 1 columns for each of them. */
cw_status cw_visible_turn(cw_visible *v, const double dir[2], const cw_run *how);

/* Bounds that are right for rays that go aside by that much, give or take slack. */
cw_status cw_visible_bound(cw_visible *v, const cw_run *how, double aside, double slack);

/* Where rays cross edges, up to the first crossing beyond the reach unless that is 0: the job's fields from crossing to
 * reach, all others 0. Distances are in cells along the longer axis; drop times their square lowers the ground. */
cw_status cw_visible_make_ways(cw_visible *v, double aside, double reach, double drop, visible_job *job);

#endif
