/* SPDX-License-Identifier: Apache-2.0 */
/* The horizon at places, as a table or as JSON. */
#ifndef CELLWALK_TOOL_TERRAIN_HORIZON_AT_H
#define CELLWALK_TOOL_TERRAIN_HORIZON_AT_H

#include "ground.h"

typedef struct horizon_at {
    option_again at;                       /* texts of places, or */
    const char *file;                      /* a table of them; NULL: none */
    ground_place places[OPTION_AGAIN_MAX]; /* of at */
    const char *output;                    /* NULL: standard output */
    bool json;
    unsigned directions;
    double start, max_distance, curvature;
} horizon_at;

/* Whether places are given. */
static inline bool horizon_at_asked(const horizon_at *h) { return h->at.count > 0 || h->file != NULL; }

/* Reads the places that at names; false after a message. */
bool horizon_at_check(horizon_at *h, const char *name);

/* Writes the horizons of all places. */
bool horizon_at_write(ground *g, const horizon_at *h, io_error *error);

#endif
