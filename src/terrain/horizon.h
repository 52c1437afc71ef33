/* SPDX-License-Identifier: Apache-2.0 */
/* The horizon all round: how high the terrain stands against the sky in each direction, and how much of the sky is
 * left. */
#ifndef CELLWALK_TERRAIN_HORIZON_H
#define CELLWALK_TERRAIN_HORIZON_H

#include "terrain.h"

/* Degrees whose tangent is x, off by less than 10^-5 degrees, by operations that are the same on every CPU. */
float cw_horizon_degrees(float x);

#endif
