/* SPDX-License-Identifier: Apache-2.0 */
/* The sky of one place, above the ground or on it: its horizon, and the sun day by day, with hills and without them. */
#ifndef CELLWALK_TERRAIN_SUN_DAY_H
#define CELLWALK_TERRAIN_SUN_DAY_H

#include "sight.h"
#include "sun.h"

/* In one direction: degrees of the compass and above the level, metres, and where on the map. All but the azimuth are
 * NaN where no terrain is. */
typedef struct place_horizon {
    double azimuth, angle, distance, at[2];
} place_horizon;

/* The eye is that of s. max_distance in metres; 0: no limit. */
place_horizon cw_place_horizon(sight *s, double azimuth, double max_distance);

typedef struct sun_day_desc {
    sun_place place;
    double step;         /* seconds between two places of the sun, which stands in the middle of each */
    double linke;        /* turbidity (sun.h) */
    unsigned sky;        /* directions of the sky-view factor for diffuse light */
    double tilt, facing; /* of what the light falls on, in degrees: 0 is level, and facing is where it leans to */
    double max_distance; /* metres, beyond which no terrain counts; 0: no limit */
} sun_day_desc;

typedef struct sun_day {
    /* Of the sun behind the hills: begin of the first lit step, end of the last, in seconds since 1970; NaN: none. */
    double rise, set;
    double hours, free_hours;   /* of direct light; free: without hills */
    double direct, free_direct; /* energy in Wh/m² of the surface */
    double diffuse, free_diffuse;
} sun_day;

/* How the ground leans at the sample next to field coordinates: tilt and facing. */
void cw_sun_day_lean(const terrain *t, const double at[2], sun_day_desc *d);

/* Shares of the sky's light on a surface that leans so, as horizon.c has it for tilted ground. */
double cw_sun_day_sky(sight *s, const sun_day_desc *d);

/* The day that begins at midnight of UTC, moved to that of the place's mean solar time. The eye is that of s. share:
 * cw_sun_day_sky. Or, unless it is NULL, all suns of a list: hours are then sums of weights, direct light is each sun's
 * weight on a surface that faces it, and rise, set and diffuse light are NaN. */
sun_day cw_sun_day(const sight *s, const sun_day_desc *d, double share, double midnight, const sun_position *suns,
                   const double *weights, size_t count);

#endif
