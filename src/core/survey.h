/* SPDX-License-Identifier: Apache-2.0 */
/* Samples that are holes or refused, tile by tile. So the number of holes is found again in little time when some samples
 * change. */
#ifndef CELLWALK_CORE_SURVEY_H
#define CELLWALK_CORE_SURVEY_H

#include "field.h"

#include <stdatomic.h>

/* Cells along one side of a tile, as of a node of the pyramid's level 2. */
enum { TILE_LEVEL = 2, TILE_SIDE = 64 };

/* Tiles x to x_last, y to y_last, all in. */
typedef struct cw_tiles {
    size_t x, y, x_last, y_last;
} cw_tiles;

static inline size_t cw_tiles_across(const cw_field *f) { return (f->nx - 2) / TILE_SIDE + 1; }
static inline size_t cw_tiles_down(const cw_field *f) { return (f->ny - 2) / TILE_SIDE + 1; }

/* Samples that are refused, found by several threads: the first one in the order of rows counts, so that the status
 * is the same for any number of them. */
typedef struct cw_refusal {
    atomic_uint_least64_t first; /* the sample's number, row by row */
} cw_refusal;

#define CW_REFUSED_NONE UINT64_MAX

cw_status cw_refusal_status(const cw_field *f, cw_refusal *refusal);

/* Holes among the samples that tile (x, y) owns: each sample is owned by one tile, the one in which it is not on the last row or
 * column, if there is one. */
uint32_t cw_count_holes(const cw_field *f, size_t x, size_t y, cw_refusal *refusal);

/* Sets the field's reach, from its lowest and highest sample. */
void cw_set_reach(cw_field *f);

/* Fails if one of samples z[0..n), which are (i, j) and on, may not be part of a field. */
cw_status cw_survey_check(const float *z, size_t i, size_t j, size_t n, bool infinities);

#endif
