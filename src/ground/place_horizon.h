/* SPDX-License-Identifier: Apache-2.0 */
/* The horizon as one place sees it. */
#ifndef CELLWALK_GROUND_PLACE_HORIZON_H
#define CELLWALK_GROUND_PLACE_HORIZON_H

#include "sight.h"

/* In one direction: degrees of the compass and above the level, metres, and where on the map. All but the azimuth are NaN where no
 * terrain is. */
typedef struct place_horizon {
    double azimuth, angle, distance, at[2];
} place_horizon;

/* The eye is that of s. max_distance in metres; 0: no limit. */
place_horizon place_horizon_toward(sight *s, double azimuth, double max_distance);

#endif
