/* SPDX-License-Identifier: Apache-2.0 */
/* Where the sun stands. */
#ifndef CELLWALK_TERRAIN_SUN_H
#define CELLWALK_TERRAIN_SUN_H

#include <stdbool.h>

/* Radius of the sun's disc in degrees, in the mean. */
#define SUN_RADIUS 0.2666

/* In degrees: azimuth from true north over east; altitude above the horizon, of the sun's centre as it is seen, that is,
 * lifted by the refraction of a standard atmosphere. */
typedef struct sun_position {
    double azimuth, altitude;
    double refraction; /* that is in the altitude */
    double radius;     /* of the disc on that day */
    double distance;   /* in astronomical units */
} sun_position;

/* Seconds since 1970-01-01 00:00 UTC (leap seconds not counted), east longitude and north latitude in degrees. Right to 0.01
 * degrees from 1950 to 2050, refraction apart. */
sun_position cw_sun_at(double seconds, double longitude, double latitude);

/* "2024-06-21T12:00:00Z", or with an offset such as +02:00; seconds and the time of day may be left out. False if the text
 * is none, or names no time zone. */
bool cw_sun_parse_time(const char *text, double *seconds);

#endif
