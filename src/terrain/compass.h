/* SPDX-License-Identifier: Apache-2.0 */
/* Headings by azimuth, kept as long as the rows that are asked about share them: on a map in degrees, a direction of the
 * compass is another one in the field's coordinates from each few rows to the next. */
#ifndef CELLWALK_TERRAIN_COMPASS_H
#define CELLWALK_TERRAIN_COMPASS_H

#include "cellwalk_expert.h"
#include "terrain.h"

enum { COMPASS_MOST = 3600 };

typedef struct compass {
    const terrain *terrain;
    size_t count;
    const double *azimuths; /* degrees */
    double reach;           /* metres: headings end there; 0: they do not */
    double curvature;       /* as cw_sight_init takes it */
    cw_heading **headings;  /* those that were asked for */
    size_t from, until;     /* rows that they are right for */
} compass;

/* Takes over nothing: azimuths must stay. reach and curvature are not negative. */
cw_status cw_compass_create(compass *c, const terrain *t, const double *azimuths, size_t count, double reach,
                            double curvature);
void cw_compass_destroy(compass *c);

/* Turns to the rectangle's first row, and sets its height to the number of rows, before end, for which headings are then right: the same
 * rows of the whole raster share headings, wherever one begins. */
void cw_compass_turn(compass *c, cw_rectangle *at, size_t end);

/* The middle of these rows, in the whole raster's. */
double cw_compass_middle(const compass *c);

/* Frees heading number k, which is made anew when it is needed again: for so many directions that they do not fit into memory. */
void cw_compass_release(compass *c, size_t k);

/* Heading number k for these rows. The tangent of an angle, times slope, is the rise that the heading knows. */
cw_status cw_compass_heading(compass *c, size_t k, cw_heading **heading, double *slope);

/* The rise, in a heading's numbers, of a ray at an altitude of so many degrees. */
float cw_compass_rise(double slope, double altitude);

/* Degrees whose tangent is x, off by less than 10^-5 degrees, by operations that are the same on every CPU. */
float cw_horizon_degrees(float x);

/* The azimuths in which shadows are looked for, in degrees: how many there are. */
enum { SUNLIGHT_STRIPS_MOST = 64 };
size_t cw_light_azimuths(const cw_light *light, double azimuths[SUNLIGHT_STRIPS_MOST]);

#endif
