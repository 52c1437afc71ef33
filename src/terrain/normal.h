/* SPDX-License-Identifier: Apache-2.0 */
/* How the ground leans at a sample: the area-weighted mean of the up to six triangles around it, as the library's Phong
 * normals have it. */
#ifndef CELLWALK_TERRAIN_NORMAL_H
#define CELLWALK_TERRAIN_NORMAL_H

#include "terrain.h"

/* Slopes of the surface at the samples of a rectangle, metres in a metre: how it rises eastward and northward; NaN where there is no
 * triangle. Metres are those of a row of the whole raster, for rows that share a heading, or if row is NaN each row's own. */
void cw_terrain_slopes(const terrain *t, cw_pool *pool, double row, cw_rectangle at, float *east, float *north);

#endif
