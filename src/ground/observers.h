/* SPDX-License-Identifier: Apache-2.0 */
/* Many places: from the command line, from a file, or along a line; and what one of them sees, in numbers. */
#ifndef CELLWALK_GROUND_OBSERVERS_H
#define CELLWALK_GROUND_OBSERVERS_H

#include "ground.h"
#include "place.h"
#include "points.h"

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

/* Reads the file and finds all places; from must stay. On failure there is nothing to free. */
bool observers_find(observers *o, const observers_from *from, const ground *g, io_error *error);
/* The same without a file, for lines alone. */
bool observers_along(observers *o, const observers_from *from, const terrain *whole, io_error *error);
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
