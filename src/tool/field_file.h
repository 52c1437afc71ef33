/* SPDX-License-Identifier: Apache-2.0 */
/* A height field from any file that holds one. */
#ifndef CELLWALK_TOOL_FIELD_FILE_H
#define CELLWALK_TOOL_FIELD_FILE_H

#include "cellwalk_expert.h"
#include "coarser.h"
#include "error.h"
#include "raster.h"

typedef struct field_file {
    cw_field *field;
    const cw_kernel *kernel; /* that the query runs on the field; its structures are built */
    io_raster raster;        /* owner of the samples if the field borrows them */
    double map[3][4];        /* field space to the file's coordinates */
} field_file;

/* Reads a field for query: nothing is built that it does not need, and on its pool. options, which may be NULL, are for rasters;
 * coarser may be NULL. On failure
 * file needs no closing. */
bool field_file_open(field_file *file, const char *path, const io_raster_options *options,
                     const coarser_options *coarser, const cw_run *query, io_error *error);
/* Builds the field of a raster that file holds already. */
bool field_file_build(field_file *file, const char *path, const cw_run *query, io_error *error);
void field_file_close(field_file *file);

#define FIELD_FILE_HELP                                                                                                \
    "FIELD is a height field: a NumPy array (.npy: two-dimensional, float32,\n"                                        \
    "float64, int16 or uint16), an ESRI ASCII grid (.asc), the only heightfield of a\n"                                \
    "scene (.pbrt), or any other raster that GDAL reads (GeoTIFF, .hgt, VRT, PGM,\n"                                   \
    "...). Sample [j, i] stands at x = i, y = j of field space;\n"                                                     \
    "NaN, infinity and missing data are holes.\n"

#endif
