/* SPDX-License-Identifier: Apache-2.0 */
/* Headings by azimuth, kept as long as the rows that are asked about share them: on a map whose scale varies, a
 * direction of the compass is another one in the field's coordinates from each few rows to the next. And products that
 * are made of them: block by block of such rows. */
#ifndef CELLWALK_TERRAIN_COMPASS_H
#define CELLWALK_TERRAIN_COMPASS_H

#include "cellwalk_expert.h"
#include "terrain.h"

enum { COMPASS_MOST = 3600 };

typedef struct compass {
    const terrain *terrain;
    size_t count;
    double *azimuths;      /* degrees; to be filled in */
    double reach;          /* metres: headings end there; 0: they do not */
    double curvature;      /* as cw_sight_init takes it */
    cw_heading **headings; /* those that were asked for */
    size_t from, until;    /* rows of the whole raster that they are right for */
    double middle;         /* of these rows */
} compass;

/* To be destroyed also on failure. */
cw_status cw_compass_create(compass *c, const terrain *t, size_t count, double reach, double curvature);
void cw_compass_destroy(compass *c);

/* A heading for the present rows. Its rises are slope times the tangent of an angle. */
typedef struct compass_way {
    cw_heading *heading;
    double dir[2], length; /* a step of it in cells, and in metres */
    double slope;
} compass_way;
cw_status cw_compass_look(compass *c, size_t k, compass_way *way);

/* Frees heading k, which is made anew when needed again: for so many directions that they do not fit into memory. */
void cw_compass_release(compass *c, size_t k);

/* Writes the numbers of a block of rows that share headings, at.nx to a row. room: of the product's bytes a sample. */
typedef cw_status compass_fill(void *context, const cw_run *run, cw_rectangle at, void *to, void *room);

/* Fills an area that has begun, bytes to a number. */
cw_status cw_compass_make(compass *c, cw_area area, const cw_run *how, size_t bytes, size_t room, compass_fill *fill,
                          void *context, void *out, const char *name);

/* The rise, in a heading's numbers, of a ray at an altitude of so many degrees. */
float cw_compass_rise(double slope, double altitude);

/* horizon.c. Degrees whose tangent is x, off by less than 10^-5, by operations that are the same on every CPU. */
float cw_horizon_degrees(float x);

/* shadow.c. The azimuths in which shadows are looked for, in degrees: how many there are. */
enum { SUNLIGHT_STRIPS_MOST = 64 };
size_t cw_light_azimuths(const cw_light *light, double azimuths[SUNLIGHT_STRIPS_MOST]);

#endif
