/* SPDX-License-Identifier: Apache-2.0 */
/* Horizons of all samples in directions from sample to sample, (dx, dy) in small whole numbers: exact, in time that does not
 * depend on how far there is to see. */
#ifndef CELLWALK_TERRAIN_GRID_HORIZON_H
#define CELLWALK_TERRAIN_GRID_HORIZON_H

#include "terrain.h"

/* Without a common divisor; at most GRID_STEP each. */
enum { GRID_STEP = 3, GRID_DIRECTIONS_MOST = 32 };
typedef struct grid_direction {
    int dx, dy;
} grid_direction;

/* The 8, 16 or 32 directions with steps of up to 1, 2 or 3 samples, from (0, 1) on in the order of angles toward (1, 0); false
 * for any other count. */
bool grid_directions(size_t count, grid_direction *directions);

/* rises[j * nx + i] becomes the steepest rise from sample (i, j) along the direction, or NaN at a hole: of the same crossings as
 * cw_heading_steepest has from -infinity to infinity, computed in double and rounded once. drop is that of cw_heading_desc. Of
 * run the pool counts; the bits are the same for any. */
cw_status grid_rises(const terrain *t, grid_direction direction, double drop, const cw_run *run, float *rises);

#endif
