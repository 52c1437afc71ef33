/* SPDX-License-Identifier: Apache-2.0 */
/* Height rasters from files, behind one interface: a format is one file that fills in one io_raster_format. */
#ifndef CELLWALK_IO_RASTER_H
#define CELLWALK_IO_RASTER_H

#include "error.h"

#include <stddef.h>

/* Sample (i, j) is z[j * nx + i]; missing data are NaN. map takes field space to the file's own coordinates. */
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
    bool (*read)(const char *path, io_raster *raster, io_error *error);
} io_raster_format;

/* Reads any known format, chosen by the file name's ending. */
bool io_raster_read(const char *path, io_raster *raster, io_error *error);
void io_raster_free(io_raster *raster);

#endif
