/* SPDX-License-Identifier: Apache-2.0 */
/* The options of every subcommand that reads a field: facts that the file lacks, --coarser, and how rays are traced. */
#ifndef CELLWALK_TOOL_FIELD_OPTIONS_H
#define CELLWALK_TOOL_FIELD_OPTIONS_H

#include "options.h"
#include "raster_field.h"

typedef struct field_options {
    unsigned band, threads;  /* 0: the first band, one thread per CPU */
    double cellsize, zscale; /* 0: not given */
    option_again nodata;
    bool network;
    ground_coarser coarser;
    int kernel, leaf, isa; /* numbers of names; -1: not given */

    /* Of what was given. query has no pool, and no kernel if none was named: cw_run_kernel then tells which one a field
     * gets. The reading and the watch print warnings and progress. */
    cw_run query;
    io_raster_options reading;
    ground_watch watch;
    const char *name; /* of the subcommand */
    double nodata_values[OPTION_AGAIN_MAX];
} field_options;

/* How many of the options leaf, kernel, isa, threads a subcommand has, from the last on. */
typedef enum field_queries {
    FIELD_NO_QUERIES = 0,
    FIELD_THREADS = 2,
    FIELD_KERNELS = 3,
    FIELD_LEAVES = 4
} field_queries;

/* options_parse with these options behind those of usage, at most FIELD_OWN_MOST, and a check of their values. The
 * instruction set is limited from now on. */
enum { FIELD_OWN_MOST = 40 };
int field_options_parse(field_options *f, const options_usage *usage, field_queries queries, int argc, char **argv,
                        const char **operands);

#define FIELD_FILE_HELP                                                                                                \
    "FIELD is a height field: a NumPy array (.npy: two-dimensional, float32, float64, int16 or uint16), or any other " \
    "raster that GDAL reads (GeoTIFF, ASCII grid, .hgt, VRT, PGM, ...). Sample [j, i] stands at x = i, y = j in "      \
    "field space; NaN, infinity and missing data are holes.\n"

/* What --coarser gains and costs, by papers/tradeoff.md. */
#define FIELD_TRADE                                                                                                    \
    "To save time, measured on rough terrain of 4097 x 4097 samples (papers/tradeoff.md of the sources): --coarser 2 " \
    "makes rays 1.4 times as fast, with half of all distances off by at most 0.02 % (99 % by 0.6 %), --coarser 8 2.8 " \
    "times and 0.12 % (3.9 %)."

#endif
