/* SPDX-License-Identifier: Apache-2.0 */
/* Places on the map, as text and in the field; many from a file or along a line; and what one sees, in numbers. */
#ifndef CELLWALK_GROUND_PLACE_H
#define CELLWALK_GROUND_PLACE_H

#include "ground.h"
#include "io_error.h"
#include "points.h"
#include "terrain.h"

#include <stddef.h>

/* Numbers with commas between them: least to most of them; how many there are, or 0. */
size_t ground_numbers(const char *text, double *numbers, size_t least, size_t most);

/* The shortest decimal of a number that reads as that number. */
enum { GROUND_NUMBER = 32 };
const char *ground_number(double number, char text[GROUND_NUMBER]);

/* X,Y,H or X,Y,+H: H metres above ground. X,Y,=Z: at the height Z. X,Y: height above ground. */
bool ground_parse_place(const char *text, double height, io_place *p, io_error *error);

/* Whether one can look from a place. */
typedef enum place_state { PLACE_GOOD, PLACE_NO_GROUND, PLACE_FAR, PLACE_UNDER, PLACE_HIGH } place_state;

/* Field coordinates, rounded as by cw_terrain_find_place, and the height in the samples' numbers. A height above ground
 * has no ground outside the terrain, however far. *level_there is the ground's height in metres, NaN where there is
 * none. */
place_state ground_try_place(const terrain *t, const io_place *p, double at[3], double *level_there);

/* The same, with an error unless the place is good. level_there may be NULL. */
bool ground_find_place(const terrain *t, const io_place *p, double at[3], double *level_there, io_error *error);

/* A round of longitude, by which a file may count otherwise than the raster; 0 unless the map's x and y are angles. */
double ground_round(const terrain *t);

enum { OBSERVERS_MOST = 1 << 24 };

/* Where they come from. */
typedef struct observers_from {
    const io_place *places; /* or, with place_count 0, the file's points */
    size_t place_count;
    const char *file, *layer;
    double height; /* metres above ground, where the file gives none */
    bool lines;    /* a file's lines need every; else their corners are places */
    double every;  /* > 0: the places are corners of lines, and observers stand so many metres apart on them */
} observers_from;

/* Reads the file, if there is one, and finds all places; from must stay. Of g the whole terrain counts, and for a file
 * the coordinate system and the watch. On failure there is nothing to free. */
bool observers_find(io_points *o, const observers_from *from, const ground *g, io_error *error);

typedef struct view_sum {
    double samples, km2;             /* in sight; each with the area of a cell in its row */
    double farthest, farthest_at[2]; /* metres, and where on the map; NaN: nothing is in sight */
} view_sum;

/* Of the samples of a rectangle of the terrain that are not 0, and not 0 in within unless that is NULL, as seen from
 * eye in field coordinates. */
view_sum view_sum_of(const terrain *t, cw_rectangle at, const uint16_t *seen, const uint8_t *within,
                     const double eye[2]);

#endif
