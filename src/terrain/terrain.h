/* SPDX-License-Identifier: Apache-2.0 */
/* A height field as a piece of the earth: where its samples lie on the map, the map's units in metres, and where the
 * compass points.
 *
 * The surface is the one that the field's rays meet, two triangles a cell. Directions of the compass are the map's: 0
 * is the direction in which y grows, 90 the one in which x does. On a map in degrees, metres in a degree are those at
 * the row in question, and so are metres of ground in the unit of a projected map whose scale is known (map_scale.h).
 * Lines are straight on the map. So at latitude φ a place at distance L is met up to L tan φ / 2 R beside its azimuth,
 * 0.027 degrees for 5 km at 50 degrees, and its distance is wrong by up to 0.385 times that share, 0.02 %.
 * papers/terrain.md has the measurement. */
#ifndef CELLWALK_TERRAIN_TERRAIN_H
#define CELLWALK_TERRAIN_TERRAIN_H

#include "cellwalk_terrain.h"
#include "map_scale.h"

typedef struct cw_terrain terrain;

/* So far under the ground a place may be, in metres: its height may come from decimals, and floats are known to half a
 * millimetre at 8000 m. */
#define TERRAIN_LEAST_DEPTH 1e-3
/* Heights of eyes and targets, in the samples' numbers. Samples are within it too, and products of exact decisions do
 * not overflow. */
#define TERRAIN_HEIGHT_MOST 0x1p120

struct cw_terrain {
    const cw_field *field;
    size_t nx, ny, stride;
    const float *z; /* sample (i, j) is z[j * stride + i]; NaN and infinity are holes */

    double map[3][4];             /* samples to the map; the third row: heights in metres */
    double back[2][3];            /* map x and y to field x and y */
    bool geographic;              /* map x and y are angles */
    double unit;                  /* metres, or radians, in one of them */
    const map_scale *scale;       /* NULL: such a metre is one on the ground */
    double radius, eccentricity2; /* of the ellipsoid: the equator's, in metres; e² */

    /* NULL, or the raster that the samples are a window of, from its sample (column, row) on. Directions and metres are
     * then those of the raster, bit for bit, and only its size and map are used: its samples need not be in memory. */
    const terrain *whole;
    size_t column, row;

    const struct sight_bounds *bounds; /* those that are given; NULL: none */
    struct terrain_own *own;           /* of cw_terrain_create: the scale, and bounds once they are needed; else NULL */
};

/* Places a terrain, whose samples and sizes are set, on its map: heights in the unit of x and y, or in metres if these
 * are angles. False if the map cannot be inverted. Keeps the pointers of desc, whose scale is a map_scale. */
bool cw_terrain_place(terrain *t, const double (*map)[4], const cw_terrain_desc *desc);

static inline const float *terrain_row(const terrain *t, size_t j) { return t->z + j * t->stride; }

/* The pyramid of highest samples: the one that is given, or kept by the terrain since it was first needed, or else a
 * new one until it is released. */
cw_status cw_terrain_bounds(const terrain *t, const struct sight_bounds **bounds);
void cw_terrain_bounds_release(const terrain *t, const struct sight_bounds *bounds);

/* Metres in one of the map's x and y, at field coordinates (i, j). */
void cw_terrain_metres(const terrain *t, double i, double j, double metres[2]);

/* Whether they differ from row to row. */
static inline bool terrain_has_rows(const terrain *t) { return t->geographic || t->scale != NULL; }

static inline void terrain_to_map(const terrain *t, double i, double j, double xy[2]) {
    for (int k = 0; k < 2; k++) xy[k] = t->map[k][0] * i + t->map[k][1] * j + t->map[k][3];
}
static inline void terrain_from_map(const terrain *t, double x, double y, double ij[2]) {
    for (int k = 0; k < 2; k++) ij[k] = t->back[k][0] * x + t->back[k][1] * y + t->back[k][2];
}

/* A direction of the compass in field coordinates, about a cell long, as seen from there; returns its length in
 * metres. */
double cw_terrain_direction(const terrain *t, double i, double j, double azimuth, double dir[2]);

/* How many such steps lead out of the terrain, and one more; infinite if dir is 0. */
double cw_terrain_steps_out(const terrain *t, const double at[2], const double dir[2]);

/* Height of the surface in metres at field coordinates, as rays meet it; NaN outside and in holes. */
double cw_terrain_height(const terrain *t, double i, double j);
/* The same in the samples' numbers: a sample's own at the sample. */
double cw_terrain_level(const terrain *t, double i, double j);

/* Metres of height in one of the samples' numbers. */
static inline double terrain_metres_of_height(const terrain *t) { return t->map[2][2]; }

/* Metres, directions and rows are those of the whole raster. */
static inline const terrain *terrain_whole(const terrain *t) { return t->whole ? t->whole : t; }

/* Slopes of the surface at the samples of a rectangle, metres in a metre: how it rises eastward and northward; NaN
 * where there is no triangle. Metres are those of a row of the whole raster, for rows that share a heading, or if row
 * is NaN each row's own. */
void cw_terrain_slopes(const terrain *t, cw_pool *pool, double row, cw_rectangle at, float *east, float *north);

/* Rows from row on whose scales differ by less than 10^-4, so that they may share one heading: all of them, or at most
 * 256 if scales differ from row to row. Lengths are off by up to that; azimuths by half of it on a map in degrees,
 * where one scale changes, and by all of it where both may. So angles are off by 0.003 (1 + s) degrees, or
 * 0.003 (1 + 2 s), s being the steepest rise. */
size_t cw_terrain_rows_alike(const terrain *t, size_t row);

/* Where a place of the map lies, in field coordinates; false if that is not in reach. Places of the map that are
 * computed from a file's numbers are off by some last digits. One that is on a line of samples or on a diagonal but
 * for that shall be on it, so all are rounded. That moves nothing by more than 2^-28 of a cell or, where cells are so
 * small that doubles of that size do not have that, by what they have. A place within a millimetre of a sample is on
 * it, as coordinates are often written to the millimetre. */
bool cw_terrain_find_place(const terrain *t, double x, double y, double at[2]);

/* sine and cosine of degrees, exact for multiples of 90 and 45 degrees as far as numbers allow. */
void cw_terrain_sine_cosine(double degrees, double *sine, double *cosine);

#endif
