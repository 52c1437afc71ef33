/* SPDX-License-Identifier: Apache-2.0 */
/* Places on the map, as text and in the field; many of them from a file or along a line; and what one of them sees, in numbers. */
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

/* A place on the map: z metres above the ground, or absolute. */
typedef struct ground_place {
    const char *text; /* as it was given */
    double x, y, z;
    bool absolute;
    double weight; /* of an observer there, in a sum of many */
} ground_place;

/* X,Y,H or X,Y,+H, X,Y,=Z, or X,Y, which is height above ground. */
bool ground_parse_place(const char *text, double height, ground_place *p, io_error *error);

/* Field coordinates, rounded to 2^-28 and to lines of samples that are as near as that, and the height in the
 * samples' numbers. An error where a height above ground has no ground, or the place is under it. *level_there is
 * the ground's height in metres, NaN where there is none, and may be NULL. */
bool ground_find_place(const terrain *t, const ground_place *p, double at[3], double *level_there, io_error *error);

enum { OBSERVERS_MOST = 1 << 24 };

/* Where they come from. */
typedef struct observers_from {
    const ground_place *places; /* or, with place_count 0, the file's points */
    size_t place_count;
    const char *file, *layer;
    double height; /* metres above ground, where the file gives none */
    bool lines;    /* a file's lines need every; else their corners are places */
    double every;  /* > 0: the places are corners of lines, and observers stand so many metres apart on them */
} observers_from;

typedef struct observer {
    double x, y, z; /* z: metres above the ground, or absolute */
    bool absolute;
    double weight;
    double along; /* metres from the line's first corner; NaN: stands at a given place */
    size_t given; /* the number of that place, or of the corner before */
} observer;

typedef struct observers {
    const observers_from *from;
    io_points points; /* of the file */
    size_t count, room;
    observer *list;
} observers;

/* Reads the file, if there is one, and finds all places; from must stay. Of g the whole terrain counts, and for a file the coordinate
 * system and the watch. On failure there is nothing to free. */
bool observers_find(observers *o, const observers_from *from, const ground *g, io_error *error);
void observers_free(observers *o);

/* The name that the file gives; "" if it gives none. */
const char *observers_name(const observers *o, size_t k);
/* Whether it gives any. */
bool observers_have_names(const observers *o);

/* The place, with a text for messages in the caller's memory. */
enum { OBSERVER_TEXT = 300 };
ground_place observers_place(const observers *o, size_t k, char text[OBSERVER_TEXT]);

typedef struct view_sum {
    double samples, km2;             /* in sight; each with the area of a cell in its row */
    double farthest, farthest_at[2]; /* metres, and where on the map; NaN: nothing is in sight */
} view_sum;

/* Of the samples of a rectangle of the terrain that are not 0, and not 0 in within unless that is NULL, as seen from eye in field
 * coordinates. */
view_sum view_sum_of(const terrain *t, cw_rectangle at, const uint16_t *seen, const uint8_t *within,
                     const double eye[2]);

#endif
