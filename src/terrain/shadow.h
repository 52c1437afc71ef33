/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight on every sample: whether the sun is seen, how much of its disc, and how much light falls on the ground. */
#ifndef CELLWALK_TERRAIN_SHADOW_H
#define CELLWALK_TERRAIN_SHADOW_H

#include "terrain.h"

enum { SUNLIGHT_STRIPS_MOST = 64 };

/* The azimuths in which shadows are looked for, in degrees: how many there are. */
size_t cw_light_azimuths(const cw_light *light, double azimuths[SUNLIGHT_STRIPS_MOST]);

/* Once all of the sun is lower than a free horizon at the sample's height over the sea, the sample is in the shadow,
 * though nothing of the terrain may hide the sun at the raster's rim. */

#endif
