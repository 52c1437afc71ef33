/* SPDX-License-Identifier: Apache-2.0 */
/* A height field of a raster's samples, all of them or every N-th. */
#ifndef CELLWALK_GROUND_RASTER_FIELD_H
#define CELLWALK_GROUND_RASTER_FIELD_H

#include "cellwalk_expert.h"
#include "raster.h"

/* The caller's side of long work. */
typedef struct ground_watch {
    bool (*tell)(void *context, const char *step, double share); /* or NULL; false: end the work */
    io_warner warn;
    void (*note)(void *context, const char *text); /* what a coarser field loses; NULL: nobody asks */
    void *context;
} ground_watch;

/* A field of every factor-th sample instead; 0: the full one. */
typedef struct ground_coarser {
    unsigned factor;
    int filter; /* CW_FILTER_… */
} ground_coarser;

typedef struct raster_field {
    cw_field *field;
    io_raster raster; /* owner of the samples if the field borrows them */
} raster_field;

/* Reads a raster and builds its field for query: nothing that this does not need, and on its pool. On failure there is
 * nothing to close. */
bool raster_field_open(raster_field *f, const char *path, const io_raster_options *options,
                       const ground_coarser *coarser, const cw_run *query, const ground_watch *watch, io_error *error);

/* Builds the field of a raster that f holds already. */
bool raster_field_build(raster_field *f, const char *path, const cw_run *query, const ground_watch *watch,
                        io_error *error);

void raster_field_close(raster_field *f);

#endif
