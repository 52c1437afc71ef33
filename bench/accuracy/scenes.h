/* SPDX-License-Identifier: Apache-2.0 */
/* What the modes do to the six scenes' pictures. */
#ifndef CELLWALK_BENCH_ACCURACY_SCENES_H
#define CELLWALK_BENCH_ACCURACY_SCENES_H

#include "accuracy/tradeoff.h"

/* Adds a line of kind "picture" a mode. */
bool tradeoff_scene_run(const char *name, const tradeoff_options *options, json_t *lines, io_error *error);

#endif
