/* SPDX-License-Identifier: Apache-2.0 */
/* One part of a sweep, between two directions: the skyline so far, and the rows that are next. */
#ifndef CELLWALK_TERRAIN_SWEEP_PART_H
#define CELLWALK_TERRAIN_SWEEP_PART_H

#include "skyline.h"
#include "sweep.h"

/* Ranges of directions next to the eye; columns per fetch; samples beside those between directions; rows prefetched. */
enum { SWEEP_AROUND = 32, SWEEP_COLUMNS = 16, SWEEP_PAD = 12, SWEEP_AHEAD = 24 };

/* Edges from a sample: along the near row, on to the far one, and across the cell. */
enum { SWEEP_ROW = 1, SWEEP_SIDE = 2, SWEEP_DIAGONAL = 4 };

/* Up to here all samples are looked at exactly, as edges may be so near to the eye that they do not count, and all
 * edges are added. */
static const double sweep_close_rows = 3;

/* The skyline begins there: a cell from the eye, less a hair. Nearer terrain is left to cw_sight_around. */
static const double sweep_first_distance = 1 - 0x1p-10;

/* A small range of directions. */
typedef struct sweep_bin {
    double low;     /* the skyline is nowhere lower */
    double high[3]; /* nothing in this row and the two before it rises by more, here or next to here */
    uint32_t start; /* the skyline's last piece that begins before it */
} sweep_bin;

typedef struct sweep_part {
    const sight *sight;
    bool swapped;       /* rows are columns of the field */
    int outward;        /* +1 or -1 */
    double eye, aside;  /* the eye's place across the rows and along them */
    long rows, length;  /* of the field, in this sense */
    double from, until; /* directions */
    double target;
    sweep_visit *visit;
    sweep_visit_span *visit_span;
    void *context;

    skyline line;
    uint32_t first; /* a piece that begins before the skyline's range */
    size_t bins;
    double width; /* of a sweep_bin */
    sweep_bin *of;

    const float *near;                /* the last row, or NULL */
    double *near_height, *far_height; /* of it and the present row, over the eye */
    /* How far the planes of triangles pass over the eye: those at the near row, those at the far one, and those at
     * the far row of the rows before. 0 where that is not known, NaN where there is no triangle. */
    double *front, *back, *back_before;
    double *edges;             /* from each sample those that matter: a sum of SWEEP_ROW and so on */
    uint32_t *along, *between; /* samples from which edges of the near row matter, or edges between the rows */
    size_t along_count, between_count;
    /* Samples of the near row whose heights are known, and of the far one. */
    long known_from, known_until, far_from, far_until;
    bool holes;       /* there have been some */
    uint32_t *starts; /* a piece of the skyline that began before each sample, when that was looked at; 0: none */

    /* The greatest so far: steps between neighbours, and the numbers whose rounding matters, per distance. */
    double step, snap, size, rise;
    double margin; /* planes that pass the eye this near may face it or not */
    double ahead;  /* the steepest rise to a sample exactly ahead or on the diagonal, of which a part has one */

    double around[SWEEP_AROUND]; /* rises next to the eye, in so many ranges of directions */
    double around_most;          /* the greatest of them */
    float *columns;              /* SWEEP_COLUMNS columns of the field, as rows, and the last before them */
    long columns_from, columns_left, columns_right;
} sweep_part;

static inline double sweep_distance(const sweep_part *p, long row) { return fabs((double)row - p->eye); }

/* Columns begin in different sets of lines of the cache, so that a sample of each can stay there. */
static inline size_t sweep_columns_stride(const sweep_part *p) { return ((size_t)p->length | 31) + 17; }

static inline long sweep_clipped(const sweep_part *p, double i) {
    return i > 0 ? i < (double)p->length ? (long)i : p->length : 0;
}

/* The lowering along a row is one + two x + three x², x samples to the side of the eye. */
typedef struct sweep_lowering {
    double one, two, three;
} sweep_lowering;

static inline sweep_lowering sweep_lowering_of(const sweep_part *p, long row) {
    const double *f = p->sight->fall, y = (double)row - p->eye;
    return p->swapped ? (sweep_lowering){f[0] * y * y, f[1] * y, f[2]} : (sweep_lowering){f[2] * y * y, f[1] * y, f[0]};
}

/* Bound on the difference of the skyline from the results of sight.c, for its edges and for those that were not
 * added. */
static inline double sweep_error(const sweep_part *p, double r) {
    return 0x1p-25 * p->snap + 0x1p-44 * p->size + 0x1p-45 * r * (p->line.steepest + p->rise);
}

/* ---- sweep_edges.c --------------------------------------------------------------------------------------------- */

/* Heights of a row's samples in these directions and next to them. */
const float *cw_sweep_fetch(sweep_part *p, long row);

/* Heights over the eye from sample begin up to end, if there are any, NaN at holes. */
void cw_sweep_heights(const sweep_part *p, const float *z, long row, long begin, long end, double *h);

/* How triangles between the near and far rows lean, at distance r. Lists edges that may then be highest on a way. */
void cw_sweep_lean(sweep_part *p, double r, long begin, long end);

/* Edges of the near row and those between the rows that matter are added to the skyline; start: a piece before them. */
void cw_sweep_add_row(sweep_part *p, double r, long begin, long end, uint32_t start);
void cw_sweep_add_between(sweep_part *p, double r, uint32_t start);

#endif
