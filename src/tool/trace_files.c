/* SPDX-License-Identifier: Apache-2.0 */
#include "trace_files.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- rays --------------------------------------------------------------------------------------------------------- */

_Static_assert(sizeof(cw_ray) == 8 * sizeof(float), "a row of eight floats is a ray");
_Static_assert(sizeof(cw_user_ray) == 8 * sizeof(double), "a row of eight doubles is a ray in user space");

bool ray_source_open(ray_source *s, const char *path, bool user, io_error *error) {
    static const char *const float32[] = {"<f4"}, *const float64[] = {"<f8"};
    *s = (ray_source){.npy = {.fd = -1}, .user = user, .none_meets = true};
    if (!io_npy_open(&s->npy, strcmp(path, "-") == 0 ? "/dev/stdin" : path, error)) return false;
    if (!io_npy_expect_type(&s->npy, user ? float64 : float32, 1, error)) return false;
    const io_npy_header *h = &s->npy.header;
    char shape[128];
    io_npy_shape_text(&s->npy, shape, sizeof shape);
    if (h->rank != 2 || h->shape[1] != 8)
        return io_fail(error, "%s: shape %s, but rays are (N, 8): org x y z, tmin, dir x y z, tmax", s->npy.path,
                       shape);
    s->count = h->shape[0];
    return true;
}

void ray_source_close(ray_source *s) { io_npy_close(&s->npy); }

/* Whether the ray enters the bounds, widened by the error of rounding. */
static bool meets(const cw_ray *r, const double low[3], const double high[3]) {
    double from = (double)r->tmin, to = (double)r->tmax;
    for (int k = 0; k < 3; k++) {
        const double org = (double)r->org[k], dir = (double)r->dir[k], room = 1e-6 * (1 + fabs(org) + fabs(high[k]));
        if (dir == 0) {
            if (!(org >= low[k] - room && org <= high[k] + room)) return false;
            continue;
        }
        const double a = (low[k] - room - org) / dir, b = (high[k] + room - org) / dir;
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return from <= to;
}

static void look_for_one(ray_source *s, const cw_field *field, const void *rows, size_t n) {
    const cw_field_info f = cw_field_describe(field);
    const double low[3] = {0, 0, (double)f.low}, high[3] = {(double)(f.nx - 1), (double)(f.ny - 1), (double)f.high};
    for (size_t k = 0; k < n && s->none_meets; k++) {
        cw_ray moved;
        const cw_ray *ray = s->user ? &moved : (const cw_ray *)rows + k;
        if (s->user) cw_rays_to_field(field, NULL, (const cw_user_ray *)rows + k, 1, &moved);
        s->none_meets = !meets(ray, low, high);
    }
}

const void *ray_source_rows(ray_source *s, const cw_field *field, uint64_t first, size_t n, io_error *error) {
    const void *rows = io_npy_rows(&s->npy, first, n, error);
    if (rows == NULL) return NULL;
    if (s->none_meets) look_for_one(s, field, rows, n);
    return rows;
}

/* ---- hits --------------------------------------------------------------------------------------------------------- */

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
static struct {
    double point[AT_ONCE][3], normal[AT_ONCE][3];
    unsigned char records[AT_ONCE * (HIT + POINT + NORMAL)];
} extras;

static bool write_with_extras(hits_file *file, const cw_field *field, const cw_run *run, const cw_hit *hits, size_t n,
                              io_error *error) {
    unsigned char *to = extras.records;
    cw_status status = CW_OK;
    if (file->points) status = cw_hit_points(field, run, hits, n, extras.point[0]);
    if (status == CW_OK && file->normals) status = cw_hit_normals(field, run, hits, n, extras.normal[0]);
    if (status != CW_OK) return io_fail(error, "%s", cw_last_error());
    for (size_t k = 0; k < n; k++) {
        const double *normal = extras.normal[k];
        const float rounded[3] = {(float)normal[0], (float)normal[1], (float)normal[2]};
        memcpy(to, &hits[k], HIT);
        to += HIT;
        if (file->points) memcpy(to, extras.point[k], POINT);
        to += file->points ? POINT : 0;
        if (file->normals) memcpy(to, rounded, NORMAL);
        to += file->normals ? NORMAL : 0;
    }
    return io_npy_write(&file->writer, extras.records, (size_t)(to - extras.records), error);
}

bool hits_file_write(hits_file *file, const cw_field *field, const cw_run *run, const cw_hit *hits,
                     const uint8_t *occluded, size_t n, io_error *error) {
    if (file->any) return io_npy_write(&file->writer, occluded, n, error);
    if (!file->points && !file->normals) return io_npy_write(&file->writer, hits, n * HIT, error);
    bool good = true;
    for (size_t done = 0; done < n && good; done += AT_ONCE)
        good = write_with_extras(file, field, run, hits + done, n - done < AT_ONCE ? n - done : AT_ONCE, error);
    return good;
}
