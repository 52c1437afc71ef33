/* SPDX-License-Identifier: Apache-2.0 */
/* What a product came to: the line at the end of a command, and what a picture needs to know of its values. */
#ifndef CELLWALK_GROUND_OUTCOME_H
#define CELLWALK_GROUND_OUTCOME_H

#include "raster_out.h"

typedef struct outcome {
    size_t samples, holes, above; /* all, without data, and above 0 */
    float low, high;
    float *kept; /* every step-th value that is a number, for quantiles */
    size_t count, room, step;
} outcome;

/* A product of so many values. */
bool outcome_begin(outcome *o, size_t values, io_error *error);
void outcome_end(outcome *o);

/* Cells of the product as floats, with NaN for no data: these themselves if they are floats, else values. */
const float *outcome_read(const io_raster_product *p, const void *cells, size_t n, float *values);
void outcome_take(outcome *o, const float *values, size_t n);
/* Only counts cells, of which no quantile is asked for: without floats, and fast. False for kinds of cells that it does not count. */
bool outcome_count(outcome *o, const io_raster_product *p, const void *cells, size_t n);

/* After the last value. NaN without any. */
double outcome_quantile(const outcome *o, double share);

/* "24.1 % of 138632 samples in sight" where cells are whole numbers, which counted names, or "0.62 to 1, median 0.93 h". */
void outcome_text(const outcome *o, const io_raster_product *p, const char *counted, char *text, size_t size);

#endif
