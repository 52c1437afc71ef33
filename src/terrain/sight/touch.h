/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the surface blocks a line of sight at a crossing, decided exactly for the numbers that are given: the samples, the
 * eye, the target, and lowerings as cw_sight_fall rounds them. */
#ifndef CELLWALK_TERRAIN_TOUCH_H
#define CELLWALK_TERRAIN_TOUCH_H

#include "way.h"

/* How far the surface is above the line where the two cross, in exact arithmetic. */
typedef struct touch {
    bool crosses;  /* between eye and target, both left out */
    int side;      /* 1: the surface is above the line, 0: it touches, -1: below */
    double excess; /* the target would have to be that much higher to touch, rounded */
} touch;

/* c has its line, kind and n, and its place on that, which may be off by the way's slack. */
touch cw_touch_at(const crossing *c);

#endif
