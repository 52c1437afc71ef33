/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight under a cloudless sky, by the model of the European Solar Radiation Atlas (ESRA): C. Rigollier, O. Bauer, L. Wald,
 * On the clear sky model of the ESRA, Solar Energy 68 (2000) 33-48. r.sun of GRASS uses the same model. */
#ifndef CELLWALK_TERRAIN_CLEAR_SKY_H
#define CELLWALK_TERRAIN_CLEAR_SKY_H

/* The solar constant that the model was fitted with, in W/m². */
#define CLEAR_SKY_CONSTANT 1367.0

/* Linke's turbidity for an air mass of 2: how many clean, dry atmospheres are as turbid. About 2 in cold, clean air, 3 on land,
 * 4 to 6 over towns or in moist air. */
#define CLEAR_SKY_LINKE 3.0

/* Air masses that light crosses on its way to the height in metres; altitude is in degrees with refraction, above 0. */
double cw_clear_sky_air_mass(double altitude, double height);

/* Direct light in W/m² on a surface that faces the sun. distance is the sun's, in astronomical units; altitude as above, 0
 * at and below the horizon. */
double cw_clear_sky_direct(double linke, double distance, double altitude, double height);

/* Diffuse light in W/m² on level ground under the whole sky; altitude is in degrees without refraction. It is 0 below the
 * horizon. The model has it the same at all heights. */
double cw_clear_sky_diffuse(double linke, double distance, double altitude);

#endif
