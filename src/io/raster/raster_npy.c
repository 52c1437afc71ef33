/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from NumPy arrays a[j, i]: float32 is mapped and not copied, other types are converted. */

#include "npy.h"
#include "raster.h"

#include <math.h>
#include <string.h>

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

static bool convert(io_npy *npy, const io_raster_options *options, io_raster *raster, io_error *error) {
    const size_t nx = (size_t)npy->header.shape[1], ny = (size_t)npy->header.shape[0];
    if (!io_raster_allocate(npy->path, nx, ny, raster, error)) return false;
    const char kind = npy->header.type[1];
    float *z = raster->memory;
    size_t at_once = npy->row_bytes > 0 ? (size_t)(WINDOW_BYTES / npy->row_bytes) : ny;
    if (at_once == 0) at_once = 1;
    for (size_t j = 0; j < ny;) {
        if (!io_raster_progress(options, npy->path, (double)j / (double)ny, error)) return false;
        const size_t count = ny - j < at_once ? ny - j : at_once;
        const char *rows = io_npy_rows(npy, j, count, error);
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
    if (good) good = as_it_is ? map(&npy, raster, error) : convert(&npy, options, raster, error);
    io_npy_close(&npy);
    if (!good) io_raster_free(raster);
    return good;
}

const io_raster_format io_raster_npy = {"NumPy array", ".npy", read};
