/* SPDX-License-Identifier: Apache-2.0 */
/* Lines of sight from one place, in double: the highest terrain along them, seen from there.
 *
 * The surface is piecewise plane, so along a line its height over the place, divided by the distance, is greatest
 * where the line crosses an edge between two samples. Those crossings are looked at one by one, but for whole
 * stretches in which no sample is high enough. A curved earth sinks away by the square of the distance: the samples
 * are lowered by that, and the triangles stand on the lowered samples. */
#ifndef CELLWALK_TERRAIN_SIGHT_H
#define CELLWALK_TERRAIN_SIGHT_H

#include "terrain.h"

/* The pyramid of highest samples that lines of sight pass over. */
enum { SIGHT_LEVELS_MOST = 12, SIGHT_FIRST_SHIFT = 2 };

typedef struct sight_bounds {
    int levels;
    size_t across[SIGHT_LEVELS_MOST], down[SIGHT_LEVELS_MOST];
    /* Node (x, y) of level l, 4 << 2 l cells wide, is high[l][y * across[l] + x]; -infinity: no samples. */
    float *high[SIGHT_LEVELS_MOST];
} sight_bounds;
cw_status cw_sight_bounds_create(const terrain *t, sight_bounds **bounds);
void cw_sight_bounds_destroy(sight_bounds *bounds);

/* A place to look from. Numbers are those of the field: cells, and heights as the samples have them. */
typedef struct sight {
    const terrain *terrain;
    const sight_bounds *bounds;
    double eye[3];
    /* Ways count coordinates from the corner of the eye's cell, so that they have the same bits in any window. */
    double corner[2], near[2]; /* of the field; and the eye's from there, 0 to 1 */
    double fall[3];            /* lowering at (x, y) from the eye: fall[0] x² + fall[1] x y + fall[2] y² */
    /* Crossings are lowered, and the ground is straight between them, as headings have it; else samples are, and the
     * triangles stand on them. For rises alone: decisions lower samples. */
    bool at_crossings;
} sight;

/* curvature: as in cellwalk_terrain.h, of distances on the map. */
void cw_sight_init(sight *s, const terrain *t, const sight_bounds *bounds, const double eye[3], double curvature);

/* The same for a line to one place, with the map's scale in the line's middle: so it answers alike from either end.
 * middle is rounded so that it is the same in a window of the raster, too. */
void cw_sight_middle(const double from[2], const double to[2], double middle[2]);
void cw_sight_init_line(sight *s, const terrain *t, const double eye[3], const double middle[2], double curvature);

static inline double sight_fall(const sight *s, double i, double j) {
    const double x = i - s->eye[0], y = j - s->eye[1];
    return s->fall[0] * x * x + s->fall[1] * x * y + s->fall[2] * y * y;
}
/* Sample (i, j) as seen from the eye: its height over the eye's, lowered. */
double cw_sight_sample(const sight *s, size_t i, size_t j);

/* The steepest rise from the eye on the way to (i, j), as height over the eye per share of the way, both ends left
 * out, and a share at which it is; rounded. Values not above least are returned as least, at share 0. */
typedef struct sight_rise {
    double steepest, share;
} sight_rise;
sight_rise cw_sight_steepest(const sight *s, double i, double j, double least);
/* More than of a way's ends is left out, in cells: a way that is so much longer has what lies at its end. */
#define SIGHT_END 0x1p-26

/* The least share of the way to (i, j) at which something rises as steeply as that, the steepest, but for twice the
 * error of either: of a plane through the eye, all crossings are such ties. */
double cw_sight_nearest(const sight *s, double i, double j, sight_rise steepest);

/* Parts of the way to a place: the first so many cells from it, or all of it, and the last cell before the eye.
 * Cells count along the way's longer axis. */
typedef struct sight_parts {
    double close; /* infinite: all */
    bool eye;
} sight_parts;

/* No rise within one cell of the eye is steeper than that in the directions between a and b, as height over the eye
 * per cell along the way's longer axis, which is the same for both: a and b are one long along it. */
double cw_sight_around(const sight *s, const double a[2], const double b[2]);

/* These decide exactly: for the samples, eye and heights as they are given, and lowerings as sight_fall rounds them,
 * an answer is that of real numbers. An edge is part of the surface if neither of its samples is a hole, and so is a
 * sample with a height. Coordinates are rounded to multiples of 2^-60. Rounding must be to nearest. */

/* Whether the sample (i, j), or what stands above it, is seen, if nothing hides it outside these parts of the way: z
 * is its height and above that of the target over it, in the samples' numbers. Terrain that touches the line blocks
 * it. */
bool cw_sight_sees(const sight *s, double i, double j, double z, double above, sight_parts parts);

/* How high over the sample (i, j) of height z something must at least stand so that nothing is above the line to it:
 * 0 only if nothing is above the line to the sample. low: something is known to rise by at least that on the way, as
 * cw_sight_steepest has it, or -infinity. Rounded. */
double cw_sight_need(const sight *s, double i, double j, double z, double low);

/* The same, where the steepest rise on the way is known to be rise, off by less than error, but for these parts of
 * the way. NaN if that does not say whether the rise matters. */
double cw_sight_need_known(const sight *s, double i, double j, double z, double rise, double error, sight_parts parts);

/* The first place on the way to (i, j), at height z in the samples' numbers, at which the straight line to there is
 * on or below the surface, as a share of the way, with both ends left out; infinite if there is none. That there is
 * one is exact, where it is is rounded. */
double cw_sight_first_block(const sight *s, double i, double j, double z);

/* lines.c: the answer for a line to target, blocked at that share of the way or, if that is infinite, not at all; and
 * where its ends are on the map. */
cw_sight_answer cw_sight_settle(const sight *s, const double target[3], const double middle[2], double block,
                                double ends[2][2]);

/* viewshed.c: what the eye of a sight, which has bounds, sees: as cw_viewshed. Of the observer only target and limits
 * are used. */
cw_status cw_viewshed_from(const sight *s, const cw_observer *from, const cw_run *run, cw_area area,
                           const cw_view *view);

#endif
