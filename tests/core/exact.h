/* SPDX-License-Identifier: Apache-2.0 */
/* The tests of exact.c are rows of tables. Each puts fields and rays before kernels and leaf tests, and the exact oracle judges. */
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

/* What is expected of watertight kernels: no leak, no phantom, no wrong surface, and t, u and v as good as they have to be. Of
 * Möller-Trumbore: the same, but that rounding may let a ray slip through at an edge, and decides about triangles that the ray is all
 * but parallel to; it never hits a triangle whose plane the ray lies in. */
typedef struct exact_row exact_row;
struct exact_row {
    const char *name, *expected; /* expected: what more there is to say; NULL: not counted for papers/robustness.md */
    void (*test)(const exact_row *row);
    int number; /* what the test makes of it; how many cases */
    const exact_case *cases;
};

extern const exact_row exact_extremes[];
extern const size_t exact_extremes_count;

/* Every kernel that this machine runs with every leaf test that it takes. */
extern path exact_paths[PATHS_MAX];
extern size_t exact_path_count;

typedef enum exact_choice { EVERY_PATH, WATERTIGHT_PATHS, CELL_ALONE } exact_choice;

/* What the oracle said of cell's watertight answers, and how many other answers had the same bits. */
typedef struct exact_counts {
    size_t rays, hits, passes, verdict[VERDICTS], answers;
} exact_counts;

/* Traces n rays for the closest and for any hit, and judges all answers. The test fails at one that is not as expected. Samples may be
 * infinite. tie: whether a tie is excused; NULL: it is. Adds to counts. */
typedef bool tie_rule(const cw_ray *ray, const oracle_truth *truth);
void exact_judge(const test_field *f, const cw_ray *rays, size_t n, exact_choice paths, tie_rule *tie,
                 exact_counts *counts);

void exact_expect(const exact_case *c);
void exact_expect_all(const exact_row *row);

/* To stdout, a line of JSON for each path: what the row has counted. */
void exact_print_counts(const exact_row *row);

#endif
