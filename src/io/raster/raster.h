/* SPDX-License-Identifier: Apache-2.0 */
/* Height rasters from files. */
#ifndef CELLWALK_IO_RASTER_H
#define CELLWALK_IO_RASTER_H

#include "georef.h"
#include "io_error.h"

#include <stddef.h>

/* Sample (i, j) is z[j * nx + i], row 0 being the file's first; missing data are NaN. map takes field space to the
 * coordinates of the file's map, and heights to the unit that georef says; it is the identity where the file has none.
 * A sample stands for its pixel's centre, so a file that gives its lower left corner has its first column half a pixel
 * to the right of that. */
typedef struct io_raster {
    size_t nx, ny;
    const float *z;
    double map[3][4];
    io_georef georef;
    float *memory; /* of the samples, freed by io_raster_free; NULL: they are another's */
    size_t rows;   /* of the whole file, of which the raster may be a window */
} io_raster;

/* Facts that the file lacks, and functions to call. All zero: none. */
typedef struct io_raster_options {
    unsigned band;        /* from 1 on; 0: the first, with a warning where there are more */
    const double *nodata; /* nodata_count values that stand for no data, beside the one that the file names */
    size_t nodata_count;
    double cellsize; /* > 0: of a file that does not say: samples are that far apart, the first row in the north */
    /* Of a file that does not say, without cellsize: samples are 1 apart and the first row is in the north, with a
     * warning; georef.placed stays false. */
    bool north_up;
    double zscale;           /* > 0: one unit of height is so many of the map's (metres, if that is in degrees) */
    io_raster_window window; /* only these samples; nx = 0: all. An error if the raster lacks some of them */
    bool no_samples;         /* size, map and georef alone: z stays NULL */
    io_warner warn;
    /* NULL, or called now and then with the share that is read. False ends the reading with the error "interrupted". */
    bool (*progress)(void *context, double share);
    void *context;
} io_raster_options;

/* Reads a NumPy array (.npy), or what GDAL reads. */
bool io_raster_read(const char *path, const io_raster_options *options, io_raster *raster, io_error *error);
void io_raster_free(io_raster *raster);

/* Warns of values that programs often write for no data, if the georef does not mark them, and of heights whose last
 * digits are lost, with decimal points in any locale. io_raster_read does it too. */
void io_raster_smell(const char *path, const io_warner *warn, const io_raster *raster);

/* Set by a program in whose process nobody else uses GDAL. */
typedef struct io_gdal_host {
    bool network; /* GDAL may use the network */
    /* Called before GDAL is loaded, which fails if it does. */
    bool (*prepare)(bool network, io_error *error);
    /* Called before and after each call of GDAL: what libraries print in between is theirs. */
    void (*hide_streams)(void), (*show_streams)(void);
} io_gdal_host;

/* By the program, before any raster is read or written; host must stay. Else, as in Python, GDAL keeps its settings. */
void io_raster_host(const io_gdal_host *host);

/* The readers. The raster is empty, with the identity for its map. They leave to the caller: no-data by the options,
 * cell size and unit of heights, and freeing the raster on failure. */
bool io_raster_read_npy(const char *path, const io_raster_options *options, io_raster *raster, io_error *error);
bool io_raster_read_gdal(const char *path, const io_raster_options *options, io_raster *raster, io_error *error);

/* For the readers: memory for the samples of a raster, of which the sides are known. */
bool io_raster_allocate(const char *path, io_raster *raster, io_error *error);

/* For the readers: makes the map begin at sample (i, j). */
static inline void io_raster_shift(io_raster *raster, size_t i, size_t j) {
    for (int k = 0; k < 2; k++) raster->map[k][3] += raster->map[k][0] * (double)i + raster->map[k][1] * (double)j;
}

/* For the readers: cuts a raster without samples to the options' window, if any. An error if it lacks some of that. */
static inline bool io_raster_cut(const io_raster_options *o, const char *path, io_raster *r, io_error *error) {
    const io_raster_window *w = &o->window;
    r->rows = r->ny;
    if (w->nx == 0) return true;
    if (w->i >= r->nx || w->nx > r->nx - w->i || w->j >= r->ny || w->ny > r->ny - w->j)
        return io_fail(error, "%s: the window of %zu x %zu samples from (%zu, %zu) on is no part of %zu x %zu samples",
                       path, w->nx, w->ny, w->i, w->j, r->nx, r->ny);
    r->nx = w->nx;
    r->ny = w->ny;
    io_raster_shift(r, w->i, w->j);
    return true;
}

/* For the readers: tells the options' progress; false, with the error, if the reading is to end. */
static inline bool io_raster_progress(const io_raster_options *o, const char *path, double share, io_error *error) {
    return o->progress == NULL || o->progress(o->context, share) || io_fail(error, "%s: interrupted", path);
}

#endif
