/* SPDX-License-Identifier: Apache-2.0 */
/* Land and observers for sight.c. */
#ifndef CELLWALK_TESTS_TERRAIN_SIGHT_CASES_H
#define CELLWALK_TESTS_TERRAIN_SIGHT_CASES_H

#include "ground.h"
#include "viewshed.h"

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

#endif
