/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from NumPy arrays a[j, i]. */

#include "npy.h"
#include "raster.h"

#include <math.h>
#include <string.h>

enum { READ_BYTES = 1 << 20 }; /* at a time, so that they are converted in the cache */

/* n elements of a row from column first on as heights. */
static bool convert(const io_npy *npy, const void *from, size_t n, size_t row, size_t first, float *z,
                    io_error *error) {
    const char *type = npy->header.type;
    if (strcmp(type, "<i2") == 0) {
        for (size_t k = 0; k < n; k++) z[k] = ((const int16_t *)from)[k];
    } else if (strcmp(type, "<u2") == 0) {
        for (size_t k = 0; k < n; k++) z[k] = ((const uint16_t *)from)[k];
    } else if (strcmp(type, "<f4") == 0) {
        memcpy(z, from, n * sizeof *z);
    } else {
        const double *a = from;
        for (size_t k = 0; k < n; k++) z[k] = (float)a[k];
        for (size_t k = 0; k < n; k++) /* a finite double would silently become a hole */
            if (isinf(z[k]) && !isinf(a[k]))
                return io_fail(error, "%s: sample [%zu, %zu] is %g, beyond the range of float", npy->path, row,
                               first + k, a[k]);
    }
    return true;
}

/* The raster's part of the array. */
static bool read_samples(io_npy *npy, const io_raster_options *o, io_raster *raster, io_error *error) {
    const size_t nx = raster->nx, ny = raster->ny, row_bytes = (size_t)npy->row_bytes, i = o->window.i, j = o->window.j;
    const size_t most = READ_BYTES / row_bytes, at_once = most > 0 ? most : 1;
    for (size_t y = 0; y < ny; y += at_once) {
        const size_t count = ny - y < at_once ? ny - y : at_once;
        if (!io_raster_progress(o, npy->path, (double)y / (double)ny, error)) return false;
        const char *rows = io_npy_rows(npy, j + y, count, error);
        if (rows == NULL) return false;
        for (size_t k = 0; k < count; k++)
            if (!convert(npy, rows + k * row_bytes + i * npy->header.item, nx, j + y + k, i,
                         raster->memory + (y + k) * nx, error))
                return false;
    }
    return true;
}

static bool check(const io_npy *npy, io_error *error) {
    static const char *const types[] = {"<f4", "<f8", "<i2", "<u2"};
    if (!io_npy_expect_type(npy, types, sizeof types / sizeof types[0], error)) return false;
    char shape[128];
    io_npy_shape_text(npy->header.rank, npy->header.shape, shape, sizeof shape);
    if (npy->header.rank != 2) return io_fail(error, "%s: shape %s, but a raster is (rows, columns)", npy->path, shape);
    /* If one side is empty, the other may have any length in a file of any size. */
    if (npy->header.shape[0] == 0 || npy->header.shape[1] == 0)
        return io_fail(error, "%s: shape %s holds no samples", npy->path, shape);
    return true;
}

static bool read_part(io_npy *npy, const io_raster_options *o, io_raster *raster, io_error *error) {
    raster->nx = (size_t)npy->header.shape[1];
    raster->ny = (size_t)npy->header.shape[0];
    return io_raster_cut(o, npy->path, raster, error) &&
           (o->no_samples || (io_raster_allocate(npy->path, raster, error) && read_samples(npy, o, raster, error)));
}

bool io_raster_read_npy(const char *path, const io_raster_options *options, io_raster *raster, io_error *error) {
    io_npy npy;
    if (options->band > 1) return io_fail(error, "%s: has one band, not %u", path, options->band);
    if (!io_npy_open(&npy, path, error)) return false;
    const bool good = check(&npy, error) && read_part(&npy, options, raster, error);
    io_npy_close(&npy);
    return good;
}
