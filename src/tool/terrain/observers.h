/* SPDX-License-Identifier: Apache-2.0 */
/* The observers of a viewshed: places on the command line, from a file, or along a line. */
#ifndef CELLWALK_TOOL_TERRAIN_OBSERVERS_H
#define CELLWALK_TOOL_TERRAIN_OBSERVERS_H

#include "ground.h"
#include "points.h"

enum { OBSERVERS_FROM_MOST = OPTION_AGAIN_MAX, OBSERVERS_MOST = 1 << 24 };

typedef struct observer_options {
    option_again from;
    ground_place places[OBSERVERS_FROM_MOST];
    const char *file, *layer;
    double every; /* metres; 0: not given */
} observer_options;

enum { OBSERVER_OPTION_COUNT = 4 };
void observer_rows(observer_options *o, option_spec rows[OBSERVER_OPTION_COUNT]);

/* Checks the options' values; false after a message. */
bool observer_options_check(observer_options *o, const char *name);

typedef struct observer {
    double x, y, z; /* z: metres above the ground, or absolute */
    bool absolute;
    double weight;
    double along; /* metres from the line's first corner; NaN: stands at a given place */
    size_t given; /* the number of that place, or of the corner before */
} observer;

typedef struct observers {
    const observer_options *options;
    io_points points; /* of the file */
    size_t count, room;
    observer *list;
} observers;

/* Reads the file and finds all places. The ground has been described. On failure there is nothing to free. */
bool observers_find(observers *o, const observer_options *options, ground *g, io_error *error);
void observers_free(observers *o);

bool observers_have_weights(const observers *o);

/* The name that the file gives; "" if it gives none. */
const char *observers_name(const observers *o, size_t k);

/* The place, with a text for messages in the caller's memory. */
enum { OBSERVER_TEXT = 300 };
ground_place observers_place(const observers *o, size_t k, char text[OBSERVER_TEXT]);

#endif
