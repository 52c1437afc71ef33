/* SPDX-License-Identifier: Apache-2.0 */
#include "hits_file.h"

#include <string.h>

enum { RECORD = 21, AT_ONCE = 1024 };

bool hits_file_create(io_npy_writer *writer, const char *path, uint64_t rays, io_error *error) {
    static const char type[] =
        "[('t', '<f4'), ('i', '<i4'), ('j', '<i4'), ('triangle', '|u1'), ('u', '<f4'), ('v', '<f4')]";
    return io_npy_create(writer, path, type, RECORD, rays, error);
}

static void pack(const cw_hit *hit, unsigned char *record) {
    memcpy(record, &hit->t, 4);
    memcpy(record + 4, &hit->i, 4);
    memcpy(record + 8, &hit->j, 4);
    record[12] = (unsigned char)hit->triangle;
    memcpy(record + 13, &hit->u, 4);
    memcpy(record + 17, &hit->v, 4);
}

bool hits_file_write(io_npy_writer *writer, const cw_hit *hits, size_t n, io_error *error) {
    unsigned char records[AT_ONCE * RECORD];
    for (size_t done = 0; done < n;) {
        const size_t count = n - done < AT_ONCE ? n - done : AT_ONCE;
        for (size_t k = 0; k < count; k++) pack(&hits[done + k], records + k * RECORD);
        if (!io_npy_write(writer, records, count * RECORD, error)) return false;
        done += count;
    }
    return true;
}
