/* SPDX-License-Identifier: Apache-2.0 */
/* An array of rays from a file, in field space or in the coordinates of the field's map. */
#ifndef CELLWALK_TOOL_RAY_SOURCE_H
#define CELLWALK_TOOL_RAY_SOURCE_H

#include "cellwalk.h"
#include "npy.h"

typedef struct ray_source {
    io_npy npy;
    bool user; /* float64, in the map's coordinates */
    uint64_t count;
    bool none_meets; /* of all rays so far none meets the field's bounds */
} ray_source;

/* path "-" is standard input, which must be a file. On failure the source needs closing nevertheless. */
bool ray_source_open(ray_source *s, const char *path, bool user, io_error *error);
void ray_source_close(ray_source *s);

/* n rays from number first on, cw_user_ray if user, else cw_ray; valid until the next call. NULL on failure. */
const void *ray_source_rows(ray_source *s, const cw_field *field, uint64_t first, size_t n, io_error *error);

#endif
