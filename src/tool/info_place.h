/* SPDX-License-Identifier: Apache-2.0 */
/* Position, coordinate system and units of a raster, for `cellwalk info`. */
#ifndef CELLWALK_TOOL_INFO_PLACE_H
#define CELLWALK_TOOL_INFO_PLACE_H

#include "raster.h"

/* Lines with the extent, the cells and the coordinate system. */
void info_print_place(const io_raster *raster);
/* Members of a JSON object, each with a comma before it. */
void info_print_place_json(const io_raster *raster);

/* The unit of the heights, " m" or " ft" or the like; "" if it is not known. text has room for 40 characters. */
const char *info_height_unit(const io_raster *raster, char *text);

#endif
