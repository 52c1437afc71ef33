/* SPDX-License-Identifier: Apache-2.0 */
/* From a .pbrt file to a scene in memory. */
#ifndef CELLWALK_SCENE_PBRT_PARSE_H
#define CELLWALK_SCENE_PBRT_PARSE_H

#include "model.h"

/* Fills s, which is all zero, from the file and all that it includes. With fields_only, height fields may stand outside
 * of a world, stay in field space, and no image is read. On failure s may hold parts, which are the
 * caller's to free. */
bool pbrt_parse(const char *path, bool fields_only, scene *s, scene_warn_fn *warn, void *warn_context, io_error *error);

#endif
