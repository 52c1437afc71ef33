/* SPDX-License-Identifier: Apache-2.0 */
/* What a ray costs in a 3D grid and in a 2D cell walk, counted: the walks of the kernels grid3d and cell written once more,
 * in double and with counters, for the claim "2D-DDA tests fewer cells but more triangles". The kernels themselves stay
 * free of counters. That these walks are theirs is verified ray by ray: they have to end at the kernels' hits. */
#ifndef CELLWALK_BENCH_ACCURACY_COUNTS_H
#define CELLWALK_BENCH_ACCURACY_COUNTS_H

#include "accuracy/judge.h"

#include <jansson.h>

typedef struct tradeoff_counts {
    size_t rays;
    size_t
        astray; /* walks that end elsewhere than the kernel's hit, by more than rounding: none, or the counts are void */
    uint64_t voxels, voxel_triangles; /* visited; tested, each time that a voxel lists them */
    uint64_t cells;                   /* visited */
    uint64_t cell_triangles;          /* tested: two in each cell whose heights the ray meets */
} tradeoff_counts;

typedef struct tradeoff_counter tradeoff_counter;

/* The ground must stay, and have no holes. NULL if out of memory. */
tradeoff_counter *tradeoff_counter_make(const tradeoff_ground *ground);
void tradeoff_counter_free(tradeoff_counter *counter);

/* Adds n rays to *sum. hits are the closest hits that kernel cell finds. any: the walk in the 3D grid may end at the first
 * hit that it finds, wherever it lies. */
void tradeoff_count(const tradeoff_counter *counter, const cw_ray *rays, size_t n, const cw_hit *hits, bool any,
                    tradeoff_counts *sum);

/* Adds the counts to a JSON object, each over the rays. */
void tradeoff_counts_set(json_t *line, const tradeoff_counts *counts);

#endif
