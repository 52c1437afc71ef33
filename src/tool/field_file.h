/* SPDX-License-Identifier: Apache-2.0 */
/* A height field from any file that holds one. */
#ifndef CELLWALK_TOOL_FIELD_FILE_H
#define CELLWALK_TOOL_FIELD_FILE_H

#include "cellwalk.h"
#include "error.h"
#include "raster.h"

typedef struct field_file {
    cw_field *field;
    io_raster raster; /* what the field borrows its samples from, if it does */
    bool mapped;      /* the samples are pages of the file and no memory of the program's own */
} field_file;

/* On failure file needs no closing. */
bool field_file_open(field_file *file, const char *path, io_error *error);
void field_file_close(field_file *file);

#define FIELD_FILE_HELP                                                                                                \
    "FIELD is a height field: a NumPy array (.npy: two-dimensional, float32,\n"                                        \
    "float64, int16 or uint16), a binary PGM image (.pgm) or an ESRI ASCII grid\n"                                     \
    "(.asc). Sample [j, i] stands at x = i, y = j of field space; NaN, infinity and\n"                                 \
    "missing data are holes.\n"

#endif
