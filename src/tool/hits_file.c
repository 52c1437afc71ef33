/* SPDX-License-Identifier: Apache-2.0 */
#include "hits_file.h"

#include <math.h>
#include <string.h>

enum { HIT = 21, POINT = 24, NORMAL = 12, AT_ONCE = 1024 };

bool hits_file_create(hits_file *file, const char *path, uint64_t rays, io_error *error) {
    if (file->any) return io_npy_create(&file->writer, path, "'|u1'", 1, rays, error);
    char type[256];
    snprintf(type, sizeof type,
             "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '|u1'), ('u', '<f4'), ('v', '<f4')%s%s]",
             file->points ? ", ('x', '<f8'), ('y', '<f8'), ('z', '<f8')" : "",
             file->normals ? ", ('nx', '<f4'), ('ny', '<f4'), ('nz', '<f4')" : "");
    size_t record = HIT;
    if (file->points) record += POINT;
    if (file->normals) record += NORMAL;
    return io_npy_create(&file->writer, path, type, record, rays, error);
}

static unsigned char *pack(const cw_hit *hit, unsigned char *record) {
    memcpy(record, &hit->t, 4);
    memcpy(record + 4, &hit->i, 4);
    memcpy(record + 8, &hit->j, 4);
    record[12] = (unsigned char)hit->triangle;
    memcpy(record + 13, &hit->u, 4);
    memcpy(record + 17, &hit->v, 4);
    return record + HIT;
}

static unsigned char *pack_point(const cw_field *field, const cw_hit *hit, unsigned char *record) {
    double point[3] = {NAN, NAN, NAN};
    if (hit->i >= 0) cw_hit_point(field, hit, point);
    memcpy(record, point, POINT);
    return record + POINT;
}

static unsigned char *pack_normal(const cw_field *field, const cw_hit *hit, unsigned char *record) {
    double normal[3] = {NAN, NAN, NAN};
    if (hit->i >= 0) cw_hit_normal(field, hit, normal);
    const float rounded[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
    memcpy(record, rounded, NORMAL);
    return record + NORMAL;
}

bool hits_file_write(hits_file *file, const cw_field *field, const cw_hit *hits, const uint8_t *occluded, size_t n,
                     io_error *error) {
    if (file->any) return io_npy_write(&file->writer, occluded, n, error);
    unsigned char records[AT_ONCE * (HIT + POINT + NORMAL)];
    for (size_t done = 0; done < n;) {
        const size_t count = n - done < AT_ONCE ? n - done : AT_ONCE;
        unsigned char *to = records;
        for (const cw_hit *hit = hits + done; hit < hits + done + count; hit++) {
            to = pack(hit, to);
            if (file->points) to = pack_point(field, hit, to);
            if (file->normals) to = pack_normal(field, hit, to);
        }
        if (!io_npy_write(&file->writer, records, (size_t)(to - records), error)) return false;
        done += count;
    }
    return true;
}
