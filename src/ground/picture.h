/* SPDX-License-Identifier: Apache-2.0 */
/* A product as a picture to look at: the terrain's relief, the values above it in colours, places marked. */
#ifndef CELLWALK_GROUND_PICTURE_H
#define CELLWALK_GROUND_PICTURE_H

#include "outcome.h"
#include "terrain.h"

typedef struct picture {
    size_t nx, ny;
    float *values;        /* NaN: no data */
    float *toward, *lean; /* slope toward the light, and of the ground, squared */
    float *east, *north;  /* of a row of the terrain */
    size_t row_room;
} picture;

/* Twelve bytes a pixel. */
enum { PICTURE_PIXELS_MOST = 200000000 };
bool picture_begin(picture *p, const char *path, size_t nx, size_t ny, io_error *error);
void picture_end(picture *p);

/* The next rows of values, of every step-th of the terrain's samples from (i, j) on. */
bool picture_take(picture *p, size_t row, size_t rows, const float *values, const terrain *t, size_t i, size_t j,
                  size_t step, io_error *error);

/* Writes it to a PNG. of are its values; marks: pixels, x and y one after the other. */
bool picture_write(const picture *p, const char *path, const io_raster_product *product, const outcome *of,
                   const double *marks, size_t mark_count, io_error *error);

#endif
