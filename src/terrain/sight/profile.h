/* SPDX-License-Identifier: Apache-2.0 */
/* The terrain along a line of sight: its height where the line crosses edges between samples; straight in between. */
#ifndef CELLWALK_TERRAIN_PROFILE_H
#define CELLWALK_TERRAIN_PROFILE_H

#include "sight.h"

typedef struct profile_point {
    double share;  /* of the way from the eye */
    double ground; /* height in the samples' numbers, not lowered; NaN at a hole and outside */
    double line;   /* of the line of sight, bent up as far as the ground there is lowered */
    bool seen;     /* the ground, from the eye: it rises more steeply than all before it; rounded */
} profile_point;

typedef struct profile {
    size_t count, room;
    profile_point *points; /* by share, from the eye to the target; one if they are at the same place */
} profile;

/* Replaces *p, which is all zero at first, by the profile to (i, j), at height z in the samples' numbers. */
cw_status cw_profile_make(profile *p, const sight *s, double i, double j, double z);
void cw_profile_free(profile *p);

/* The same part by part: adds the crossings with shares from first to last, of which the parts cover 0 to 1. A part may
 * have a sight on another piece of the terrain. Then cw_profile_finish, on any of them. */
cw_status cw_profile_add(profile *p, const sight *s, double i, double j, double z, double first, double last);
void cw_profile_finish(profile *p, const sight *s, double i, double j, double z);

#endif
