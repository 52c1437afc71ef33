/* SPDX-License-Identifier: Apache-2.0 */
/* The options of every subcommand that reads a raster: facts that the file lacks, and --coarser. */
#ifndef CELLWALK_TOOL_RASTER_OPTIONS_H
#define CELLWALK_TOOL_RASTER_OPTIONS_H

#include "options.h"
#include "raster_field.h"

enum { RASTER_OPTION_COUNT = 7 };

typedef struct raster_options {
    unsigned band;
    double cellsize, zscale; /* 0: not given */
    option_again nodata;
    bool network;
    ground_coarser coarser;
    /* Set by raster_options_resolve. */
    double nodata_values[OPTION_AGAIN_MAX];
    const char *name; /* of the subcommand */
    ground_watch watch;
} raster_options;

/* Sets *r to nothing given, and fills in the rows of a subcommand's table that set it. */
void raster_options_rows(raster_options *r, option_spec rows[RASTER_OPTION_COUNT]);

/* False, after a message, if a value is none: end with EXIT_USAGE. name is the subcommand's. The options and r->watch print
 * warnings and progress, and keep a pointer to r. */
bool raster_options_resolve(raster_options *r, const char *name, io_raster_options *options);

/* A field from any file that holds one: a raster, or a scene (.pbrt). As raster_field_open. */
bool raster_options_open(const raster_options *r, const char *path, const io_raster_options *options,
                         const cw_run *query, raster_field *field, io_error *error);

#define FIELD_FILE_HELP                                                                                                \
    "FIELD is a height field: a NumPy array (.npy: two-dimensional, float32,\n"                                        \
    "float64, int16 or uint16), the only heightfield of a scene (.pbrt), or any other\n"                               \
    "raster that GDAL reads (GeoTIFF, ASCII grid, .hgt, VRT, PGM, ...).\n"                                             \
    "Sample [j, i] stands at x = i, y = j of field space;\n"                                                           \
    "NaN, infinity and missing data are holes.\n"

#endif
