/* SPDX-License-Identifier: Apache-2.0 */
/* Height rasters from files, behind one interface: a format is one file that fills in one io_raster_format. */
#ifndef CELLWALK_IO_RASTER_H
#define CELLWALK_IO_RASTER_H

#include "error.h"

#include <stddef.h>

/* Sample (i, j) is z[j * nx + i], row 0 being the file's first; missing data are NaN. map takes field space to the
 * file's own coordinates; it is the identity where the file has none. A sample stands for its pixel's centre, so a file
 * that gives its lower left corner has its first column half a pixel to the right of that. */
typedef struct io_raster {
    size_t nx, ny;
    const float *z;
    double map[3][4];
    void *memory;        /* what io_raster_free frees or unmaps */
    size_t mapped_bytes; /* > 0: memory is a file mapping of that size */
} io_raster;

typedef struct io_raster_format {
    const char *name;    /* "ESRI ASCII grid" */
    const char *endings; /* ".asc .grd" */
    /* On failure the raster needs no freeing. */
    bool (*read)(const char *path, io_raster *raster, io_error *error);
} io_raster_format;

extern const io_raster_format io_raster_npy;
extern const io_raster_format io_raster_pgm;
extern const io_raster_format io_raster_asc;

/* Reads any known format, chosen by the file name's ending. */
bool io_raster_read(const char *path, io_raster *raster, io_error *error);
void io_raster_free(io_raster *raster);

/* For the formats: memory for nx × ny samples and the identity map. The samples are raster->memory, a float array. */
bool io_raster_allocate(const char *path, size_t nx, size_t ny, io_raster *raster, io_error *error);

#endif
