/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray costs in the 3D grid and in the 2D walk from cell to cell, for the claim "2D-DDA tests fewer cells but more
 * triangles": the kernels grid3d and cell count it themselves (src/core/count.h). */
#ifndef CELLWALK_BENCH_ACCURACY_WALKS_H
#define CELLWALK_BENCH_ACCURACY_WALKS_H

#include "accuracy/tradeoff.h"

/* Appends a line of kind "count" for each timed class of rays on each field and for each scene's own rays, at one sample a
 * pixel: voxels visited and triangles tested in them, cells visited and triangles tested there (two in each cell whose heights
 * the ray meets), each a ray. To be called where kernels count (counters_here). */
bool walks_count(const tradeoff_options *options, json_t *lines, io_error *error);

/* The same by cellwalk-bench-counting, which is started with the arguments of this run. */
bool walks_count_elsewhere(int argc, char **argv, const char *folder, json_t *lines, io_error *error);

void walks_print(const json_t *lines);

#endif
