/* SPDX-License-Identifier: Apache-2.0 */
/* The ground in sight along one direction, from many samples: what visible_kernel.c gets to walk on.
 *
 * All rays of a direction cross the same borders at the same places (heading.h). The land is a copy of the field,
 * turned so that every ray goes toward greater rows and crosses at most one column a row. Eyes that are neighbours
 * across the ray then read neighbouring samples. Columns of the same remainder by the spacing of the eyes stand
 * together, so that eyes with gaps between them do, too. */
#ifndef CELLWALK_TERRAIN_VISIBLE_JOB_H
#define CELLWALK_TERRAIN_VISIBLE_JOB_H

#include "cellwalk_expert.h"

/* Eyes are walked from in groups of so many columns. A ray may read so many columns beyond the land: they are holes.
 * Bounds are made of 8 rows, and of 64. Areas are summed over runs of VISIBLE_RUN pieces at most. */
enum { VISIBLE_GROUP = 16, VISIBLE_MARGIN = 32, VISIBLE_LEVELS = 2, VISIBLE_RUN = 128 };
static inline int visible_shift(int level) { return 3 * (level + 1); }

/* A crossing of an edge. Distances count in cells along the ray's longer axis. */
typedef struct visible_crossing {
    ptrdiff_t first; /* from the eye's sample to the edge's first one */
    int32_t second;  /* from there to its second one */
    float fraction;  /* of the way to that */
    float inverse;   /* of the distance */
    float drop;      /* by which the slope is less on a curved earth; 0 on a flat one */
} visible_crossing;

/* The piece of the ray that ends at a crossing. */
typedef struct visible_piece {
    float begin, end;
    float length, twice; /* its length and twice its end, times the run's scale */
} visible_piece;

/* Pieces that lie together, from the eye on. Their areas are multiples of a unit, a power of 4 that grows outward. */
typedef struct visible_run {
    double unit;
    float scale, inverse; /* 1 / sqrt(unit), and 1 / scale */
    size_t until;         /* number of the first piece of the next run */
} visible_run;

/* What is asked for; whether a target stands above the ground, the land has holes, or level blocks. */
enum { VISIBLE_AREA = 1, VISIBLE_FARTHEST = 2, VISIBLE_TARGET = 4, VISIBLE_HOLES = 8, VISIBLE_LEVEL = 16 };

typedef struct visible_job {
    const float *land; /* the sample of column 0 and row 0 */
    ptrdiff_t stride;
    size_t rows; /* of the land */
    /* Of each block of rows, where a ray enters it in a given column: at least as high as all samples that the ray
     * reads in it. -infinity: there are none. */
    float *bound[VISIBLE_LEVELS];
    /* Of each block of 8 rows, likewise: the height of all samples that the ray reads in it, or NaN if they differ. */
    const float *level;

    const visible_crossing *crossing; /* in the order of their distances */
    const visible_piece *piece;
    const visible_run *run; /* the first */
    const double *whole;    /* areas of all pieces up to a crossing if they are in sight, as the kernel sums them */
    const float *sunk; /* how far below the eye level ground from row k of the ray on must lie to be seen as a whole */
    const uint32_t *until;  /* number of crossings up to row k of the ray, that row's included */
    const ptrdiff_t *entry; /* the column in which the ray crosses row k, as a distance in memory */
    size_t steps;           /* rows that the ray goes through at most */
    float reach;            /* the last piece ends there; 0: at its crossing */

    unsigned look; /* VISIBLE_AREA, VISIBLE_FARTHEST or both, and what else holds */

    float eye, target; /* heights above the ground */
    float lift;        /* a bound rises so far above it, target and rounding included */
} visible_job;

/* Eyes of VISIBLE_GROUP columns, the first at `eyes` from column 0, in count rows from row on, step apart. No ray is in
 * the land for more than most rows. area: twice the integral of the distance over what is in sight, NaN at a hole, even
 * if only farthest is asked for; farthest: the greatest distance in sight, or 0. Both VISIBLE_GROUP to a row. */
typedef void visible_walk_fn(const visible_job *job, ptrdiff_t eyes, size_t row, size_t step, size_t count, size_t most,
                             float *area, float *farthest);

/* Greatest and least numbers of a row, width of them, at offsets at[0] to at[count - 1]: high[k] becomes the greatest
 * of it and from[k + at[n]], NaN left out; low[k], unless low is NULL, the least, NaN as -infinity. */
typedef void visible_bound_fn(float *high, float *low, const float *from, const ptrdiff_t *at, size_t count,
                              size_t width);

typedef struct visible_code {
    visible_walk_fn *walk;
    visible_bound_fn *bound;
} visible_code;

extern const visible_code cw_visible1, cw_visible4, cw_visible8, cw_visible16;

#endif
