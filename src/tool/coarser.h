/* SPDX-License-Identifier: Apache-2.0 */
/* --coarser: a field of every N-th sample instead of the one that was read, with how far it lies from that. */
#ifndef CELLWALK_TOOL_COARSER_H
#define CELLWALK_TOOL_COARSER_H

#include "cellwalk_expert.h"
#include "error.h"
#include "options.h"
#include "progress.h"
#include "raster.h"

enum { COARSER_OPTION_COUNT = 2 };

typedef struct coarser_options {
    unsigned factor;  /* 0: not given */
    int filter;       /* CW_FILTER_… */
    const char *name; /* of the subcommand, for the line on standard error that tells the difference; NULL: no line */
} coarser_options;

/* Sets *c to nothing given, and fills in the rows of a subcommand's table that set it. */
void coarser_rows(coarser_options *c, option_spec rows[COARSER_OPTION_COUNT]);

/* Replaces the field by a coarser one, on the query's pool and under its watch, whose line ends before anything is
 * printed. Replaces the raster's samples and map too, if it has samples. */
bool coarser_make(const coarser_options *c, const char *path, const cw_run *query, progress *line, cw_field **field,
                  io_raster *raster, io_error *error);

#endif
