/* SPDX-License-Identifier: Apache-2.0 */
/* What the modes do to the six scenes' pictures, and what their rays cost in both walks. */
#ifndef CELLWALK_BENCH_ACCURACY_SCENES_H
#define CELLWALK_BENCH_ACCURACY_SCENES_H

#include "accuracy/tradeoff.h"
#include "image.h"

/* Differences of what can be shown, values clamped to [0, 1]. */
typedef struct tradeoff_picture {
    double rmse, worst; /* over all colour values */
    size_t differ;      /* pixels with any difference */
    size_t visible;     /* pixels that differ by more than half a step of 8-bit linear colour */
    size_t worst_x, worst_y;
} tradeoff_picture;

/* Of pictures of equal size. */
tradeoff_picture tradeoff_compare(const io_image *a, const io_image *b);

/* Adds a line of kind "picture" a mode, and one of kind "count". */
bool tradeoff_scene_run(const char *name, const char *file, const tradeoff_options *options, json_t *lines,
                        io_error *error);

#endif
