/* SPDX-License-Identifier: Apache-2.0 */
#include "hits_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HIT = 24, POINT = 24, NORMAL = 12, AT_ONCE = 1 << 14 };
_Static_assert(sizeof(cw_hit) == HIT, "a hit is a record");

bool hits_file_create(hits_file *file, const char *path, uint64_t rays, io_error *error) {
    if (file->any) return io_npy_create(&file->writer, path, "'|u1'", 1, rays, error);
    char type[256];
    snprintf(type, sizeof type,
             "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '<u4'), ('u', '<f4'), ('v', '<f4')%s%s]",
             file->points ? ", ('x', '<f8'), ('y', '<f8'), ('z', '<f8')" : "",
             file->normals ? ", ('nx', '<f4'), ('ny', '<f4'), ('nz', '<f4')" : "");
    size_t record = HIT;
    if (file->points) record += POINT;
    if (file->normals) record += NORMAL;
    return io_npy_create(&file->writer, path, type, record, rays, error);
}

/* Points and normals of some hits. */
typedef struct extras {
    double point[AT_ONCE][3], normal[AT_ONCE][3];
    unsigned char records[AT_ONCE * (HIT + POINT + NORMAL)];
} extras;

static size_t pack(const hits_file *file, const cw_hit *hits, size_t n, extras *e) {
    unsigned char *to = e->records;
    for (size_t k = 0; k < n; k++) {
        memcpy(to, &hits[k], HIT);
        to += HIT;
        if (file->points) {
            memcpy(to, e->point[k], POINT);
            to += POINT;
        }
        if (file->normals) {
            const double *normal = e->normal[k];
            const float rounded[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
            memcpy(to, rounded, NORMAL);
            to += NORMAL;
        }
    }
    return (size_t)(to - e->records);
}

static bool write_with_extras(hits_file *file, const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                              extras *e, io_error *error) {
    for (size_t done = 0; done < n;) {
        const size_t count = n - done < AT_ONCE ? n - done : AT_ONCE;
        cw_status status = CW_OK;
        if (file->points) status = cw_hit_points(field, run, hits + done, count, e->point[0]);
        if (status == CW_OK && file->normals) status = cw_hit_normals(field, run, hits + done, count, e->normal[0]);
        if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
        if (!io_npy_write(&file->writer, e->records, pack(file, hits + done, count, e), error)) return false;
        done += count;
    }
    return true;
}

bool hits_file_write(hits_file *file, const cw_field *field, const cw_run *run, const cw_hit *hits,
                     const uint8_t *occluded, size_t n, io_error *error) {
    if (file->any) return io_npy_write(&file->writer, occluded, n, error);
    if (!file->points && !file->normals) return io_npy_write(&file->writer, hits, n * HIT, error);
    extras *e = malloc(sizeof *e);
    if (e == NULL) return io_fail(error, "out of memory");
    const bool good = write_with_extras(file, field, run, hits, n, e, error);
    free(e);
    return good;
}
