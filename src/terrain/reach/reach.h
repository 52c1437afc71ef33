/* SPDX-License-Identifier: Apache-2.0 */
/* How much of a raster matters to a part of it: the rectangle of samples that must be in memory so that the part's
 * answers have the bits that they have with all of the raster.
 *
 * Rectangles are in the numbers of the whole raster, and hold at least 2 x 2 samples where they are to be read. */
#ifndef CELLWALK_TERRAIN_REACH_H
#define CELLWALK_TERRAIN_REACH_H

#include "terrain.h"

/* The samples that lines from a place to samples of the part pass; the place may lie outside the raster. */
cw_rectangle cw_reach_between(const terrain *whole, const double at[2], cw_rectangle part);

/* With more columns and rows on each side, as far as the raster goes, and at least 2 of each. */
cw_rectangle cw_reach_grow(const terrain *whole, cw_rectangle part, double more);

/* The least rectangle that holds both; one without samples counts for nothing. */
cw_rectangle cw_reach_both(cw_rectangle a, cw_rectangle b);

/* The samples within so many metres of a place in the whole raster's field coordinates, as view_limits.h measures them:
 * the least rectangle that has them, which has no samples if there are none. */
cw_rectangle cw_reach_within(const terrain *whole, const double at[2], double metres);

/* The samples that a viewshed from there to that distance looks at. */
cw_rectangle cw_reach_around(const terrain *whole, const double at[2], double metres);

/* The part, grown by so many metres in every direction. */
cw_rectangle cw_reach_beside(const terrain *whole, cw_rectangle part, double metres);

/* Lowest and highest samples of blocks of the raster. */
enum { REACH_BLOCK = 256 };
typedef struct reach_blocks {
    const terrain *whole;
    size_t across, down;
    float *low, *high;     /* low > high: all are holes, or were not taken */
    bool *holes;           /* whether some are */
    float highest, lowest; /* of all */
} reach_blocks;

cw_status cw_reach_blocks_create(const terrain *whole, reach_blocks *blocks);
void cw_reach_blocks_destroy(reach_blocks *blocks);
/* Takes samples that are in memory. Of a block all must have been taken, in any number of parts. */
void cw_reach_blocks_take(reach_blocks *blocks, cw_rectangle part, const float *z);

/* An edge that is crossed ends up to a cell beside the way, and normals look at the next samples. */
#define REACH_BESIDE 2.0
/* The samples of block (x, y). */
cw_rectangle cw_reach_block(const reach_blocks *blocks, size_t x, size_t y);
/* No edge with a sample in it is computed to be higher anywhere; -infinity if all are holes. */
double cw_reach_highest(const reach_blocks *blocks, size_t x, size_t y);
/* Heights on an edge, seen from a sample, are off by so much of the edge's range at most: 8u (src/terrain/heading.c). */
#define REACH_ROUNDING 0x1p-21

/* The ways from samples of a part toward the sun's disc. */
typedef struct reach_sunward {
    double cells[2][2]; /* that a metre on the way leads along columns and rows: least, greatest */
    double tangent;     /* of the lowest ray's altitude, rounded down */
} reach_sunward;

/* light has the sun's place, disc and strips. */
reach_sunward cw_reach_toward(const terrain *whole, const cw_light *light, cw_rectangle part);

/* Whether rays from the part toward the sun pass over a rectangle at all, and between which metres on their way. */
bool cw_reach_passes(const reach_sunward *sunward, cw_rectangle part, cw_rectangle over, double *first, double *last);

/* The part and all that can throw a shadow on it. All blocks that rays from the part pass over must have been taken,
 * and those of the part. */
cw_rectangle cw_reach_of_shadows(const reach_blocks *blocks, const reach_sunward *sunward, cw_rectangle part);

/* Horizons of samples of a window: what can matter to them, as far as highest and lowest samples of blocks tell. */
typedef struct reach_horizons {
    const reach_blocks *blocks;
    cw_rectangle window;
    double curvature;
    bool above_level;
    struct reach_row {
        bool known;
        cw_rectangle matters;
    } * rows; /* of blocks */
    struct ring *rings;
    size_t *best;
} reach_horizons;

/* All blocks must have been taken, and stay. curvature as in cellwalk_terrain.h. above_level: what is not above the
 * level of a sample does not count for it, as in the sky view. */
cw_status cw_reach_horizons_create(const reach_blocks *blocks, cw_rectangle window, double curvature, bool above_level,
                                   reach_horizons *horizons);
void cw_reach_horizons_destroy(reach_horizons *horizons);

/* A part of the window and all that can be its samples' horizon, normals included. Not from two threads at once. */
cw_rectangle cw_reach_of_horizons(reach_horizons *horizons, cw_rectangle part);

#endif
