/* SPDX-License-Identifier: Apache-2.0 */
/* A heading: one direction across the field, in which rays leave from samples.
 *
 * Rays from all samples in one direction are copies of one another: the k-th border or diagonal is crossed at the
 * same distance from the start, between samples with the same offsets, at the same fraction of the way between them.
 * So the crossings are computed once, in double, for the whole field. For each sample only two heights are read at
 * each crossing. Along a straight line above a triangle the slope up from the start is monotone, so the steepest one
 * is at a crossing. Places between crossings need no test, and the start, on the surface itself, is no special case. */
#ifndef CELLWALK_CORE_HEADING_H
#define CELLWALK_CORE_HEADING_H

#include "field.h"
#include "pyramid.h"

/* Rays are walked in groups of 16 neighbours in a row, and four rows: so many share the bounds that a stretch is
 * judged by. */
enum { GROUP_COLUMNS = 16, GROUP_ROWS = 4, GROUP_SAMPLES = GROUP_COLUMNS * GROUP_ROWS };

/* The second sample of a crossing is so far from the first. */
typedef enum cw_crossing_kind {
    CROSSES_VERTEX, /* is the first itself */
    CROSSES_ROW,    /* one column on: a border between rows is crossed */
    CROSSES_COLUMN, /* one row on */
    CROSSES_DIAGONAL
} cw_crossing_kind;

typedef struct cw_crossing {
    float fraction; /* of the way from the first sample to the second */
    float inverse;  /* 1 / t */
    int32_t i_kind; /* columns from the start to the first sample, times 4, plus a cw_crossing_kind */
    int32_t j;      /* rows */
} cw_crossing;

/* Crossings that follow each other, over 4 cells along the longer axis at level 0 and four times as many at each
 * further one. */
typedef struct cw_stretch {
    uint32_t first; /* at level 0: crossing; the next stretch's first one ends it */
    float inverse_least, inverse_most;
    float drop;                           /* the least of its crossings; 0 on a flat earth */
    int32_t i_low, i_high, j_low, j_high; /* samples that are read, from the start's */
} cw_stretch;

struct cw_heading {
    const cw_field *field;
    bool along_x; /* its longer axis */
    size_t crossings;
    cw_crossing *crossing;
    float *drop; /* of each crossing: how much less steep it is on a curved earth; NULL on a flat one */
    int levels;
    uint32_t stretches[PYRAMID_LEVELS_MAX];
    cw_stretch *stretch[PYRAMID_LEVELS_MAX]; /* one more than there are, for its first */
};

/* A rectangle of samples, and where the answers go, row by row. */
typedef struct cw_heading_job {
    const cw_heading *heading;
    size_t i, j, nx, ny;
    float low, high; /* rises are clamped to them; for any-hit answers high is the slope to compare with */
    float pad;       /* by which rounding can put a place on an edge above both its samples, seen from a third one */
    float *steepest;
    uint8_t *occluded; /* instead of steepest */
} cw_heading_job;

/* simd/heading_kernel.c, for samples i to i_end, j to j_end of the rectangle, without the ends. */
typedef void cw_heading_fn(const cw_heading_job *job, size_t i, size_t i_end, size_t j, size_t j_end);
cw_heading_fn cw_heading1, cw_heading4, cw_heading8, cw_heading16;

#endif
