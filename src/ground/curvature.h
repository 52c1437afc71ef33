/* SPDX-License-Identifier: Apache-2.0 */
/* Terrain that is lowered by the earth's curvature around an eye, for pictures. */
#ifndef CELLWALK_GROUND_CURVATURE_H
#define CELLWALK_GROUND_CURVATURE_H

#include "raster.h"
#include "sight.h"

/* Makes a copy of the raster whose samples are lowered by the sight's curvature. Its georef moves to the copy. */
bool curvature_lower(io_raster *raster, const sight *s, const char *path, io_raster *lowered, io_error *error);

#endif
