/* SPDX-License-Identifier: Apache-2.0 */
/* The line of sight between two places of a terrain. */
#ifndef CELLWALK_GROUND_LINE_H
#define CELLWALK_GROUND_LINE_H

#include "ground.h"
#include "place.h"
#include "profile.h"

/* Distances and heights are metres. */
typedef struct line {
    sight sight;
    double eye[3], target[3]; /* in field coordinates, heights in the samples' numbers */
    double ends[2][2];        /* on the map */
    cw_sight_answer answer;
} line;

bool line_find(line *l, const terrain *t, const io_place places[2], double curvature, io_error *error);

/* The same, and the profile unless p is NULL, of a ground of which only pieces along the line are read: those of so
 * many cells. *p is room that is used again. */
enum { LINE_PIECE = 2048 };
bool line_find_on(line *l, ground *g, const io_place places[2], double curvature, profile *p, io_error *error);

/* Of a terrain that is in memory. */
bool line_profile(const line *l, profile *p, io_error *error);

/* The worst place of a radio link: where the least share of the first Fresnel zone's radius is free below the line.
 * That radius is sqrt(w d1 d2 / (d1 + d2)) for the wavelength w and the distances to the ends (ITU-R P.526). */
typedef struct clearance {
    double share;    /* of the radius, vertical; below 0 where the line is blocked; NaN: no ground lies between */
    double distance; /* from the first place, in metres */
    double radius;   /* there */
} clearance;
/* megahertz > 0. */
void line_clearance(const line *l, double megahertz, const profile *p, clearance *c);

/* A point of the profile in metres, and on the map. */
typedef struct line_row {
    double distance, x, y, ground, line, seen, radius; /* radius: the first Fresnel zone's; NaN if megahertz is 0 */
} line_row;
line_row line_row_of(const line *l, double megahertz, const profile_point *at);

#endif
