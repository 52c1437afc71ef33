/* SPDX-License-Identifier: Apache-2.0 */
#include "pieces.h"

#include "../cancel.h"
#include "clock.h"
#include "command.h"
#include "number.h"
#include "picture.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- options ----------------------------------------------------------------------------------------------------- */

void pieces_rows(ground_options *o, option_spec rows[PIECES_OPTION_COUNT]) {
    const option_spec own[PIECES_OPTION_COUNT] = {
        option_text("window", "XMIN,YMIN,XMAX,YMAX", &o->window,
                    "only the samples in that part of the map, in its coordinates; values are those of the whole "
                    "raster, of which only the parts needed are read"),
        option_text("memory", "SIZE", &o->memory,
                    "limit on memory in bytes, as 2G or 500M: rasters and products that need more are made by bands of "
                    "rows (default: three quarters of the machine's memory)"),
    };
    memcpy(rows, own, sizeof own);
}

static double size_of_text(const char *text) {
    static const char units[] = "KMGT";
    char *end;
    double size = number_read(text, &end);
    const char *unit = *end != '\0' ? strchr(units, *end & ~0x20) : NULL;
    if (end == text || (*end != '\0' && (unit == NULL || end[1] != '\0'))) return NAN;
    for (const char *u = units; unit != NULL && u <= unit; u++) size *= 1000;
    return size;
}

bool pieces_resolve(ground_options *o) {
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    o->bytes = pages > 0 && page > 0 ? 0.75 * (double)pages * (double)page : 4e9;
    if (o->window && ground_numbers(o->window, o->extent, 4, 4) == 0) {
        command_fail(o->name, "--window takes XMIN,YMIN,XMAX,YMAX, coordinates of the map, not '%s'", o->window);
        return false;
    }
    if (o->memory) o->bytes = size_of_text(o->memory);
    if (o->bytes > 0 && isfinite(o->bytes)) return true;
    command_fail(o->name, "--memory takes a number of bytes, as 2G or 500M, not '%s'", o->memory);
    return false;
}

/* ---- the raster, without samples --------------------------------------------------------------------------------- */

cw_rectangle pieces_all(const ground *g) { return (cw_rectangle){0, 0, g->about.nx, g->about.ny}; }

static bool is_all(const ground *g, cw_rectangle r) { return r.nx == g->about.nx && r.ny == g->about.ny; }

/* The map of a part of the raster. */
static void map_of(const ground *g, cw_rectangle part, double map[3][4]) {
    memcpy(map, g->about.map, sizeof g->about.map);
    for (int k = 0; k < 2; k++) map[k][3] += map[k][0] * (double)part.i + map[k][1] * (double)part.j;
}

void pieces_set_window(ground *g, cw_rectangle window) {
    g->window = window;
    map_of(g, window, g->map);
}

static bool find_window(ground *g, io_error *error) {
    const double *e = g->options->extent;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    size_t first[2], count[2];
    const double tolerance = 0x1p-20; /* cells, for coordinates in decimals */
    for (int k = 0; k < 4; k++) {
        double at[2];
        terrain_from_map(&g->whole, e[k & 1 ? 2 : 0], e[k & 2 ? 3 : 1], at);
        for (int a = 0; a < 2; a++) {
            low[a] = fmin(low[a], at[a]);
            high[a] = fmax(high[a], at[a]);
        }
    }
    for (int a = 0; a < 2; a++) {
        const double last = (double)((a ? g->whole.ny : g->whole.nx) - 1);
        const double from = fmax(ceil(low[a] - tolerance), 0), until = fmin(floor(high[a] + tolerance), last);
        double corners[2][2];
        terrain_to_map(&g->whole, 0, 0, corners[0]);
        terrain_to_map(&g->whole, (double)(g->whole.nx - 1), (double)(g->whole.ny - 1), corners[1]);
        if (!(from <= until && e[0] <= e[2] && e[1] <= e[3]))
            return io_fail(error, "--window %s: no sample is in it; they go from %.10g,%.10g to %.10g,%.10g",
                           g->options->window, fmin(corners[0][0], corners[1][0]), fmin(corners[0][1], corners[1][1]),
                           fmax(corners[0][0], corners[1][0]), fmax(corners[0][1], corners[1][1]));
        first[a] = (size_t)from;
        count[a] = (size_t)(until - from) + 1;
    }
    pieces_set_window(g, (cw_rectangle){first[0], first[1], count[0], count[1]});
    return true;
}

/* A coarser raster is made of all samples, and then in memory. */
static bool read_coarser(ground *g, io_error *error) {
    field_file file;
    if (!field_file_open(&file, g->path, &g->reading, &g->options->raster.coarser, &g->query, error)) return false;
    cw_field_destroy(file.field);
    g->about = file.raster;
    return true;
}

bool pieces_describe(ground *g, io_error *error) {
    io_raster_options o = g->reading;
    o.no_samples = io_raster_has_windows(g->path);
    if (!(g->options->raster.coarser.factor > 0 ? read_coarser(g, error)
                                                : io_raster_read(g->path, &o, &g->about, error)))
        return false;
    progress_end(&((raster_options *)g->reading.context)->line);
    io_raster *r = &g->about;
    if (r->nx < 2 || r->ny < 2)
        return io_fail(error, "%s: %zu x %zu samples; a terrain has at least 2 x 2", g->path, r->nx, r->ny);
    ground_find_scale(&g->scale, r, g->path, &g->reading);
    if (!ground_describe_raster(&g->whole, r, NULL, &g->scale, g->path, error)) return false;
    g->terrain = g->whole;
    pieces_set_window(g, pieces_all(g));
    return g->options->window == NULL || find_window(g, error);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* A sample's four bytes, and its share of the field's structures. */
static const double bytes_a_sample = 4 + 4, samples_most = 0x1p31;

static double bytes_of(cw_rectangle piece, double more) {
    return (double)piece.nx * (double)piece.ny * (bytes_a_sample + more);
}

/* The rest of the program, GDAL's cache and the output. */
static const double others = 3e8;

static double room(const ground *g) { return fmax(g->options->bytes - others, 0.25 * g->options->bytes); }

static bool fits(const ground *g, cw_rectangle piece, double more) {
    return bytes_of(piece, more) <= room(g) && (double)piece.nx * (double)piece.ny <= samples_most;
}

bool pieces_fit(const ground *g, cw_rectangle piece) { return fits(g, piece, 0); }

bool pieces_check(const ground *g, cw_rectangle piece, double more, io_error *error) {
    if (fits(g, piece, more)) return true;
    if ((double)piece.nx * (double)piece.ny > samples_most)
        return io_fail(error, "%s: %zu x %zu samples matter, which are more than a field can hold", g->path, piece.nx,
                       piece.ny);
    const double bytes = bytes_of(piece, more), need = fmin(bytes + others, 4 * bytes);
    return io_fail(error, "%s: %zu x %zu samples matter at once, which need --memory %.0fM; there is %.9gM", g->path,
                   piece.nx, piece.ny, ceil(need / 1e6), g->options->bytes / 1e6);
}

/* Warnings of the header are not repeated, nor the same warning for piece after piece. */
static void warn_of_samples(void *context, const char *text) {
    enum { ENOUGH = 4 };
    ground *g = context;
    const bool of_samples = strstr(text, "--nodata") != NULL || strstr(text, "heights are floats") != NULL;
    if (of_samples && g->warnings++ < ENOUGH) g->reading.warn(g->reading.context, text);
}

static bool tell_reading(void *context, double share) {
    const ground *g = context;
    return g->pieces > 0 ? !atomic_load(cancel_flag()) : g->reading.progress(g->reading.context, share);
}

static io_raster_options options_of(ground *g, cw_rectangle part) {
    io_raster_options o = g->reading;
    if (!is_all(g, part)) {
        o.window.i = part.i;
        o.window.j = part.j;
        o.window.nx = part.nx;
        o.window.ny = part.ny;
    }
    /* The map is that of the whole raster, which has been described. */
    o.cellsize = 0;
    o.north_up = false;
    o.warn = warn_of_samples;
    o.progress = tell_reading;
    o.context = g;
    return o;
}

/* A part of a file that was read as a whole. All of it is lent. */
static bool cut_out(const ground *g, cw_rectangle part, io_raster *r, io_error *error) {
    const io_raster *from = &g->about;
    *r = (io_raster){.nx = from->nx, .ny = from->ny, .z = from->z};
    if (is_all(g, part)) return true;
    if (!io_raster_allocate(g->path, part.nx, part.ny, r, error)) return false;
    float *z = r->memory;
    for (size_t y = 0; y < part.ny; y++)
        memcpy(z + y * part.nx, from->z + (part.j + y) * from->nx + part.i, part.nx * sizeof *z);
    return true;
}

static bool read_part(ground *g, cw_rectangle part, io_raster *r, io_error *error) {
    const io_raster_options o = options_of(g, part);
    if (g->about.z != NULL) return cut_out(g, part, r, error);
    progress_end(&g->line);
    const bool good = io_raster_read(g->path, &o, r, error);
    progress_end(&((raster_options *)g->reading.context)->line);
    g->pieces++;
    if (!good) return false;
    io_georef_free(&r->georef);
    return true;
}

bool pieces_read(ground *g, cw_rectangle piece, bool field, io_error *error) {
    io_raster *r = &g->file.raster;
    field_file_close(&g->file);
    g->terrain = g->whole;
    if (!pieces_check(g, piece, 0, error) || !read_part(g, piece, r, error)) return false;
    map_of(g, piece, r->map);
    if (field && !field_file_build(&g->file, g->path, &g->query, error)) return false;
    g->line = progress_start(g->options->name);
    r->georef = g->about.georef; /* lent */
    const bool described = ground_describe_raster(&g->terrain, r, g->file.field, &g->scale, g->path, error);
    r->georef = (io_georef){0};
    g->terrain.whole = &g->whole;
    g->terrain.column = piece.i;
    g->terrain.row = piece.j;
    g->piece = piece;
    return described;
}

typedef struct survey {
    ground *ground;
    reach_blocks *blocks;
    pieces_wanted *wanted;
    void *context;
    double most; /* samples at once */
} survey;

static bool is_wanted(const survey *s, cw_rectangle block) {
    const cw_rectangle w = s->ground->window, both = reach_both(w, block);
    return s->wanted == NULL || (both.nx < w.nx + block.nx && both.ny < w.ny + block.ny) ||
           s->wanted(s->context, block);
}

/* The rectangle of all that is wanted of rows of blocks, and how many samples of it are. */
static cw_rectangle find_wanted(const survey *s, size_t first, size_t end, double *samples) {
    const size_t nx = s->ground->about.nx, ny = s->ground->about.ny;
    cw_rectangle all = {0};
    *samples = 0;
    for (size_t y = first; y < end; y++)
        for (size_t x = 0; x < s->blocks->across; x++) {
            const size_t i = x * REACH_BLOCK, j = y * REACH_BLOCK;
            const cw_rectangle block = {i, j, nx - i < REACH_BLOCK ? nx - i : REACH_BLOCK,
                                        ny - j < REACH_BLOCK ? ny - j : REACH_BLOCK};
            if (!is_wanted(s, block)) continue;
            *samples += (double)block.nx * (double)block.ny;
            all = reach_both(all, block);
        }
    return all;
}

/* Rows of blocks: together if memory has room and most of them are wanted, since each reading opens the file anew. */
static bool survey_rows(const survey *s, size_t first, size_t end, io_error *error) {
    double samples;
    const cw_rectangle all = find_wanted(s, first, end, &samples);
    const double size = (double)all.nx * (double)all.ny;
    if (samples == 0) return true;
    if (end - first > 1 && (size > s->most || size > 2 * samples)) {
        const size_t middle = first + (end - first) / 2;
        return survey_rows(s, first, middle, error) && survey_rows(s, middle, end, error);
    }
    const size_t columns = (size_t)fmax(s->most / (double)all.ny / REACH_BLOCK, 1) * REACH_BLOCK;
    for (size_t i = 0; i < all.nx; i += columns) {
        const cw_rectangle part = {all.i + i, all.j, all.nx - i < columns ? all.nx - i : columns, all.ny};
        io_raster r;
        if (atomic_load(cancel_flag())) return io_fail(error, "interrupted");
        if (!read_part(s->ground, part, &r, error)) return false;
        reach_blocks_take(s->blocks, part, r.z);
        io_raster_free(&r);
    }
    return true;
}

bool pieces_survey(ground *g, reach_blocks *b, pieces_wanted *wanted, void *context, io_error *error) {
    if (g->about.z != NULL) {
        reach_blocks_take(b, pieces_all(g), g->about.z);
        return true;
    }
    const survey s = {g, b, wanted, context, fmin(0.5 * room(g), 1e8) / sizeof(float)};
    return survey_rows(&s, 0, b->down, error);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* As many rows as a GeoTIFF's tiles have, fewer where that would make Ctrl-C wait, or memory is short. */
static size_t block_rows(const io_raster_product *p, double passes, bool few) {
    enum { LEAST = 32 };
    const size_t tile = io_raster_tile_side(p->ny);
    size_t rows = tile;
    if (few) return tile < LEAST ? tile : LEAST;
    while (rows > LEAST && rows % 2 == 0 && passes * (double)rows * (double)p->nx > 1e7) rows /= 2;
    while (passes * (double)rows * (double)p->nx < 1e6 && rows < p->ny) rows += tile;
    return rows;
}

typedef struct writing {
    ground *ground;
    const pieces_maker *maker;
    void *context;
    size_t rows, step;   /* rows of a block; rows of the window for each */
    size_t from, until;  /* rows of the window that the piece is good for */
    size_t cell;         /* bytes of one */
    void *cells, *lines; /* a block of the window; rows of the piece, where those are longer */
    size_t lines_room;
    outcome outcome;
    picture *picture; /* NULL: rows are written as they come */
    float *values;    /* of a block */
} writing;

/* The piece for the next so many blocks from row on. */
static bool piece_for(const writing *w, size_t row, size_t blocks, cw_rectangle *part, cw_rectangle *piece,
                      io_error *error) {
    const cw_rectangle window = w->ground->window;
    const size_t left = window.ny - row, block = w->rows * w->step,
                 rows = blocks < left / block + 1 ? blocks * block : left;
    *part = (cw_rectangle){window.i, window.j + row, window.nx, rows < left ? rows : left};
    return w->maker->around(w->context, *part, piece, error);
}

/* Reads the piece for as many rows as there is memory for. */
static bool next_piece(writing *w, size_t row, io_error *error) {
    ground *g = w->ground;
    cw_rectangle part = g->window, piece = pieces_all(g);
    if (!is_all(g, part) || !fits(g, piece, w->maker->more)) {
        size_t least = 1, most = (g->window.ny - row + w->rows * w->step - 1) / (w->rows * w->step);
        while (least < most) {
            const size_t blocks = most - (most - least) / 2;
            if (!piece_for(w, row, blocks, &part, &piece, error)) return false;
            if (fits(g, piece, w->maker->more))
                least = blocks;
            else
                most = blocks - 1;
        }
        if (!piece_for(w, row, least, &part, &piece, error)) return false;
    }
    if (w->until == 0 || memcmp(&piece, &g->piece, sizeof piece) != 0) {
        if (!pieces_read(g, piece, true, error)) return false;
        if (!w->maker->enter(w->context, error)) return false;
    }
    w->from = part.j - g->window.j;
    w->until = g->until = w->from + part.ny;
    return true;
}

/* That all pieces fit is known before the work begins. */
static bool check_pieces(const writing *w, io_error *error) {
    const ground *g = w->ground;
    cw_rectangle part, piece;
    if (w->maker->around == NULL || fits(g, pieces_all(g), w->maker->more)) return true;
    for (size_t row = 0; row < g->window.ny; row += w->rows * w->step)
        if (!piece_for(w, row, 1, &part, &piece, error) || !pieces_check(g, piece, w->maker->more, error)) return false;
    return true;
}

static bool fill_block(writing *w, size_t band, size_t row, size_t rows, io_error *error) {
    const ground *g = w->ground;
    if (w->maker->every > 0) return w->maker->fill(w->context, band, row, rows, w->cells, error);
    const size_t nx = g->terrain.nx, first = g->window.i - g->terrain.column,
                 local = row + g->window.j - g->terrain.row;
    /* Ground that is read whole has no window. */
    if (g->window.nx == 0 || nx == g->window.nx) return w->maker->fill(w->context, band, local, rows, w->cells, error);
    if (w->lines_room < nx * rows) {
        free(w->lines);
        w->lines = malloc(nx * rows * w->cell);
        w->lines_room = w->lines ? nx * rows : 0;
        if (w->lines == NULL) return io_fail(error, "out of memory");
    }
    if (!w->maker->fill(w->context, band, local, rows, w->lines, error)) return false;
    for (size_t y = 0; y < rows; y++)
        memcpy((char *)w->cells + y * g->window.nx * w->cell, (const char *)w->lines + (y * nx + first) * w->cell,
               g->window.nx * w->cell);
    return true;
}

/* Floats to multiples of the scale, in place: each is off by half of that at most, since scales are powers of two. */
static void pack(void *cells, size_t n, const io_raster_product *p) {
    for (size_t k = 0; k < n; k++) {
        float value;
        memcpy(&value, (const char *)cells + k * sizeof value, sizeof value);
        const double steps = nearbyint((double)value / p->scale);
        const int16_t step = (int16_t)(isnan(steps) ? p->nodata : fmin(fmax(steps, -INT16_MAX), INT16_MAX));
        memcpy((char *)cells + k * sizeof step, &step, sizeof step);
    }
}

/* The block as the line at the end counts it and a picture shows it. */
static bool take_block(writing *w, const io_raster_product *p, size_t row, size_t rows, io_error *error) {
    const ground *g = w->ground;
    outcome_read(p, w->cells, rows * p->nx, w->values);
    outcome_take(&w->outcome, w->values, rows * p->nx);
    const size_t first = g->window.i - g->terrain.column, local = row * w->step + g->window.j - g->terrain.row;
    return w->picture == NULL ||
           picture_take(w->picture, row, rows, w->values, &g->terrain, first, local, w->step, error);
}

static bool write_blocks(writing *w, const io_raster_product *p, io_raster_writer *to, io_error *error) {
    ground *g = w->ground;
    for (size_t band = 0; band < p->bands; band++)
        for (size_t row = 0; row < p->ny; row += w->rows) {
            const size_t count = p->ny - row < w->rows ? p->ny - row : w->rows;
            const size_t at = row * w->step;
            if (w->maker->around && (at < w->from || at >= w->until) && !next_piece(w, at, error)) return false;
            g->done = ((double)band + (double)row / (double)p->ny) / (double)p->bands;
            g->part = (double)count / (double)p->ny / (double)p->bands;
            if (!ground_tell(g, g->done)) return io_fail(error, "interrupted");
            if (!fill_block(w, band, row, count, error) || (band == 0 && !take_block(w, p, row, count, error)))
                return false;
            if (to == NULL) continue;
            if (p->scale > 0) pack(w->cells, count * p->nx, p);
            if (!io_raster_write(to, w->cells, count, error)) return false;
        }
    return true;
}

static bool write_rows(writing *w, const io_raster_product *product, io_error *error) {
    io_raster_writer to;
    if (!io_raster_create(&to, w->ground->options->output, product, error)) return false;
    const bool good = write_blocks(w, product, &to, error) && io_raster_commit(&to, error);
    io_raster_discard(&to);
    return good;
}

static bool write_picture(writing *w, const io_raster_product *product, io_error *error) {
    const ground *g = w->ground;
    const char *output = g->options->output;
    double *marks = malloc((2 * g->mark_count + 1) * sizeof *marks);
    picture p;
    if (marks == NULL) return io_fail(error, "out of memory");
    for (size_t k = 0; k < g->mark_count; k++) {
        marks[2 * k] = g->marks[2 * k] - (double)g->window.i;
        marks[2 * k + 1] = g->marks[2 * k + 1] - (double)g->window.j;
    }
    bool good = picture_begin(&p, output, product->nx, product->ny, error);
    w->picture = &p;
    good = good && write_blocks(w, product, NULL, error) &&
           picture_write(&p, output, product, &w->outcome, marks, g->mark_count, error);
    picture_end(&p);
    free(marks);
    return good;
}

/* "cellwalk shadow: shadow.tif: 24.1 % of 138632 samples in the sun, 0.31 s" */
static void tell_outcome(ground *g, const outcome *o, const io_raster_product *p) {
    char text[200];
    progress_end(&g->line);
    if (g->options->quiet) return;
    outcome_text(o, p, g->counted ? g->counted : "above 0", text, sizeof text);
    command_note(g->options->name, "%s: %s%s, %.2f s", g->options->output, p->bands > 1 ? "in the first band " : "",
                 text, clock_seconds() - g->start);
}

bool pieces_write(ground *g, const io_raster_product *product, double passes, const pieces_maker *maker, void *context,
                  io_error *error) {
    writing w = {.ground = g,
                 .maker = maker,
                 .context = context,
                 .rows = block_rows(product, passes, maker->around && !fits(g, pieces_all(g), maker->more)),
                 .step = maker->every > 0 ? maker->every : 1,
                 .cell = io_cell_bytes(product->scale > 0 ? IO_CELL_FLOAT32 : product->cell)};
    w.cells = malloc(w.rows * product->nx * w.cell);
    w.values = malloc(w.rows * product->nx * sizeof *w.values);
    bool good = (w.cells && w.values) || io_fail(error, "out of memory");
    good = good && outcome_begin(&w.outcome, product->nx * product->ny, error) && check_pieces(&w, error);
    const bool drawn = io_raster_is_png(g->options->output) && !g->options->plain;
    good = good && (drawn ? write_picture(&w, product, error) : write_rows(&w, product, error));
    if (good) tell_outcome(g, &w.outcome, product);
    outcome_end(&w.outcome);
    free(w.cells);
    free(w.values);
    free(w.lines);
    return good;
}
