/* SPDX-License-Identifier: Apache-2.0 */
/* One extreme after the other before every kernel and leaf test: judged, counted, and the counts kept for the table of
 * papers/robustness.md. */
#ifndef CELLWALK_TESTS_EXTREMES_JUDGE_H
#define CELLWALK_TESTS_EXTREMES_JUDGE_H

#include "paths.h"
#include "rays.h"

enum { EXTREME_RAYS = 200 }; /* most at a time */

extern path extreme_paths[PATHS_MAX];
extern size_t extreme_path_count;

/* Group set-up and tear-down. The latter writes the counts, a line of JSON for each item and path, to the file that the
 * environment variable CELLWALK_TEST_COUNTS names, if it does. */
int extremes_begin(void **state);
int extremes_end(void **state);

/* What follows counts for this item of the table. The texts are constants. */
void extreme_item(const char *item, const char *expected);

/* Every path against the exact oracle on n rays, closest and any hit; the test fails where an answer is not what is
 * expected of its leaf test (extremes.c). Samples may be infinite. Returns how many rays meet the field exactly. */
size_t extreme_judge(const test_field *f, const cw_ray *rays, size_t n);

/* One ray on a small field given by its samples, with the t that each path has to find; infinity is a miss. */
void extreme_expect(size_t nx, size_t ny, const float *z, cw_ray ray, float watertight, float moller_trumbore,
                    const char *what);

/* Every path finds the same bits for rays on field a as for same_rays on field b. except_grid leaves out the 3D grid.
 * Returns the hits. */
size_t extreme_compare(const cw_field *a, const cw_ray *rays, const cw_field *b, const cw_ray *same_rays, size_t n,
                       bool except_grid, const char *what);

/* n more answers of path p that are as expected. */
void extreme_count(size_t p, size_t n);

#endif
