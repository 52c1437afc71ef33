/* SPDX-License-Identifier: Apache-2.0 */
/* Which samples of a raster matter to a part of a product: the rectangle to read for a band of rows, or for a chunk of Dask's. */
#ifndef CELLWALK_GROUND_GROUND_PLAN_H
#define CELLWALK_GROUND_GROUND_PLAN_H

#include "reach.h"

/* What decides it. All zero: all of the raster matters. */
typedef struct ground_matters {
    double distance;      /* metres: nothing farther away; 0: no limit */
    const cw_light *suns; /* all that throws a shadow from one of these places; they must stay */
    size_t sun_count;
    bool horizons, above_level; /* all that may be a horizon, or only what is above a sample's level */
    double curvature;           /* of horizons */
} ground_matters;

typedef struct ground_plan {
    ground_matters by;
    const terrain *whole;
    cw_rectangle window;  /* of the product */
    reach_blocks blocks;  /* to be taken before parts are asked for, if the plan has any */
    reach_sunward toward; /* from the window, if there is one sun */
    reach_horizons reach;
    bool begun;
} ground_plan;

cw_status ground_plan_create(ground_plan *p, const ground_matters *by, const terrain *whole, cw_rectangle window);
void ground_plan_destroy(ground_plan *p);

/* Whether the lowest and highest samples of blocks must be known, and whether those of a block beside the window's. */
static inline bool ground_plan_has_blocks(const ground_plan *p) { return p->blocks.whole != NULL; }
bool ground_plan_wants(const ground_plan *p, cw_rectangle block);

/* The rectangle that matters to a part of the window. */
cw_status ground_plan_around(ground_plan *p, cw_rectangle part, cw_rectangle *piece);

#endif
