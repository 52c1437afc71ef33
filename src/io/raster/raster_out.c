/* SPDX-License-Identifier: Apache-2.0 */
/* The table of formats that results are written in; GeoTIFF is that of GDAL's module, PNG that of image_png.c. */

#include "raster_out.h"

#include "gdal/module.h"
#include "image.h"
#include "inputs.h"
#include "npy.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the formats ------------------------------------------------------------------------------------------------- */

/* Files beside a raster that programs read as part of it: statistics, smaller copies, masks, world files. Those of a
 * file that is replaced would be wrong for the new one, and are removed with it. Up to a NULL: ".ovr" is added to the
 * raster's name, "*.tfw" takes the place of its ending. */
typedef const char *const *sidecar_list;

struct io_raster_sink {
    const char *ending; /* ".tif" */
    const char *what;
    size_t bands_most; /* 0: any number */
    sidecar_list sidecars;
    /* writer->output is open; on failure nothing is left but that. NULL: nothing comes before the rows. */
    bool (*create)(io_raster_writer *writer, io_error *error);
    /* Rows from band 0, row 0 on, of a picture all at once, of GeoTIFF any windows. NULL: this build has no library. */
    bool (*write)(io_raster_writer *writer, size_t band, const io_raster_window *window, const void *cells,
                  io_error *error);
    /* Ends the file, which is whole if so it says, and frees writer->state. NULL: nothing comes after the rows. */
    bool (*finish)(io_raster_writer *writer, bool whole, io_error *error);
};

/* NumPy arrays: (rows, columns), or (bands, rows, columns). */
static bool npy_create(io_raster_writer *w, io_error *error) {
    static const char *const types[] = {"'|u1'", "'<u2'", "'<f4'", "'<i2'"};
    const io_raster_product *p = &w->product;
    const uint64_t shape[3] = {p->bands, p->ny, p->nx};
    const size_t rank = p->bands > 1 ? 3 : 2;
    return io_npy_write_header(&w->output, types[p->cell], io_cell_bytes(p->cell), rank, shape + 3 - rank, error);
}

static bool npy_write(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                      io_error *error) {
    (void)band;
    return io_output_write(&w->output, cells, window->nx * window->ny * io_cell_bytes(w->product.cell), error);
}

#ifdef CELLWALK_PNG
static bool png_write(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                      io_error *error) {
    (void)band;
    return io_png_put_bytes(&w->output, window->nx, window->ny, cells, error);
}
#else
#define png_write NULL
#endif

/* Of a GeoTIFF, by the system's reason if it was the system that failed: GDAL's own words name a function. */
static bool fail_tif(io_raster_writer *w, io_error *error) {
    return io_output_has_room(&w->beside[0], error) && io_output_has_room(&w->output, error) && false;
}

/* A COG is copied from a GeoTIFF beside it; its smaller copies are in a file that GDAL has its own name for. */
static bool tif_create(io_raster_writer *w, io_error *error) {
    const io_gdal *gdal = io_gdal_load(error);
    const bool cog = w->product.cog;
    if (gdal == NULL) return false;
    if (w->output.direct) return io_fail(error, "%s: cannot write: a GeoTIFF needs a regular file", w->output.name);
    if (cog && !(io_output_open_scratch(&w->beside[0], &w->output, ".tif", error) &&
                 io_output_open_scratch(&w->beside[1], &w->output, ".ovr.tmp", error)))
        return false;
    return gdal->create(w, io_output_temporary(cog ? &w->beside[0] : &w->output), error) || fail_tif(w, error);
}

static bool tif_write(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                      io_error *error) {
    return io_gdal_load(error)->write(w, band, window, cells, error) || fail_tif(w, error);
}

static bool tif_finish(io_raster_writer *w, bool whole, io_error *error) {
    const char *path_of_cog = whole && w->product.cog ? io_output_temporary(&w->output) : NULL;
    return io_gdal_load(error)->finish(w, path_of_cog, error) ? whole : whole && fail_tif(w, error);
}

bool io_raster_check_creation(const char *const *creation, size_t count, bool cog, io_error *error) {
    const io_gdal *gdal = io_gdal_load(error);
    return gdal != NULL && gdal->check_creation(creation, count, cog, error);
}

/* A picture's world file is the first of its list. */
static const char *const of_npy[] = {NULL}, *const of_tif[] = {".aux.xml", ".ovr", ".msk", "*.tfw", "w", NULL},
                         *const of_png[] = {"*.pgw", "w", ".aux.xml", ".ovr", ".msk", NULL};

enum { TIF, NPY, PNG, SINKS };
static const struct io_raster_sink sinks[SINKS] = {
    {".tif", "GeoTIFF", 0, of_tif, tif_create, tif_write, tif_finish},
    {".npy", "NumPy array", 0, of_npy, npy_create, npy_write, NULL},
    {".png", "picture", 1, of_png, NULL, png_write, NULL},
};

static const struct io_raster_sink *sink_of(const char *path) {
    for (int k = 0; k < SINKS; k++)
        if (io_name_ends(path, sinks[k].ending)) return &sinks[k];
    return io_name_ends(path, ".tiff") ? &sinks[TIF] : NULL;
}

bool io_raster_is_tif(const char *path) { return sink_of(path) == &sinks[TIF]; }

bool io_raster_is_name(const char *path) { return sink_of(path) != NULL || io_name_ends(path, ".asc"); }

bool io_raster_is_png(const char *path) { return sink_of(path) == &sinks[PNG]; }

bool io_raster_can_write(const char *path, size_t bands, io_error *error) {
    const struct io_raster_sink *sink = sink_of(path);
    if (sink == NULL)
        return io_fail(error, "%s: the name's ending tells no format; there are .tif (GeoTIFF), .npy (NumPy) and .png",
                       path);
    if (sink->bands_most > 0 && bands > sink->bands_most)
        return io_fail(error, "%s: a %s has no room for %zu bands; .tif and .npy have", path, sink->what, bands);
    if (sink->write == NULL) return io_fail(error, "%s: this build has no library for that format", path);
    io_error reason;
    if (sink == &sinks[TIF] && io_gdal_load(&reason) == NULL)
        return io_fail(error, "%s: GeoTIFF needs GDAL: %s; .npy and .png do without", path, reason.text);
    return true;
}

/* ---- files beside the raster ------------------------------------------------------------------------------------- */

/* False if the name is too long. */
static bool name_sidecar(char name[PATH_MAX], const char *ending, const char *path) {
    const char *slash = strrchr(path, '/'), *point = strrchr(slash ? slash : path, '.');
    const int stem = ending[0] == '*' && point != NULL ? (int)(point - path) : (int)strlen(path);
    return snprintf(name, PATH_MAX, "%.*s%s", stem, path, ending + (ending[0] == '*')) < PATH_MAX;
}

/* What becomes of a list's files that exist: where no file is replaced, one is an error, since it would be read with
 * the new raster but may be wanted; else one that is an input; after that they go, links and not their targets. */
typedef enum fate { MUST_BE_NONE, MUST_BE_NO_INPUT, GOES } fate;

static bool treat_list(sidecar_list list, const char *path, fate what, io_error *error) {
    char name[PATH_MAX];
    struct stat about;
    for (; list != NULL && *list != NULL; list++) {
        if (!name_sidecar(name, *list, path) || lstat(name, &about) != 0 || S_ISDIR(about.st_mode)) continue;
        if (what == MUST_BE_NONE)
            return io_fail(error,
                           "%s: cannot write: %s, left of another file, would be read with it; remove that first", path,
                           name);
        if (what == MUST_BE_NO_INPUT && io_inputs_have(&about))
            return io_fail(error, "%s: cannot write: %s belongs to it and is also an input", path, name);
        if (what == GOES && unlink(name) != 0 && errno != ENOENT)
            return io_fail(error, "%s: is written, but %s of the file before it cannot be removed: %s", path, name,
                           strerror(errno));
    }
    return true;
}

/* Of a picture of a placed terrain, unless it goes to a device or a pipe. */
static bool has_world(const io_raster_writer *w) {
    return w->sink == &sinks[PNG] && w->product.georef->placed && !w->output.direct;
}

/* Places a picture on its map for programs that read world files, as GIS do: x and y of a column, x and y of a row, and
 * of the upper left pixel's centre. */
static bool write_world(io_raster_writer *w, io_error *error) {
    const double(*m)[4] = w->product.map;
    char path[PATH_MAX];
    if (!name_sidecar(path, "*.pgw", w->output.target))
        return io_fail(error, "%s: the world file's name is too long", w->output.target);
    return io_output_open(&w->beside[0], path, error) &&
           io_output_print(&w->beside[0], error, "%.17g\n%.17g\n%.17g\n%.17g\n%.17g\n%.17g\n", m[0][0], m[1][0],
                           m[0][1], m[1][1], m[0][3], m[1][3]);
}

static bool is_there(const char *path) {
    struct stat about;
    return stat(path, &about) == 0;
}

/* The world file, the first of a picture's list, is replaced, so it is not checked. */
static bool check_sidecars(const io_raster_writer *w, io_error *error) {
    const sidecar_list list = w->output.direct ? NULL : w->sink->sidecars + has_world(w);
    const fate what = is_there(w->output.target) ? MUST_BE_NO_INPUT : MUST_BE_NONE;
    return treat_list(list, w->output.target, what, error) && treat_list(list, w->output.name, what, error);
}

/* ---- from the first row to the last ------------------------------------------------------------------------------ */

static void end(io_raster_writer *w) {
    for (int k = 0; k < 2; k++) io_output_discard(&w->beside[k]);
    io_output_discard(&w->output);
    *w = (io_raster_writer){0};
}

bool io_raster_create(io_raster_writer *w, const char *path, const io_raster_product *product, io_error *error) {
    *w = (io_raster_writer){.product = *product, .left = (uint64_t)product->bands * product->nx * product->ny};
    if (!io_raster_can_write(path, product->bands, error) || !io_output_open(&w->output, path, error)) return false;
    w->sink = sink_of(path);
    if (check_sidecars(w, error) && (!has_world(w) || write_world(w, error)) &&
        (w->sink->create == NULL || w->sink->create(w, error)))
        return true;
    end(w);
    return false;
}

bool io_raster_write_window(io_raster_writer *w, size_t band, const io_raster_window *window, const void *cells,
                            io_error *error) {
    if (!w->sink->write(w, band, window, cells, error)) return false;
    w->left -= (uint64_t)window->nx * window->ny;
    return true;
}

bool io_raster_write(io_raster_writer *w, const void *cells, size_t rows, io_error *error) {
    const io_raster_window window = {0, w->row, w->product.nx, rows};
    if (!io_raster_write_window(w, w->band, &window, cells, error)) return false;
    w->row += rows;
    if (w->row < w->product.ny) return true;
    w->row = 0;
    w->band++;
    return true;
}

/* The world file is renamed right after the picture, in place of the one before it, whose rights it keeps. If it cannot
 * be, the old one would put the new picture in the wrong place. */
static bool commit(io_raster_writer *w, io_error *error) {
    static const char *const world_file[] = {"*.pgw", NULL};
    char target[PATH_MAX], name[PATH_MAX]; /* beside either, programs look for sidecars */
    snprintf(target, sizeof target, "%s", w->output.target);
    snprintf(name, sizeof name, "%s", w->output.name);
    const bool world = has_world(w), replaces = !w->output.direct && is_there(target);
    const sidecar_list list = replaces ? w->sink->sidecars + world : NULL;
    if ((world && !io_output_settle(&w->beside[0], error)) || !io_output_commit(&w->output, error)) return false;
    if (!world || io_output_commit(&w->beside[0], error))
        return treat_list(list, target, GOES, error) && treat_list(list, name, GOES, error);
    treat_list(world_file, target, GOES, NULL);
    return false;
}

static bool finish(io_raster_writer *w, bool whole, io_error *error) {
    return w->sink->finish ? w->sink->finish(w, whole, error) : whole;
}

bool io_raster_commit(io_raster_writer *w, io_error *error) {
    const bool whole = w->left == 0;
    if (!whole) io_fail(error, "%s: rows are missing", w->output.name);
    const bool good = finish(w, whole, whole ? error : NULL) && commit(w, error);
    end(w);
    return good;
}

void io_raster_discard(io_raster_writer *w) {
    if (w->sink == NULL) return;
    finish(w, false, NULL);
    end(w);
}
