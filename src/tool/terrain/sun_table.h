/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk sun --at`: the sun at one place as a table. Most of it is also what the raster is made by. */
#ifndef CELLWALK_TOOL_TERRAIN_SUN_TABLE_H
#define CELLWALK_TOOL_TERRAIN_SUN_TABLE_H

#include "product.h"
#include "sun_day.h"
#include "suns.h"

static const double day = 86400; /* seconds */

typedef struct sun_table {
    const char *at;   /* NULL: not asked for */
    const char *tilt; /* degrees, or "ground"; NULL: level */
    double facing;    /* NaN: not given */
    io_place place;
    sun_day_desc desc; /* tilt and facing by sun_table_check */
    bool placed;       /* desc.place is known */
    bool ground;       /* the surface is the ground as it leans */
    const char *suns;  /* a file with their places in place of days; NULL: none */
    double curvature;
    double first; /* midnight of UTC that begins the first day */
    size_t days;
} sun_table;

/* Checks place, tilt and facing; false after a message. */
bool sun_table_check(sun_table *a, const char *name);

/* Where the sun is seen from: a place on the map, by default the middle, or as --lon-lat says if the file does not. */
bool sun_table_place(const product *p, sun_table *a, const terrain *t, const double at[2], io_error *error);

/* Prints a row for each day, or if there are more than 62 for each month, as CSV to the output or standard output; of a
 * list of suns one row. */
bool sun_table_write(product *p, sun_table *a, io_error *error);

#endif
