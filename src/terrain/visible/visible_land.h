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

/* How far rounding can put a place on the ray off, as a part of the distance: as in heading.c. A place nearer to a sample than
 * that is the sample's. */
#define PLACE_ROUNDING 0x1p-50

/* Rays of one direction. Distances count in cells along the longer axis, which leads to greater rows. */
typedef struct ways {
    double aside; /* columns that a ray goes for each row, -1 to 1 */
    double reach; /* 0: none */
    double drop;  /* of the ground, times the squared distance */
    visible_crossing *crossing;
    visible_piece *piece;
    double *whole; /* whole, run and sunk are those of visible_job */
    visible_run *run;
    float *sunk;
    uint32_t *until;
    ptrdiff_t *entry;
    size_t steps, crossings;
    bool ends; /* at the reach */
} ways;

struct cw_visible {
    const cw_field *field;
    struct samples samples;
    const visible_code *code;   /* for the present direction's run */
    size_t i, j, every, nx, ny; /* eyes: the first one's sample, the gaps, and how many of them */

    /* The land, turned: columns of the same remainder by `every` stand together. */
    bool turned, transposed, rotated;
    size_t across, down;       /* columns and rows of the land */
    size_t before;             /* columns that stand before its first, so that eyes are in columns 0, every, … */
    ptrdiff_t segment, stride; /* columns of one remainder; a row */
    float *memory, *bound_memory[VISIBLE_LEVELS], *level_memory;
    size_t room, bound_room[VISIBLE_LEVELS], level_room;
    atomic_bool has_level; /* blocks */
    double aside[2];       /* of the rays that the bounds are right for */
    bool bounded;
    ways ways;
};

/* Floats before the first row and after the last one: bounds of the outermost columns are looked for there. */
enum { AROUND = 256 };

/* Turns the land so that the direction leads to greater rows. */
cw_status cw_visible_turn(cw_visible *v, const double dir[2], const cw_run *how);

/* Bounds that are right for rays that go aside by that much, give or take slack. */
cw_status cw_visible_bound(cw_visible *v, const cw_run *how, double aside, double slack);

/* Crossings up to the first one beyond the reach; w has aside, reach and drop, and is freed in any case. */
cw_status cw_visible_make_ways(const cw_visible *v, ways *w);
void cw_visible_free_ways(ways *w);

#endif
