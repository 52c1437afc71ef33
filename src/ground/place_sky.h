/* SPDX-License-Identifier: Apache-2.0 */
/* Where on earth a place is, and its sky: the sun at a time, the horizon as the place sees it, and the sun day by day, behind the hills and
 * as it would be without them. */
#ifndef CELLWALK_GROUND_PLACE_SKY_H
#define CELLWALK_GROUND_PLACE_SKY_H

#include "georef.h"
#include "io_error.h"
#include "raster_field.h"
#include "sight.h"
#include "sun.h"
#include "terrain.h"

/* Where a place is on earth. */
typedef struct sun_place {
    double longitude, latitude; /* degrees */
    double turned; /* how far the map's north is turned there from the true one, toward the west, in degrees */
} sun_place;

/* Of a place of the map, or if xy is NULL of the terrain's middle. An error if the map is not in degrees and names no coordinate system;
 * path is for messages, and so is instead: what the user can do, or NULL. */
bool sun_place_of(const terrain *t, const io_georef *georef, const double xy[2], const char *path, const char *instead,
                  sun_place *place, io_error *error);

/* Places of the sun from a table with the columns azimuth, from the map's north, altitude as it is seen, and weight (1 if there is
 * none). sun_list_free is good for what failed, too. */
typedef struct sun_list {
    size_t count;
    sun_position *suns;
    double *weights;
} sun_list;

bool sun_list_read(const char *path, const ground_watch *watch, sun_list *list, io_error *error);
void sun_list_free(sun_list *list);

/* The sun with its azimuth on the map. */
sun_position sun_place_at(const sun_place *place, double seconds);

/* In one direction: degrees of the compass and above the level, metres, and where on the map. All but the azimuth are NaN where no
 * terrain is. */
typedef struct place_horizon {
    double azimuth, angle, distance, at[2];
} place_horizon;

/* The eye is that of s. max_distance in metres; 0: no limit. */
place_horizon place_horizon_toward(sight *s, double azimuth, double max_distance);

typedef struct sun_day_desc {
    sun_place place;
    double step;         /* seconds between two places of the sun, which stands in the middle of each */
    double linke;        /* turbidity (sun.h) */
    unsigned sky;        /* directions of the sky-view factor for diffuse light */
    double tilt, facing; /* of what the light falls on, in degrees: 0 is level, and facing is where it leans to */
    double max_distance; /* metres, beyond which no terrain counts; 0: no limit */
} sun_day_desc;

typedef struct sun_day {
    /* Of the sun behind the hills: the first lit step's beginning and the last one's end, in seconds since 1970; NaN: it is never lit. */
    double rise, set;
    double hours, free_hours;   /* of direct light; free: without hills */
    double direct, free_direct; /* energy in Wh/m² of the surface */
    double diffuse, free_diffuse;
} sun_day;

/* Shares of the sky's light on a surface that leans so, as horizon.c has it for tilted ground. */
double sun_sky_share(sight *s, const sun_day_desc *d);

/* How the ground leans at the sample next to field coordinates: tilt and facing. False if memory is short. */
bool sun_ground_lean(const terrain *t, const double at[2], double *tilt, double *facing);

/* The day that begins at midnight of UTC, moved to that of the place's mean solar time. The eye is that of s. share: sun_sky_share. */
sun_day sun_day_find(const sight *s, const sun_day_desc *d, double share, double midnight);

/* All suns of a list. Hours are sums of weights, and direct light is each sun's weight on a surface that faces it. rise, set and diffuse
 * light are NaN. */
sun_day sun_day_of_list(const sight *s, const sun_day_desc *d, const sun_position *suns, const double *weights,
                        size_t count);

#endif
