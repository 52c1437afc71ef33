/* SPDX-License-Identifier: Apache-2.0 */
/* Terrains for sight.c, land and observers of its rows, and the judge. */
#ifndef CELLWALK_TESTS_TERRAIN_SIGHT_CASES_H
#define CELLWALK_TESTS_TERRAIN_SIGHT_CASES_H

#include "check.h"
#include "viewshed.h"
#include "workload/random.h"

#include <math.h>

enum { GROUND_CELL = 10 };

typedef struct ground {
    terrain terrain;
    float *z;
    cw_field *field;
    sight_bounds *bounds;
} ground;

/* Height in metres at x and y in metres of the map. */
typedef double ground_height(const double *shape, double x, double y);

/* Heights by a formula on 10 m cells, x = 10 i, y = -10 j. */
void ground_make(ground *g, size_t nx, size_t ny, ground_height *height, const double *shape);
void ground_free(ground *g);

/* shape: rise eastward and northward, height in the south-west corner. */
static inline double plane(const double *shape, double x, double y) { return shape[0] * x + shape[1] * y + shape[2]; }

/* Whole heights: some samples in a plane with rises to[0], to[1] through to[2], the others far below it, a few above it and holes. */
void slope_of_whole_numbers(ground *g, size_t nx, size_t ny, random_state *r, double to[3]);

typedef struct tally {
    size_t seen, touched, hidden, high; /* high: those that need much */
} tally;

typedef struct row {
    const char *name;
    /* Case number n: makes the ground, and says where the observer is. */
    void (*make)(size_t n, ground *g, viewshed_desc *d, random_state *r);
    size_t cases;
    size_t step;    /* of the cases one in so many at least, where time is short */
    bool exact;     /* held to the judge; else each sample to its own line */
    size_t samples; /* a case; 0: all */
    tally least;    /* in full */
} row;

enum { ROWS = 12 };
extern const row sight_rows[ROWS];

/* By a look at every edge on the way, in rational numbers (sight_judge.c). Of all between the eye and a place at height z, and above over it,
 * both ends left out, 1: something is above the line, 0: something touches it, -1: neither. */
int judge_line(const sight *s, double i, double j, double z, double above);

#endif
