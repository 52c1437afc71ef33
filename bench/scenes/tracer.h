/* SPDX-License-Identifier: Apache-2.0 */
/* The six scenes, rays of theirs before a contender for each of their height fields, and how their pictures differ. */
#ifndef CELLWALK_BENCH_SCENES_TRACER_H
#define CELLWALK_BENCH_SCENES_TRACER_H

#include "peers/contender.h"
#include "peers/embree.h"
#include "scene.h"

/* "hftest" …; NULL from the count on. */
enum { SCENES = 6, SCENE_FIELDS_MAX = 16 };
const char *scene_names(size_t number);

/* folder/NAME.pbrt. NULL, with the reason in error, if it cannot be read or has more than SCENE_FIELDS_MAX fields. */
scene *scene_open(const char *folder, const char *name, io_error *error);

/* Who traces, and what that took. */
typedef struct field_tracer {
    contender on[SCENE_FIELDS_MAX];
    double cpu_seconds;
    uint64_t rays;
} field_tracer;

/* The tracer for scene_render; on has a contender for each field. */
scene_tracer field_tracer_of(field_tracer *tracer);

/* How two pictures of equal size differ. */
typedef struct picture_difference {
    size_t pixels, differ; /* in any bit */
    size_t visible;        /* where an eye could see it: by more than half a step of 8-bit linear colour */
    double rmse, worst;    /* over all colour values, of what can be shown: clamped to [0, 1] */
    size_t worst_x, worst_y;
} picture_difference;
picture_difference picture_compare(const io_image *a, const io_image *b);

#endif
