/* SPDX-License-Identifier: Apache-2.0 */
/* What says where the sun stands: where on earth the terrain is, or a table. */
#ifndef CELLWALK_GROUND_SUNS_H
#define CELLWALK_GROUND_SUNS_H

#include "georef.h"
#include "io_error.h"
#include "raster_field.h"
#include "sun.h"
#include "terrain.h"

/* Where a place of the map is on earth, or if xy is NULL the terrain's middle. An error if the map is not in degrees
 * and names no coordinate system; path is for messages, and so is instead: what the user can do, or NULL. */
bool sun_place_of(const terrain *t, const io_georef *georef, const double xy[2], const char *path, const char *instead,
                  sun_place *place, io_error *error);

/* Places of the sun from a table with the columns azimuth, from the map's north, altitude as it is seen, and weight (1
 * if there is none). sun_list_free is to be called after a failure, too. */
typedef struct sun_list {
    size_t count;
    sun_position *suns;
    double *weights;
} sun_list;

bool sun_list_read(const char *path, const ground_watch *watch, sun_list *list, io_error *error);
void sun_list_free(sun_list *list);

#endif
