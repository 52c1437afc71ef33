/* SPDX-License-Identifier: Apache-2.0 */
/* Where the sun stands, and its light under a cloudless sky. */
#ifndef CELLWALK_TERRAIN_SUN_H
#define CELLWALK_TERRAIN_SUN_H

#include <stdbool.h>

/* Radius of the sun's disc in degrees, in the mean. */
#define SUN_RADIUS 0.2666

/* In degrees: azimuth from true north over east; altitude above the horizon, of the sun's centre as it is seen, that
 * is, lifted by the refraction of a standard atmosphere. */
typedef struct sun_position {
    double azimuth, altitude;
    double refraction; /* that is in the altitude */
    double radius;     /* of the disc on that day */
    double distance;   /* in astronomical units */
} sun_position;

/* Seconds since 1970-01-01 00:00 UTC (leap seconds not counted), east longitude and north latitude in degrees. Right to
 * 0.01 degrees from 1950 to 2050, refraction apart. */
sun_position cw_sun_at(double seconds, double longitude, double latitude);

/* Where a place is on earth, and how its map is turned there. */
typedef struct sun_place {
    double longitude, latitude; /* degrees */
    double turned; /* how far the map's north is turned there from the true one, toward the west, in degrees */
} sun_place;

/* The same with the azimuth on the map. */
sun_position cw_sun_at_place(double seconds, const sun_place *place);

/* "2024-06-21T12:00:00Z", or with an offset such as +02:00; seconds and the time of day may be left out. False if the
 * text is none, or names no time zone. */
bool cw_sun_parse_time(const char *text, double *seconds);

/* ---- light, by the model of the European Solar Radiation Atlas (ESRA): C. Rigollier, O. Bauer, L. Wald, On the clear
 * sky model of the ESRA, Solar Energy 68 (2000) 33-48. r.sun of GRASS uses the same model. ---- */

/* The solar constant that the model was fitted with, in W/m². */
#define CLEAR_SKY_CONSTANT 1367.0

/* Linke's turbidity for an air mass of 2: how many clean, dry atmospheres are as turbid. About 2 in cold, clean air, 3
 * on land, 4 to 6 over towns or in moist air. */
#define CLEAR_SKY_LINKE 3.0

/* Air masses that light crosses on its way to the height in metres; altitude is in degrees with refraction, above 0. */
double cw_clear_sky_air_mass(double altitude, double height);

/* Direct light in W/m² on a surface that faces the sun. distance is the sun's, in astronomical units; altitude as
 * above, 0 at and below the horizon. */
double cw_clear_sky_direct(double linke, double distance, double altitude, double height);

/* Diffuse light in W/m² on level ground under the whole sky; altitude is in degrees without refraction. It is 0 below
 * the horizon. The model has it the same at all heights. */
double cw_clear_sky_diffuse(double linke, double distance, double altitude);

#endif
