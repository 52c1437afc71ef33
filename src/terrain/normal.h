/* SPDX-License-Identifier: Apache-2.0 */
/* How the ground leans at a sample: the area-weighted mean of the up to six triangles around it, as the library's Phong
 * normals have it. */
#ifndef CELLWALK_TERRAIN_NORMAL_H
#define CELLWALK_TERRAIN_NORMAL_H

#include "terrain.h"

/* Rise of the surface in a cell along i and j, in the samples' numbers, at count samples of row j from one on; NaN where there is no
 * triangle. */
void cw_terrain_lean_row(const terrain *t, size_t j, size_t from, size_t count, float *restrict x, float *restrict y);

/* Slopes of the surface there, metres in a metre: how it rises eastward and northward. */
void cw_terrain_slope_row(const terrain *t, size_t j, size_t from, size_t count, float *restrict east,
                          float *restrict north);

#endif
