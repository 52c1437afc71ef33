/* SPDX-License-Identifier: Apache-2.0 */
#include "product.h"

#include "clock.h"
#include "command.h"
#include "inputs.h"
#include "number.h"
#include "sun.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- options ----------------------------------------------------------------------------------------------------- */

enum { SHARED = 6 };

static void add_rows(product *p, option_spec *to) {
    const option_spec rows[SHARED] = {
        option_text("window", "XMIN,YMIN,XMAX,YMAX", &p->window,
                    "only the samples in that part of the map, in its coordinates; values are those of the whole "
                    "raster, of which only the parts needed are read"),
        option_text("memory", "SIZE", &p->memory,
                    "limit on memory in bytes, as 2G or 500M: what needs more is made by bands of rows, or refused "
                    "where all of it matters at once (default: three quarters of the machine's memory)"),
        option_output("FILE", &p->output,
                      "the raster to write: .tif (GeoTIFF), .npy (NumPy array) or .png (a picture over the terrain's "
                      "relief, with a world file .pgw if that has a map)"),
        option_flag("cog", &p->cog, "write a Cloud Optimized GeoTIFF: GDAL's -of COG"),
        option_several("co", "NAME=VALUE", &p->creation,
                       "a creation option for GDAL's GTiff driver, or for COG with --cog, as COMPRESS=ZSTD (default: "
                       "PackBits for bytes, else deflate, which every program reads); may be given several times"),
        option_flag("quiet", &p->quiet, "leave out the line at the end"),
    };
    memcpy(to, rows, sizeof rows);
}

static option_spec curvature_row(double *curvature, const char *help) {
    return option_range("curvature", "K", curvature, 0, 1e9, "a number from 0 to 1e9", help);
}

option_spec product_flat_earth_row(double *curvature) {
    return curvature_row(
        curvature,
        "the earth's curvature as a factor: 0 for a flat earth (default), 1 without air, 0.857 with usual refraction");
}

option_spec product_round_earth_row(double *curvature) {
    *curvature = NAN;
    return curvature_row(curvature, "the earth's curvature as a factor: 0 for a flat earth, 1 without air, 0.857 = 6/7 "
                                    "with usual refraction (default: 6/7, or 0 for a file without map and --cellsize)");
}

bool product_parse_sun(const char *name, const char *sun, const char *time, double at[2], double *seconds) {
    if ((sun == NULL) == (time == NULL)) return command_refuse(name, "give the sun's place by either --sun or --time");
    if (time)
        return cw_sun_parse_time(time, seconds) ||
               command_refuse(name, "--time takes a time with its zone, as 2024-06-21T12:00:00Z or +02:00, not '%s'",
                              time);
    if (ground_numbers(sun, at, 2, 2) == 0)
        return command_refuse(name, "--sun takes azimuth and altitude in degrees, as 225,30, not '%s'", sun);
    return fabs(at[1]) <= 90 ||
           command_refuse(name,
                          "--sun %s: the second number is the altitude, and %g degrees is none; the azimuth is first",
                          sun, at[1]);
}

bool product_parse_place(const char *name, const char *text, double height, io_place *p) {
    io_error error;
    return ground_parse_place(text, height, p, &error) || command_refuse(name, "%s", error.text);
}

static double size_of_text(const char *text) {
    static const char units[] = "KMGT";
    char *end;
    double size = number_read(text, &end);
    const char *unit = (*end & ~0x20) != 0 ? strchr(units, *end & ~0x20) : NULL; /* of a blank it is 0 */
    if (end == text || (*end != '\0' && (unit == NULL || end[1] != '\0'))) return NAN;
    for (const char *u = units; unit != NULL && u <= unit; u++) size *= 1000;
    return size;
}

/* Checks the options' values; false after a message. */
static bool resolve(product *p, size_t bands) {
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    const char *of_tif = p->cog ? "cog" : p->creation.count ? "co" : NULL;
    p->ground.bytes = pages > 0 && page > 0 ? 0.75 * (double)pages * (double)page : 4e9;
    if (p->memory) p->ground.bytes = size_of_text(p->memory);
    if (p->window && ground_numbers(p->window, p->extent, 4, 4) == 0)
        return command_refuse(p->name, "--window takes XMIN,YMIN,XMAX,YMAX, coordinates of the map, not '%s'",
                              p->window);
    if (!(p->ground.bytes > 0 && isfinite(p->ground.bytes)))
        return command_refuse(p->name, "--memory takes a number of bytes, as 2G or 500M, not '%s'", p->memory);
    if (bands > 0 && p->output == NULL) return command_refuse(p->name, "nothing to do: give -o FILE for the result");
    if (of_tif != NULL && !(bands > 0 && io_raster_is_tif(p->output)))
        return command_refuse(p->name, "--%s goes with -o FILE.tif", of_tif);
    return true;
}

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* Whether the output would take an input's place: said before any work, since the output is opened after it. */
static bool is_input(const char *output) {
    struct stat about;
    return stat(output, &about) == 0 && io_inputs_have(&about);
}

/* Of an input that is said when the table is opened. */
bool product_check_table(const char *path, const char *option, io_error *error) {
    return path == NULL || is_input(path) || !io_raster_is_name(path) ||
           io_fail(error, "%s: is a raster's name, and the result is a table; give %s FILE.csv", path, option);
}

bool product_check_output(const product *p, io_error *error) {
    return !is_input(p->output) ||
           io_fail(error, "%s: is also an input; choose another name for the output", p->output);
}

static bool open_ground(product *p, size_t bands, io_error *error) {
    ground *g = &p->ground;
    if (bands > 0 && !io_raster_can_write(p->output, bands, error)) return false;
    if ((p->cog || p->creation.count > 0) &&
        !io_raster_check_creation(p->creation.values, p->creation.count, p->cog, error))
        return false;
    if (io_inputs_note_path(g->path) && bands > 0 && is_input(p->output))
        return io_fail(error, "%s: is the terrain itself and cannot be overwritten", p->output);
    g->query = p->fields.query;
    if (cw_pool_create(p->fields.threads, &g->query.pool) != CW_OK) return io_fail(error, "%s", cw_last_error());
    g->reading = p->fields.reading;
    g->reading.north_up = true;
    g->coarser = p->fields.coarser;
    g->watch = p->fields.watch;
    if (!ground_open(g, error) || (p->window && !ground_find_window(g, p->extent, p->window, error))) return false;
    if (bands == 0) return product_check_table(p->output, "-o", error);
    return product_check_output(p, error); /* a VRT's sources, known by now */
}

static void free_ground(product *p) {
    progress_end();
    ground_close(&p->ground);
    cw_pool_destroy(p->ground.query.pool);
}

int product_open(product *p, const char *path, size_t bands) {
    io_error error;
    p->start = clock_seconds();
    p->ground.path = path;
    if (!resolve(p, bands)) return EXIT_USAGE;
    if (open_ground(p, bands, &error)) return EXIT_SUCCESS;
    free_ground(p);
    return command_fail(p->name, "%s", error.text);
}

int product_close(product *p, bool good, const io_error *error) {
    free_ground(p);
    return good ? EXIT_SUCCESS : command_fail(p->name, "%s", error->text);
}

/* ---- the result -------------------------------------------------------------------------------------------------- */

void product_note(product *p, const char *format, ...) {
    va_list arguments;
    if (p->note_count == PRODUCT_NOTES_MOST) return;
    char *text = p->note_texts[p->note_count];
    va_start(arguments, format);
    vsnprintf(text, PRODUCT_TEXT, format, arguments);
    va_end(arguments);
    p->notes[p->note_count++] = text;
}

bool product_name_band(product *p, size_t band, io_error *error, const char *format, ...) {
    const size_t count = p->raster.bands;
    va_list arguments;
    if (p->band_names == NULL) p->band_names = malloc(count * (sizeof *p->band_names + PRODUCT_TEXT));
    if (p->band_names == NULL) return io_fail(error, "out of memory");
    char *text = (char *)(p->band_names + count) + band * PRODUCT_TEXT;
    va_start(arguments, format);
    vsnprintf(text, PRODUCT_TEXT, format, arguments);
    va_end(arguments);
    p->band_names[band] = text;
    p->raster.band_names = p->band_names;
    return true;
}

void product_describe(product *p, io_cell cell, size_t bands, const char *what) {
    const ground *g = &p->ground;
    p->what = what;
    product_note(p, "TIFFTAG_SOFTWARE=cellwalk %s", CW_VERSION);
    product_note(p, "TIFFTAG_IMAGEDESCRIPTION=%s", what);
    product_note(p, "PRODUCT=%s", p->name);
    product_note(p, "SURFACE=two triangles between each four samples, split from sample (i, j) to (i + 1, j + 1)");
    p->raster = (io_raster_product){
        .nx = g->window.nx,
        .ny = g->window.ny,
        .bands = bands,
        .cell = cell,
        .map = (const double(*)[4])g->map,
        .georef = &g->about.georef,
        .has_nodata = true,
        .nodata = cell == IO_CELL_UINT8    ? 255
                  : cell == IO_CELL_UINT16 ? 65535
                                           : NAN,
        .band_names = bands == 1 ? &p->what : NULL,
        .notes = p->notes,
        .threads = cw_pool_threads(g->query.pool),
        .cog = p->cog,
        .creation = p->creation.values,
        .creation_count = p->creation.count,
    };
}

void product_tell(const product *p, double share) { progress_show(p->name, share); }

bool product_good(cw_status status, io_error *error) {
    if (status == CW_OK) return true;
    return io_fail(error, "%s", status == CW_ERROR_ARGUMENT ? cw_last_error() : cw_status_message(status));
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

static bool make(product *p, io_error *error) {
    const bool good = p->begin(p, error) && (p->raster.bands == 0 || product_write(p, error)) &&
                      (p->finish == NULL || p->finish(p, error));
    if (p->leave) p->leave(p->context);
    if (p->end) p->end(p->context);
    free(p->band_names);
    free(p->marks);
    return good;
}

int product_run(product *p, const options_usage *usage, int argc, char **argv) {
    static const char *const operands[] = {"DEM"};
    option_spec options[FIELD_OWN_MOST];
    options_usage all = *usage;
    memcpy(options, usage->options, usage->option_count * sizeof *options);
    add_rows(p, options + usage->option_count);
    all.options = options;
    all.option_count += SHARED;
    all.operands = operands;
    all.operand_least = all.operand_most = 1;
    p->name = usage->name;
    p->passes = 1;

    const char *path;
    size_t bands = 1;
    io_error error = {""};
    const int status = field_options_parse(&p->fields, &all, FIELD_THREADS, argc, argv, &path);
    if (status != OPTIONS_GO) return status;
    if (!p->check(p->context, &bands)) return EXIT_USAGE;
    const int opened = product_open(p, path, bands);
    return opened == EXIT_SUCCESS ? product_close(p, make(p, &error), &error) : opened;
}
