/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain that is lowered by the earth's curvature around an eye, for pictures. */
#ifndef CELLWALK_TOOL_TERRAIN_CURVATURE_H
#define CELLWALK_TOOL_TERRAIN_CURVATURE_H

#include "options.h"
#include "raster.h"
#include "sight.h"

/* ground_flat_earth_row, with where the lowering begins in its help. */
option_spec curvature_around_eye_row(double *curvature);

/* Makes a copy of the raster whose samples are lowered by the sight's curvature. Its georef moves to the copy. */
bool curvature_lower(io_raster *raster, const sight *s, const char *path, io_raster *lowered, io_error *error);

#endif
