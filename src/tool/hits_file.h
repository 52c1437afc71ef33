/* SPDX-License-Identifier: Apache-2.0 */
/* Hits as a NumPy array: records of 24 bytes (cw_hit as it is in memory) and more, or one byte a ray. */
#ifndef CELLWALK_TOOL_HITS_FILE_H
#define CELLWALK_TOOL_HITS_FILE_H

#include "cellwalk.h"
#include "npy.h"

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
