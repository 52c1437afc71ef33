/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench tradeoff: the gain and the error of each choice of speed against accuracy. */
#ifndef CELLWALK_BENCH_TRADEOFF_H
#define CELLWALK_BENCH_TRADEOFF_H

#include "harness/interleave.h"
#include "harness/run.h"
#include "terrain.h"
#include "workload/fields.h"

#include <jansson.h>

typedef struct tradeoff_options {
    run_options run;
    option_list parts, sides; /* numbers: of parts; of land */
    const char *out;
    unsigned count;
    double seconds;
    bool quick;
} tradeoff_options;

/* ---- land.c: fractal land, coarser land, and places on both ---- */

/* "65", "257", "1025", "4097", "8193", "16385", "32769"; NULL from there on. */
const char *tradeoff_land_name(size_t number);

typedef struct tradeoff_land {
    workload_field samples; /* of fractal land in cells, as those of bench/workload */
    cw_field *field;        /* borrows them */
} tradeoff_land;

/* *skipped: there is not enough memory for it, which has been printed. On failure nothing needs closing. */
bool tradeoff_land_open(const char *name, tradeoff_land *land, bool *skipped, io_error *error);
void tradeoff_land_close(tradeoff_land *land);

/* A field's samples in one array, to be freed. */
float *tradeoff_samples_of(const cw_field *field);

/* Metres in a cell of the full land, in all products of terrain. */
enum { TRADEOFF_CELL = 10 };

/* The field with every factor-th sample of the land, on its map in metres. */
terrain tradeoff_terrain_of(const cw_field *field, const float *z, size_t factor);

/* A raster of the coarser land's samples, between them bilinear, at sample (i, j) of the full one. */
static inline double tradeoff_between(const float *values, size_t nx, size_t ny, size_t factor, size_t i, size_t j) {
    const double x = (double)i / (double)factor, y = (double)j / (double)factor;
    const size_t a = (size_t)x < nx - 1 ? (size_t)x : nx - 2, b = (size_t)y < ny - 1 ? (size_t)y : ny - 2;
    const double u = x - (double)a, v = y - (double)b;
    const float *at = values + b * nx + a;
    return (1 - v) * ((1 - u) * (double)at[0] + u * (double)at[1]) +
           v * ((1 - u) * (double)at[nx] + u * (double)at[nx + 1]);
}

/* Errors, of which none is below 0. */
typedef struct tradeoff_spread {
    double mean, rms, median, most, worst; /* most: of 99 % */
} tradeoff_spread;
/* Sorts them. */
tradeoff_spread tradeoff_spread_of(double *errors, size_t count);
/* Members NAME_mean, _rms, _median, _99 and _worst. */
void tradeoff_set_spread(json_t *line, const char *name, const tradeoff_spread *spread);

/* ---- the parts: each appends its lines ---- */

/* resolution.c: of kind "coarser", how far surfaces are promised to lie apart, and do; of kind "rays", speed and error of rays on
 * one land, on coarser ones, and with Embree. */
bool tradeoff_resolution_run(const char *land, const tradeoff_options *o, double seconds, json_t *lines,
                             io_error *error);
/* horizons.c: of kind "horizon", nanoseconds an angle, and errors; without errors if timed alone. */
bool tradeoff_horizons_run(const char *land, bool timed_alone, const tradeoff_options *o, double seconds, json_t *lines,
                           io_error *error);
/* sky.c: of kind "sky", nanoseconds a place, and errors of the sky-view factor. */
bool tradeoff_sky_run(const char *land, const tradeoff_options *o, json_t *lines, io_error *error);
/* pictures.c: of kind "picture", seconds, and errors against many samples a pixel. */
bool tradeoff_pictures_run(const char *land, const tradeoff_options *o, json_t *lines, io_error *error);

#endif
