/* SPDX-License-Identifier: Apache-2.0 */
/* The options of every subcommand that reads a raster: facts that the file lacks. */
#ifndef CELLWALK_TOOL_RASTER_OPTIONS_H
#define CELLWALK_TOOL_RASTER_OPTIONS_H

#include "coarser.h"
#include "options.h"
#include "progress.h"
#include "raster.h"

enum { RASTER_OPTION_COUNT = 5 + COARSER_OPTION_COUNT };

typedef struct raster_options {
    unsigned band;
    double cellsize, zscale;
    option_again nodata;
    bool network;
    coarser_options coarser;
    /* Set by raster_options_resolve. */
    double nodata_values[OPTION_AGAIN_MAX];
    const char *name; /* of the subcommand */
    progress line;
} raster_options;

/* Sets *r to nothing given, and fills in the rows of a subcommand's table that set it. */
void raster_options_rows(raster_options *r, option_spec rows[RASTER_OPTION_COUNT]);

/* False, after a message, if a value is none: end with EXIT_USAGE. name is the subcommand's. The options print warnings and
 * progress, end the reading at Ctrl-C, and keep a pointer to r; progress_end(&r->line) when the file is read. */
bool raster_options_resolve(raster_options *r, const char *name, io_raster_options *options);

#endif
