/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid of highest samples that lines of sight pass over: sight.h makes it, sight.c reads it. */
#ifndef CELLWALK_TERRAIN_BOUNDS_H
#define CELLWALK_TERRAIN_BOUNDS_H

#include "sight.h"

enum { SIGHT_LEVELS_MOST = 12, SIGHT_FIRST_SHIFT = 2 };

struct sight_bounds {
    int levels;
    size_t across[SIGHT_LEVELS_MOST], down[SIGHT_LEVELS_MOST];
    /* Node (x, y) of level l, 4 << 2 l cells wide, is high[l][y * across[l] + x]; -infinity: no samples. */
    float *high[SIGHT_LEVELS_MOST];
};

#endif
