/* SPDX-License-Identifier: Apache-2.0 */
/* Colours of the ground for pictures: by height, or those of a picture that lies on it. */
#ifndef CELLWALK_TOOL_TERRAIN_DRAPE_H
#define CELLWALK_TOOL_TERRAIN_DRAPE_H

#include "image.h"
#include "raster.h"
#include "terrain.h"

/* Green below, brown, white above, from the lowest height to the highest. */
bool drape_heights(io_image *colours, const terrain *t, io_error *error);

/* An orthophoto with three bands or one, put where its map says, or stretched over the terrain if it has none. */
bool drape_image(io_image *colours, const char *path, const terrain *t, const io_georef *georef, io_error *error);

#endif
