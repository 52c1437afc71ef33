/* SPDX-License-Identifier: Apache-2.0 */
/* The point scale of a raster's projection: how long its unit is on the ground. */
#ifndef CELLWALK_IO_SCALE_H
#define CELLWALK_IO_SCALE_H

#include "georef.h"
#include "map_scale.h"

/* Fills in the scale over nx × ny samples of a projected map. False if the map is no projected one, or its scale cannot
 * be had. Warns, by a sentence without a full stop that begins with name, where that matters: if the scale is not known,
 * and if it differs by direction or along a row by more than 1 %, which a map_scale does not have. warn may be NULL. */
bool io_scale_find(const io_georef *georef, double map[3][4], size_t nx, size_t ny, const char *name,
                   void (*warn)(void *context, const char *text), void *context, map_scale *scale);

#endif
