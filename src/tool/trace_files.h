/* SPDX-License-Identifier: Apache-2.0 */
/* The arrays of `cellwalk trace`: rays from a file, in field space or in the coordinates of the field's map, and hits as a NumPy array:
 * records of 24 bytes (cw_hit as it is in memory) and more, or one byte a ray. */
#ifndef CELLWALK_TOOL_TRACE_FILES_H
#define CELLWALK_TOOL_TRACE_FILES_H

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

typedef struct hits_file {
    io_npy_writer writer; /* open while hits are to come */
    bool any;             /* one byte a ray, nothing else */
    bool points, normals; /* follow in each record */
} hits_file;

/* The array as NumPy sees it has the fields t (float32), i, j (int32), triangle (uint32), u, v (float32); with points x, y, z
 * (float64), with normals nx, ny, nz (float32), both in user space and NaN for a miss. If any, it is of uint8. path "-" is
 * standard output. any, points and normals are inputs; the writer is filled in. */
bool hits_file_create(hits_file *file, const char *path, uint64_t rays, io_error *error);

/* The next n rays' hits, or occluded if any. Points and normals are computed as run says. */
bool hits_file_write(hits_file *file, const cw_field *field, const cw_run *run, const cw_hit *hits,
                     const uint8_t *occluded, size_t n, io_error *error);

#endif
