/* SPDX-License-Identifier: Apache-2.0 */
/* Subcommands that make a raster of one terrain: the options that they share, and how they run. */
#ifndef CELLWALK_TOOL_TERRAIN_PRODUCT_H
#define CELLWALK_TOOL_TERRAIN_PRODUCT_H

#include "pieces.h"

typedef struct product_command {
    ground_options *ground;
    void *context; /* of both functions */
    /* Checks the command line. False after a message. *bands, 1 at first: how many the raster has; 0: none is written, and all
     * samples are read. */
    bool (*check)(void *context, size_t *bands);
    bool (*make)(void *context, ground *g, io_error *error);
} product_command;

/* Runs with usage's options, at most PRODUCT_OPTIONS_MOST, then the shared ones, and the operand DEM. Returns the exit status. */
enum { PRODUCT_OPTIONS_MOST = 20 };
int product_run(const product_command *p, const options_usage *usage, int argc, char **argv);

#endif
