/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of exact.c are rows of tables. Each runs kernels and leaf tests on fields and rays; the oracle judges. */
#ifndef CELLWALK_TESTS_EXACT_ANSWERS_H
#define CELLWALK_TESTS_EXACT_ANSWERS_H

#include "oracle.h"
#include "paths.h"
#include "rays.h"

/* One ray on a small field given by its samples, with the t that each path has to find; infinity is a miss. */
typedef struct exact_case {
    const char *what;
    size_t nx, ny;
    const float *z;
    cw_ray ray;
    float watertight, moller_trumbore;
} exact_case;

/* What is expected of watertight kernels: no leak, no phantom, no wrong surface, and t, u and v as good as they have to
 * be. Of Möller-Trumbore: the same, but that rounding may let a ray slip through at an edge, and decides about
 * triangles that the ray is all but parallel to; it never hits a triangle whose plane the ray lies in. */
typedef struct exact_row exact_row;
struct exact_row {
    const char *name, *expected; /* expected: what more there is to say; NULL: not counted for papers/robustness.md */
    void (*test)(const exact_row *row); /* NULL: there are cases alone */
    int number;                         /* what the test makes of it */
    const exact_case *cases;
    int case_count;
};

extern const exact_row exact_extremes[];
extern const size_t exact_extremes_count;

typedef enum exact_choice { EVERY_PATH, WATERTIGHT_PATHS, CELL_ALONE } exact_choice;

/* What the oracle said of cell's watertight answers, and how many other answers had the same bits. */
typedef struct exact_counts {
    size_t rays, hits, passes, verdict[VERDICTS], answers;
} exact_counts;

/* Traces n rays for the closest and for any hit, and judges all answers. The test fails at one that is not as expected.
 * tie: whether a tie is excused; NULL: it is. Adds to counts. */
typedef bool tie_rule(const cw_ray *ray, const oracle_truth *truth);
void exact_judge(const test_field *f, const cw_ray *rays, size_t n, exact_choice paths, tie_rule *tie,
                 exact_counts *counts);

void exact_expect(const exact_case *c);

#endif
