/* SPDX-License-Identifier: Apache-2.0 */
/* The horizon at places, as a table or as JSON. */
#ifndef CELLWALK_TOOL_TERRAIN_HORIZON_AT_H
#define CELLWALK_TOOL_TERRAIN_HORIZON_AT_H

#include "product.h"
#include "sight.h"

typedef struct horizon_at {
    option_again at;                       /* texts of places, or */
    const char *file;                      /* a table of them; NULL: none */
    ground_place places[OPTION_AGAIN_MAX]; /* of at */
    bool json;
} horizon_at;

/* Whether places are given. */
static inline bool horizon_at_asked(const horizon_at *h) { return h->at.count > 0 || h->file != NULL; }

/* Reads the places that at names; false after a message. */
bool horizon_at_check(horizon_at *h, const char *name);

/* Writes the horizons of all places, in the directions that desc has, to the output or standard output. */
bool horizon_at_write(product *p, const horizon_at *h, const cw_horizon *desc, io_error *error);

#endif
