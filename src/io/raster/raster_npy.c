/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from NumPy arrays a[j, i]: float32 is mapped and not copied, unless the options say so; other types are
 * converted. */

#include "file.h"
#include "npy.h"
#include "raster.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { WINDOW_BYTES = 1 << 24 }; /* converted at a time */

static void from_int16(const void *from, size_t n, float *z) {
    const int16_t *a = from;
    for (size_t k = 0; k < n; k++) z[k] = a[k];
}

static void from_uint16(const void *from, size_t n, float *z) {
    const uint16_t *a = from;
    for (size_t k = 0; k < n; k++) z[k] = a[k];
}

static void from_float64(const void *from, size_t n, float *z) {
    const double *a = from;
    for (size_t k = 0; k < n; k++) z[k] = (float)a[k];
}

/* A finite double beyond the range of floats would silently become a hole. */
static bool check_float64(const void *from, const float *z, size_t n, size_t row, const char *path, io_error *error) {
    const double *a = from;
    for (size_t k = 0; k < n; k++)
        if (isinf(z[k]) && !isinf(a[k]))
            return io_fail(error, "%s: sample [%zu, %zu] is %g, beyond the range of float", path, row, k, a[k]);
    return true;
}

/* Rows from the mapping, or by reading into the buffer if there is one: a mapping of a file that another process cuts ends
 * this process. */
static const void *take_rows(io_npy *npy, size_t first, size_t count, void *buffer, io_error *error) {
    if (buffer == NULL) return io_npy_rows(npy, first, count, error);
    const bool good = io_file_read_at(npy->fd, npy->path, buffer, (size_t)(count * npy->row_bytes),
                                      npy->offset + first * npy->row_bytes, error);
    return good ? buffer : NULL;
}

static bool convert_into(io_npy *npy, const io_raster_options *options, io_raster *raster, size_t at_once, void *buffer,
                         io_error *error) {
    const size_t nx = raster->nx, ny = raster->ny;
    const char kind = npy->header.type[1];
    float *z = raster->memory;
    for (size_t j = 0; j < ny;) {
        if (!io_raster_progress(options, npy->path, (double)j / (double)ny, error)) return false;
        const size_t count = ny - j < at_once ? ny - j : at_once;
        const char *rows = take_rows(npy, j, count, buffer, error);
        if (rows == NULL) return false;
        for (size_t end = j + count; j < end; j++, rows += npy->row_bytes, z += nx) {
            if (kind == 'f')
                from_float64(rows, nx, z);
            else if (kind == 'i')
                from_int16(rows, nx, z);
            else
                from_uint16(rows, nx, z);
            if (kind == 'f' && !check_float64(rows, z, nx, j, npy->path, error)) return false;
        }
    }
    return true;
}

static bool convert(io_npy *npy, const io_raster_options *options, io_raster *raster, io_error *error) {
    const size_t nx = (size_t)npy->header.shape[1], ny = (size_t)npy->header.shape[0];
    if (!io_raster_allocate(npy->path, nx, ny, raster, error)) return false;
    size_t at_once = npy->row_bytes > 0 ? (size_t)(WINDOW_BYTES / npy->row_bytes) : ny;
    if (at_once == 0) at_once = 1;
    void *buffer = options->copy ? malloc((size_t)(at_once * npy->row_bytes)) : NULL;
    const bool good = options->copy && buffer == NULL ? io_fail(error, "%s: out of memory", npy->path)
                                                      : convert_into(npy, options, raster, at_once, buffer, error);
    free(buffer);
    return good;
}

/* The window's rows where they belong among all, whose memory is used only where it is written to. */
static bool copy(io_npy *npy, const io_raster_options *options, io_raster *raster, io_error *error) {
    const size_t nx = (size_t)npy->header.shape[1], ny = (size_t)npy->header.shape[0];
    const bool all = options->window.nx == 0;
    if (!io_raster_check_window(options, npy->path, nx, ny, error)) return false;
    if (all && !io_raster_allocate(npy->path, nx, ny, raster, error)) return false;
    if (!all) {
        *raster = (io_raster){.nx = nx, .ny = ny, .map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
        const size_t bytes = (size_t)(ny * npy->row_bytes);
        void *memory = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (memory == MAP_FAILED) return io_fail(error, "%s: out of memory", npy->path);
        raster->z = raster->memory = memory;
        raster->mapped_bytes = bytes;
    }
    const size_t begin = all ? 0 : options->window.j, end = all ? ny : begin + options->window.ny;
    const size_t at_once = WINDOW_BYTES / npy->row_bytes > 0 ? (size_t)(WINDOW_BYTES / npy->row_bytes) : 1;
    float *z = raster->memory;
    for (size_t j = begin; j < end; j += at_once) {
        const size_t count = end - j < at_once ? end - j : at_once;
        if (!io_raster_progress(options, npy->path, (double)(j - begin) / (double)(end - begin), error) ||
            take_rows(npy, j, count, z + j * nx, error) == NULL)
            return false;
    }
    return true;
}

/* The whole array in one window, which the raster keeps. */
static bool map(io_npy *npy, io_raster *raster, io_error *error) {
    const float *z = io_npy_rows(npy, 0, npy->header.shape[0], error);
    if (z == NULL) return false;
    size_t bytes = 0;
    void *window = io_npy_take_window(npy, &bytes);
    if (window) {
        *raster = (io_raster){.map = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .z = z};
        raster->nx = (size_t)npy->header.shape[1];
        raster->ny = (size_t)npy->header.shape[0];
        raster->memory = window;
        raster->mapped_bytes = bytes;
        return true;
    }
    /* Empty, or at odd places in the file. */
    const size_t nx = (size_t)npy->header.shape[1], ny = (size_t)npy->header.shape[0];
    if (!io_raster_allocate(npy->path, nx, ny, raster, error)) return false;
    memcpy(raster->memory, z, nx * ny * sizeof *z);
    return true;
}

static bool check(const io_npy *npy, io_error *error) {
    static const char *const types[] = {"<f4", "<f8", "<i2", "<u2"};
    if (!io_npy_expect_type(npy, types, sizeof types / sizeof types[0], error)) return false;
    char shape[128];
    io_npy_shape_text(npy, shape, sizeof shape);
    if (npy->header.rank != 2) return io_fail(error, "%s: shape %s, but a raster is (rows, columns)", npy->path, shape);
    /* If one side is empty, the other may have any length in a file of any size. */
    if (npy->header.shape[0] == 0 || npy->header.shape[1] == 0)
        return io_fail(error, "%s: shape %s holds no samples", npy->path, shape);
    return true;
}

static bool read(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    io_npy npy;
    if (!io_npy_open(&npy, path, error)) return false;
    const bool as_it_is = strcmp(npy.header.type, "<f4") == 0;
    bool good = check(&npy, error);
    if (good)
        good = !as_it_is       ? convert(&npy, options, raster, error)
               : options->copy ? copy(&npy, options, raster, error)
                               : map(&npy, raster, error);
    io_npy_close(&npy);
    if (!good) io_raster_free(raster);
    return good;
}

const io_raster_format io_raster_npy = {"NumPy array", ".npy", read};
