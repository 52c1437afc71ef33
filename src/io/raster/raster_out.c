/* SPDX-License-Identifier: Apache-2.0 */
/* The table of formats that results are written in, and the two formats that need no library. */

#include "raster_out.h"

#include "gdal/module.h"
#include "inputs.h"
#include "npy.h"
#include "raster_sink.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

size_t io_cell_bytes(io_cell cell) { return cell == IO_CELL_UINT8 ? 1 : cell == IO_CELL_UINT16 ? 2 : 4; }

/* ---- NumPy arrays: (rows, columns), or (bands, rows, columns)
 * ----------------------------------------------------- */

static bool npy_create(io_raster_writer *w, io_error *error) {
    static const char *const types[] = {"'|u1'", "'<u2'", "'<f4'"};
    const io_raster_product *p = &w->product;
    const uint64_t shape[3] = {p->bands, p->ny, p->nx};
    const size_t rank = p->bands > 1 ? 3 : 2;
    return io_npy_write_header(&w->output, types[p->cell], io_cell_bytes(p->cell), rank, shape + 3 - rank, error);
}

static bool npy_write(io_raster_writer *w, const void *cells, size_t rows, io_error *error) {
    return io_output_write(&w->output, cells, rows * w->product.nx * io_cell_bytes(w->product.cell), error);
}

static bool npy_finish(io_raster_writer *w, bool whole, io_error *error) {
    (void)w;
    (void)error;
    return whole;
}

const io_raster_sink io_sink_npy = {".npy", "NumPy array", 0, npy_create, npy_write, npy_finish};

/* ---- GeoTIFF
 * ------------------------------------------------------------------------------------------------------ */

static bool tif_create(io_raster_writer *w, io_error *error) {
    const io_gdal *gdal = io_gdal_load(error);
    if (gdal == NULL) return false;
    struct stat about;
    const int fd = fileno(w->output.file);
    if (fstat(fd, &about) != 0 || !S_ISREG(about.st_mode))
        return io_fail(error, "%s: cannot write: a GeoTIFF needs a regular file", w->output.name);
    w->state = gdal->create(fd, w->output.name, &w->product, error);
    return w->state != NULL;
}

static bool tif_write(io_raster_writer *w, const void *cells, size_t rows, io_error *error) {
    return io_gdal_load(error)->write(w->state, w->band, w->row, rows, cells, error);
}

static bool tif_finish(io_raster_writer *w, bool whole, io_error *error) {
    return io_gdal_load(error)->finish(w->state, error) && whole;
}

const io_raster_sink io_sink_tif = {".tif", "GeoTIFF", 0, tif_create, tif_write, tif_finish};

/* ---- the table
 * ---------------------------------------------------------------------------------------------------- */

#ifndef CELLWALK_PNG
const io_raster_sink io_sink_png = {".png", "picture", 1, NULL, NULL, NULL};
#endif

static const io_raster_sink *const sinks[] = {&io_sink_tif, &io_sink_npy, &io_sink_png};
enum { SINKS = sizeof sinks / sizeof sinks[0] };

static const io_raster_sink *sink_of(const char *path) {
    const size_t length = strlen(path);
    for (int k = 0; k < SINKS; k++) {
        const size_t ending = strlen(sinks[k]->ending);
        if (length > ending && strcasecmp(path + length - ending, sinks[k]->ending) == 0) return sinks[k];
    }
    const size_t long_ending = strlen(".tiff");
    const bool tiff = length > long_ending && strcasecmp(path + length - long_ending, ".tiff") == 0;
    return tiff ? &io_sink_tif : NULL;
}

bool io_raster_is_tif(const char *path) { return sink_of(path) == &io_sink_tif; }

bool io_raster_can_write(const char *path, size_t bands, io_error *error) {
    const io_raster_sink *sink = sink_of(path);
    if (sink == NULL)
        return io_fail(error,
                       "%s: the name's ending tells no format; known are .tif (GeoTIFF), .npy (NumPy array), .png"
                       " (picture)",
                       path);
    if (sink->bands_most > 0 && bands > sink->bands_most)
        return io_fail(error, "%s: a %s has no room for %zu bands; .tif and .npy have", path, sink->what, bands);
    if (sink->create == NULL) return io_fail(error, "%s: this build has no library for that format", path);
    io_error reason;
    if (sink == &io_sink_tif && io_gdal_load(&reason) == NULL)
        return io_fail(error, "%s: GeoTIFF needs GDAL: %s; .npy and .png do without", path, reason.text);
    return true;
}

bool io_raster_create(io_raster_writer *w, const char *path, const io_raster_product *product, io_error *error) {
    *w = (io_raster_writer){.product = *product};
    if (!io_raster_can_write(path, product->bands, error) || !io_output_open(&w->output, path, error)) return false;
    w->sink = sink_of(path);
    if (w->sink->create(w, error)) return true;
    io_output_discard(&w->output);
    *w = (io_raster_writer){0};
    return false;
}

bool io_raster_write(io_raster_writer *w, const void *cells, size_t rows, io_error *error) {
    if (!w->sink->write(w, cells, rows, error)) return false;
    w->row += rows;
    if (w->row < w->product.ny) return true;
    w->row = 0;
    w->band++;
    return true;
}

/* Statistics and smaller copies that programs keep beside a GeoTIFF belong to the file that is being replaced. */
static void remove_companions(const char *target) {
    static const char *const endings[] = {".aux.xml", ".ovr", ".msk"};
    for (size_t k = 0; k < sizeof endings / sizeof endings[0]; k++) {
        char name[PATH_MAX];
        struct stat about;
        if (snprintf(name, sizeof name, "%s%s", target, endings[k]) >= (int)sizeof name) continue;
        if (lstat(name, &about) == 0 && S_ISREG(about.st_mode) && !io_inputs_have(&about)) unlink(name);
    }
}

bool io_raster_commit(io_raster_writer *w, io_error *error) {
    const bool whole = w->band == w->product.bands && w->row == 0;
    if (!whole) io_fail(error, "%s: rows are missing", w->output.name);
    char target[PATH_MAX] = "";
    if (w->sink == &io_sink_tif) snprintf(target, sizeof target, "%s", w->output.target);
    const bool good = w->sink->finish(w, whole, whole ? error : NULL) && io_output_commit(&w->output, error);
    if (good && target[0] != '\0') remove_companions(target);
    if (!good) io_output_discard(&w->output);
    *w = (io_raster_writer){0};
    return good;
}

void io_raster_discard(io_raster_writer *w) {
    if (w->sink == NULL) return;
    w->sink->finish(w, false, NULL);
    io_output_discard(&w->output);
    *w = (io_raster_writer){0};
}
