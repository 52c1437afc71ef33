/* SPDX-License-Identifier: Apache-2.0 */
#include "ground.h"

#include "../cancel.h"
#include "clock.h"
#include "command.h"
#include "inputs.h"
#include "number.h"
#include "pieces.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *compression_names(size_t number) {
    static const char *const names[] = {"deflate", "zstd", "none"};
    return number < sizeof names / sizeof *names ? names[number] : NULL;
}

void ground_rows(ground_options *o, const char *name, option_spec rows[GROUND_OPTION_COUNT]) {
    option_spec query[QUERY_OPTION_COUNT];
    o->name = name;
    rows[0] = option_output("FILE", &o->output,
                            "the raster to write: .tif (GeoTIFF), .npy (NumPy array) or .png (a picture over the "
                            "terrain's relief, with a world file .pgw if that has a map)");
    rows[1] = option_choice("compress", "NAME", &o->compression, compression_names,
                            "lossless compression of a GeoTIFF: deflate (default), which every program reads, or zstd, "
                            "which is faster and needs a newer program");
    rows[2] = option_flag("cog", &o->cog, "write a Cloud Optimized GeoTIFF: GDAL's -of COG");
    rows[3] =
        option_several("co", "NAME=VALUE", &o->creation,
                       "a creation option for GDAL's GTiff driver, or for COG with --cog; may be given several times");
    rows[4] = option_flag("plain", &o->plain, "of a .png: grey values alone, from black to white");
    rows[5] = option_flag("quiet", &o->quiet, "leave out the line at the end");
    raster_options_rows(&o->raster, rows + 6);
    query_options_rows(&o->query, query);
    rows[6 + RASTER_OPTION_COUNT] = query[QUERY_ISA];
    rows[7 + RASTER_OPTION_COUNT] = query[QUERY_THREADS];
}

option_spec ground_flat_earth_row(double *curvature) {
    return option_number(
        "curvature", "K", curvature,
        "the earth's curvature as a factor: 0 for a flat earth (default), 1 without air, 0.857 with usual refraction");
}

/* Whether the output would take an input's place: said before any work, since the output is opened after it. */
static bool is_input(const char *output) {
    struct stat about;
    return stat(output, &about) == 0 && io_inputs_have(&about);
}

bool ground_check_output(const ground *g, io_error *error) {
    const char *output = g->options->output;
    return !is_input(output) || io_fail(error, "%s: is also an input; choose another name for the output", output);
}

void ground_find_scale(ground_scale_of_map *scale, io_raster *r, const char *path, const io_raster_options *options) {
    scale->known =
        io_scale_find(&r->georef, r->map, r->nx, r->ny, path, options->warn, options->context, &scale->nodes);
}

bool ground_describe_raster(terrain *t, const io_raster *r, const cw_field *field, const ground_scale_of_map *scale,
                            const char *path, io_error *error) {
    const terrain_desc desc = {
        .field = field,
        .nx = r->nx,
        .ny = r->ny,
        .z = r->z,
        .map = r->map,
        .geographic = r->georef.geographic,
        .unit = r->georef.unit,
        .semi_major = r->georef.semi_major,
        .inverse_flattening = r->georef.inverse_flattening,
        .scale = scale->known ? &scale->nodes : NULL,
    };
    return terrain_init(t, &desc) || io_fail(error, "%s: its map cannot be inverted", path);
}

bool ground_describe(terrain *t, const field_file *file, const ground_scale_of_map *scale, const char *path,
                     io_error *error) {
    if (file->raster.z == NULL) return io_fail(error, "%s: a scene has no position on the earth; give a raster", path);
    return ground_describe_raster(t, &file->raster, file->field, scale, path, error);
}

const io_georef *ground_georef(const ground *g) { return g->about.nx > 0 ? &g->about.georef : &g->file.raster.georef; }

double ground_curvature(const ground *g, double given) {
    return !isnan(given) ? given : ground_georef(g)->placed ? 6.0 / 7 : 0;
}

static bool read_ground(ground *g, const char *path, const io_raster_options *options, ground_reading reading,
                        io_error *error) {
    const coarser_options *coarser = &g->options->raster.coarser;
    g->reading = *options;
    if (reading == GROUND_PIECES) return pieces_describe(g, error);
    const bool field = reading == GROUND_FIELD || coarser->factor > 0; /* a coarser one is made of it */
    if (field && !field_file_open(&g->file, path, options, coarser, &g->query, error)) return false;
    if (!field && !io_raster_read(path, options, &g->file.raster, error)) return false;
    const io_raster *r = &g->file.raster;
    if (!field && (r->nx < 2 || r->ny < 2))
        return io_fail(error, "%s: %zu x %zu samples; a terrain has at least 2 x 2", path, r->nx, r->ny);
    ground_find_scale(&g->scale, &g->file.raster, path, options);
    return ground_describe(&g->terrain, &g->file, &g->scale, path, error);
}

/* EXIT_SUCCESS, or the exit status after a message; *g needs freeing in any case. */
static int open_ground(ground *g, ground_options *o, const char *path, size_t bands, ground_reading reading) {
    io_raster_options raster;
    io_error error;
    *g = (ground){.path = path, .options = o, .start = clock_seconds()};
    if (!query_options_resolve(&o->query, o->name, &g->query)) return EXIT_USAGE;
    if (!raster_options_resolve(&o->raster, o->name, &raster)) return EXIT_USAGE;
    if (reading == GROUND_PIECES && !pieces_resolve(o)) return EXIT_USAGE;
    if (bands > 0 && o->output == NULL) {
        command_fail(o->name, "nothing to do: give -o FILE for the result");
        return EXIT_USAGE;
    }
    const char *of_tif = o->compression != IO_DEFLATE ? "compress" : o->cog ? "cog" : o->creation.count ? "co" : NULL;
    if (of_tif != NULL && !(bands > 0 && io_raster_is_tif(o->output))) {
        command_fail(o->name, "--%s goes with -o FILE.tif", of_tif);
        return EXIT_USAGE;
    }
    if (o->plain && !(bands > 0 && io_raster_is_png(o->output))) {
        command_fail(o->name, "--plain goes with -o FILE.png");
        return EXIT_USAGE;
    }
    if (bands > 0 && !io_raster_can_write(o->output, bands, &error)) return command_fail(o->name, "%s", error.text);
    if ((o->cog || o->creation.count > 0) &&
        !io_raster_check_creation(o->creation.values, o->creation.count, o->cog, &error))
        return command_fail(o->name, "%s", error.text);
    if (bands > 0 && io_inputs_note_path(path) && is_input(o->output))
        return command_fail(o->name, "%s: is the terrain itself and cannot be overwritten", o->output);
    const cw_status status = cw_pool_create(o->query.threads, &g->query.pool);
    if (status != CW_OK) return command_fail(o->name, "%s", cw_last_error());
    raster.north_up = true;
    const bool good = read_ground(g, path, &raster, reading, &error);
    progress_end(&o->raster.line);
    if (!good) return command_fail(o->name, "%s", error.text);
    if (bands > 0 && is_input(o->output)) /* a VRT's sources, known by now */
        return command_fail(o->name, "%s: is also an input; choose another name for the output", o->output);
    g->line = progress_start(o->name);
    return EXIT_SUCCESS;
}

static void free_ground(ground *g) {
    progress_end(&g->line);
    cw_pool_destroy(g->query.pool);
    field_file_close(&g->file);
    io_raster_free(&g->about);
}

int ground_open(ground *g, ground_options *o, const char *path, size_t bands, ground_reading reading) {
    const int status = open_ground(g, o, path, bands, reading);
    if (status != EXIT_SUCCESS) free_ground(g);
    return status;
}

int ground_close(ground *g, bool good, const io_error *error) {
    const char *name = g->options->name;
    free_ground(g);
    return good ? EXIT_SUCCESS : command_fail(name, "%s", error->text);
}

bool ground_parse_sun(const char *name, const char *text, double sun[2]) {
    if (ground_numbers(text, sun, 2, 2) == 0)
        command_fail(name, "--sun takes azimuth and altitude in degrees, as 225,30, not '%s'", text);
    else if (fabs(sun[1]) > 90)
        command_fail(name, "--sun %s: the second number is the altitude, and %g degrees is none; the azimuth is first",
                     text, sun[1]);
    else
        return true;
    return false;
}

bool ground_read_place(const char *name, const char *text, double height, ground_place *p) {
    io_error error;
    if (ground_parse_place(text, height, p, &error)) return true;
    command_fail(name, "%s", error.text);
    return false;
}

void ground_note(ground_notes *n, const char *format, ...) {
    enum { LONGEST = 300 };
    char text[LONGEST];
    if (n->count == GROUND_NOTES_MOST) return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    char *copy = strdup(text);
    if (copy != NULL) n->notes[n->count++] = copy;
}

void ground_notes_free(ground_notes *n) {
    for (size_t k = 0; k < n->count; k++) free((void *)(uintptr_t)n->notes[k]);
    *n = (ground_notes){0};
}

static bool goes_on(void *context) {
    (void)context;
    return !atomic_load(cancel_flag());
}

io_raster_product ground_product(const ground *g, io_cell cell, size_t bands, const char *const *what,
                                 ground_notes *notes) {
    const io_raster *r = &g->file.raster;
    const bool by_pieces = g->about.nx > 0;
    ground_note(notes, "TIFFTAG_SOFTWARE=cellwalk %s", CW_VERSION);
    ground_note(notes, "TIFFTAG_IMAGEDESCRIPTION=%s", *what);
    ground_note(notes, "PRODUCT=%s", g->options->name);
    ground_note(notes, "SURFACE=two triangles between each four samples, split from sample (i, j) to (i + 1, j + 1)");
    return (io_raster_product){
        .nx = by_pieces ? g->window.nx : r->nx,
        .ny = by_pieces ? g->window.ny : r->ny,
        .bands = bands,
        .cell = cell,
        .map = by_pieces ? g->map : r->map,
        .georef = ground_georef(g),
        .has_nodata = true,
        .nodata = cell == IO_CELL_UINT8    ? 255
                  : cell == IO_CELL_UINT16 ? 65535
                  : cell == IO_CELL_INT16  ? INT16_MIN
                                           : NAN,
        .black = 0,
        .white = 1,
        .band_names = bands == 1 ? what : NULL,
        .notes = notes->notes,
        .threads = cw_pool_threads(g->query.pool),
        .compression = (io_compression)g->options->compression,
        .cog = g->options->cog,
        .creation = g->options->creation.values,
        .creation_count = g->options->creation.count,
        .go_on = goes_on,
    };
}

void ground_scale(io_raster_product *product, double scale) {
    product->cell = IO_CELL_INT16;
    product->scale = scale;
    product->nodata = INT16_MIN;
}

bool ground_tell(void *context, double share) {
    ground *g = context;
    if (atomic_load(cancel_flag())) return false;
    progress_update(&g->line, share);
    return true;
}

bool ground_tell_block(void *context, double share) {
    const ground *g = context;
    return ground_tell(context, g->done + share * g->part);
}

bool ground_write(ground *g, const io_raster_product *product, double passes, ground_fill *fill, void *context,
                  io_error *error) {
    const pieces_maker maker = {.fill = fill};
    return pieces_write(g, product, passes, &maker, context, error);
}
