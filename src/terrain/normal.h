/* SPDX-License-Identifier: Apache-2.0 */
/* How the ground leans at a sample: the area-weighted mean of the up to six triangles around it, as the library's Phong
 * normals have it. */
#ifndef CELLWALK_TERRAIN_NORMAL_H
#define CELLWALK_TERRAIN_NORMAL_H

#include "terrain.h"

/* Slopes of the surface at count samples of row j from one on, metres in a metre: how it rises eastward and northward; NaN where there
 * is no triangle. */
void cw_terrain_slope_row(const terrain *t, size_t j, size_t from, size_t count, float *restrict east,
                          float *restrict north);
/* With the metres of a row of the whole raster, for rows that share a heading. */
void cw_terrain_slope_row_as(const terrain *t, double row, size_t j, size_t from, size_t count, float *restrict east,
                             float *restrict north);

#endif
