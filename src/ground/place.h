/* SPDX-License-Identifier: Apache-2.0 */
/* Places on the map, as text and in the field. */
#ifndef CELLWALK_GROUND_PLACE_H
#define CELLWALK_GROUND_PLACE_H

#include "io_error.h"
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

#endif
