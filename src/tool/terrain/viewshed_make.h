/* SPDX-License-Identifier: Apache-2.0 */
/* The raster of `cellwalk viewshed`, observer after observer. */
#ifndef CELLWALK_TOOL_TERRAIN_VIEWSHED_MAKE_H
#define CELLWALK_TOOL_TERRAIN_VIEWSHED_MAKE_H

#include "output.h"
#include "place.h"
#include "product.h"
#include "sight.h"

typedef enum view_kind {
    VIEW_SEEN,   /* whether, or how many observers see the sample */
    VIEW_WEIGHT, /* the sum of their weights */
    VIEW_ANGLE,  /* at which angle above the eye's horizontal */
    VIEW_NEEDED  /* from which height above ground on a target is seen */
} view_kind;

typedef struct viewshed_command {
    product product;
    option_again from_texts;
    io_place places[OPTION_AGAIN_MAX];
    observers_from from;
    cw_observer look;               /* all but the place; curvature is NaN if it was not given */
    const char *azimuth, *vertical; /* as texts; NULL: not given */
    view_kind kind;                 /* counts that two bytes do not hold are sums */
    bool weights, angle, needed;
    bool bands;         /* one for each observer */
    const char *table;  /* a file with a line for each observer; NULL: none */
    const char *within; /* of polygons, inside of which samples count in the table; NULL: all do */
    bool skip;          /* observers without ground, in place of an error */

    /* The work. */
    io_points observers;
    sight_bounds *bounds;
    uint16_t *seen; /* one of these */
    double *sums;
    float *numbers;
    size_t skipped;
    size_t observer; /* whose view is being computed */
    size_t made;     /* of bands: the views so far */
    uint16_t *own;   /* what one observer sees; NULL: there is no table */
    uint8_t *inside; /* not 0 where samples count in the table; NULL: they all do */
    io_output table_file;
} viewshed_command;

bool viewshed_begin(product *p, io_error *error);
bool viewshed_fill(product *p, const product_block *block, void *cells, io_error *error);
bool viewshed_finish(product *p, io_error *error);
void viewshed_end(void *context);

#endif
