/* SPDX-License-Identifier: Apache-2.0 */
/* What a product came to: the line at the end of a command, and a picture to look at, which is the terrain's relief,
 * the values above it in colours, and places marked. */
#ifndef CELLWALK_GROUND_OUTCOME_H
#define CELLWALK_GROUND_OUTCOME_H

#include "raster_out.h"
#include "terrain.h"

typedef struct outcome {
    size_t samples, holes, above; /* all, without data, and above 0 */
    float low, high;              /* of floats */
    float *kept;                  /* every step-th value that is a number, for quantiles */
    size_t count, room, step;
} outcome;

/* A product of so many values. */
bool outcome_begin(outcome *o, size_t values, io_error *error);
void outcome_end(outcome *o);

/* The next n cells of the product. */
void outcome_take(outcome *o, const io_raster_product *p, const void *cells, size_t n);

/* "24.1 % of 138632 samples in sight" for whole numbers (counted: "in sight"), or "0.62 to 1 h, median 0.93, …". */
void outcome_text(const outcome *o, const io_raster_product *p, const char *counted, char *text, size_t size);

typedef struct picture {
    size_t nx, ny;
    float *values;        /* NaN: no data */
    float *toward, *lean; /* slope toward the light, and of the ground, squared */
} picture;

/* Fifteen bytes a pixel, with those that are written. */
enum { PICTURE_PIXELS_MOST = 200000000 };
bool picture_begin(picture *p, const char *path, size_t nx, size_t ny, io_error *error);
void picture_end(picture *p);

/* The next rows of the product's cells, of every step-th of the terrain's samples from (i, j) on. */
bool picture_take(picture *p, const io_raster_product *product, size_t row, size_t rows, const void *cells,
                  const terrain *t, size_t i, size_t j, size_t step, io_error *error);

/* Writes it to a PNG. of are its values; marks: pixels, x and y one after the other. */
bool picture_write(const picture *p, const char *path, const io_raster_product *product, const outcome *of,
                   const double *marks, size_t mark_count, io_error *error);

#endif
