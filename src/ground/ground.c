/* SPDX-License-Identifier: Apache-2.0 */
#include "ground.h"

#include <math.h>
#include <string.h>

/* ---- the raster, without samples --------------------------------------------------------------------------------- */

/* The terrain that a raster holds; scale is NULL or must stay. */
static bool describe(terrain *t, const io_raster *r, const cw_field *field, const map_scale *scale, const char *path,
                     io_error *error) {
    *t = (terrain){.nx = r->nx, .ny = r->ny, .stride = r->nx, .z = r->z};
    const cw_terrain_desc desc = {.field = field,
                                  .scale = scale ? &scale->metres[0][0][0] : NULL,
                                  .unit = r->georef.unit,
                                  .semi_major = r->georef.semi_major,
                                  .inverse_flattening = r->georef.inverse_flattening,
                                  .geographic = r->georef.geographic};
    return cw_terrain_place(t, r->map, &desc) ||
           io_fail(error, "%s: its map cannot be inverted, or has latitudes beyond 90 degrees", path);
}

cw_rectangle ground_all(const ground *g) { return (cw_rectangle){0, 0, g->about.nx, g->about.ny}; }

static bool is_all(const ground *g, cw_rectangle r) { return r.nx == g->about.nx && r.ny == g->about.ny; }

/* The map of a part of the raster. */
static void map_of(const ground *g, cw_rectangle part, double map[3][4]) {
    memcpy(map, g->about.map, sizeof g->about.map);
    for (int k = 0; k < 2; k++) map[k][3] += map[k][0] * (double)part.i + map[k][1] * (double)part.j;
}

void ground_set_window(ground *g, cw_rectangle window) {
    g->window = window;
    map_of(g, window, g->map);
}

void ground_extent(const terrain *t, double low[2], double high[2]) {
    for (int k = 0; k < 4; k++) {
        double xy[2];
        terrain_to_map(t, k & 1 ? (double)(t->nx - 1) : 0, k & 2 ? (double)(t->ny - 1) : 0, xy);
        for (int c = 0; c < 2; c++) {
            low[c] = k == 0 ? xy[c] : fmin(low[c], xy[c]);
            high[c] = k == 0 ? xy[c] : fmax(high[c], xy[c]);
        }
    }
}

bool ground_find_window(ground *g, const double e[4], const char *text, io_error *error) {
    const double tolerance = 0x1p-20; /* cells, for coordinates in decimals */
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    const double last[2] = {(double)(g->whole.nx - 1), (double)(g->whole.ny - 1)};
    for (int k = 0; k < 4; k++) {
        double at[2];
        terrain_from_map(&g->whole, e[k & 1 ? 2 : 0], e[k & 2 ? 3 : 1], at);
        for (int a = 0; a < 2; a++) {
            low[a] = fmin(low[a], at[a]);
            high[a] = fmax(high[a], at[a]);
        }
    }
    bool some = e[0] <= e[2] && e[1] <= e[3];
    for (int a = 0; a < 2; a++) {
        low[a] = fmax(ceil(low[a] - tolerance), 0);
        high[a] = fmin(floor(high[a] + tolerance), last[a]);
        some = some && low[a] <= high[a];
    }
    if (!some) {
        ground_extent(&g->whole, low, high);
        return io_fail(error, "--window %s: %s; samples go from %.10g,%.10g to %.10g,%.10g", text,
                       e[0] <= e[2] && e[1] <= e[3] ? "no sample is in it" : "XMIN > XMAX or YMIN > YMAX", low[0],
                       low[1], high[0], high[1]);
    }
    ground_set_window(g, (cw_rectangle){(size_t)low[0], (size_t)low[1], (size_t)(high[0] - low[0]) + 1,
                                        (size_t)(high[1] - low[1]) + 1});
    return true;
}

static bool tell_reading(void *context, double share) {
    const ground_watch *w = &((ground *)context)->watch;
    return w->tell == NULL || w->tell(w->context, ((const ground *)context)->pieces > 0 ? NULL : "reading", share);
}

/* A coarser raster is made of all samples, and then in memory. */
static bool read_coarser(ground *g, io_error *error) {
    raster_field file;
    if (!raster_field_open(&file, g->path, &g->reading, &g->coarser, &g->query, &g->watch, error)) return false;
    cw_field_destroy(file.field);
    g->about = file.raster;
    return true;
}

bool ground_open(ground *g, io_error *error) {
    io_raster *r = &g->about;
    g->reading.warn = g->watch.warn;
    g->reading.progress = tell_reading;
    g->reading.context = g;
    io_raster_options o = g->reading;
    o.no_samples = true;
    if (!(g->coarser.factor > 0 ? read_coarser(g, error) : io_raster_read(g->path, &o, r, error))) return false;
    if (r->nx < 2 || r->ny < 2)
        return io_fail(error, "%s: %zu x %zu samples; a terrain has at least 2 x 2", g->path, r->nx, r->ny);
    const bool scaled = io_scale_find(&r->georef, r->map, r->nx, r->ny, g->path, &g->watch.warn, &g->nodes);
    if (!describe(&g->whole, r, NULL, scaled ? &g->nodes : NULL, g->path, error)) return false;
    g->terrain = g->whole;
    ground_set_window(g, ground_all(g));
    return true;
}

void ground_close(ground *g) {
    raster_field_close(&g->file);
    io_raster_free(&g->about);
}

double ground_curvature(const ground *g, double given) {
    return !isnan(given) ? given : g->about.georef.placed ? 6.0 / 7 : 0;
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* A sample's four bytes, and its share of the field's structures. */
static const double bytes_a_sample = 4 + 4, samples_most = 0x1p31;

static double bytes_of(cw_rectangle piece, double more) {
    return (double)piece.nx * (double)piece.ny * (bytes_a_sample + more);
}

/* The rest of the program, GDAL's cache and the output. */
static const double others = 3e8;

static double room(const ground *g) { return fmax(g->bytes - others, 0.25 * g->bytes); }

bool ground_fits(const ground *g, cw_rectangle piece, double more) {
    return bytes_of(piece, more) <= room(g) && (double)piece.nx * (double)piece.ny <= samples_most;
}

bool ground_check(const ground *g, cw_rectangle piece, double more, io_error *error) {
    if (ground_fits(g, piece, more)) return true;
    if ((double)piece.nx * (double)piece.ny > samples_most)
        return io_fail(error, "%s: %zu x %zu samples matter, which are more than a field can hold", g->path, piece.nx,
                       piece.ny);
    const double bytes = bytes_of(piece, more), need = fmin(bytes + others, 4 * bytes);
    const bool few = g->bytes < 1000;
    return io_fail(error, "%s: %zu x %zu samples matter at once, which need --memory %.0fM or more; there is %.9g%s",
                   g->path, piece.nx, piece.ny, ceil(need / 1e6), few ? g->bytes : g->bytes / 1e6, few ? "" : "M");
}

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* Warnings of the header are not repeated, nor the same warning for piece after piece. */
static void warn_of_samples(void *context, const char *text) {
    ground *g = context;
    const bool of_samples = strstr(text, "--nodata") != NULL || strstr(text, "heights are floats") != NULL;
    if (!of_samples || g->warnings == GROUND_WARNINGS) return;
    for (size_t k = 0; k < g->warnings; k++)
        if (strncmp(text, g->warned[k], sizeof g->warned[k] - 1) == 0) return;
    snprintf(g->warned[g->warnings++], sizeof g->warned[0], "%s", text);
    io_warn(&g->watch.warn, "%s", text);
}

/* Of a file that was read as a whole a part is cut out. All of it is lent. */
static bool read_part(ground *g, cw_rectangle part, io_raster *r, io_error *error) {
    const io_raster *from = &g->about;
    io_raster_options o = g->reading;
    *r = (io_raster){.nx = from->nx, .ny = from->ny, .z = from->z};
    if (from->z != NULL && is_all(g, part)) return true;
    if (from->z != NULL) {
        *r = (io_raster){.nx = part.nx, .ny = part.ny};
        if (!io_raster_allocate(g->path, r, error)) return false;
        float *z = r->memory;
        for (size_t y = 0; y < part.ny; y++)
            memcpy(z + y * part.nx, from->z + (part.j + y) * from->nx + part.i, part.nx * sizeof *z);
        return true;
    }
    if (!is_all(g, part)) o.window = (io_raster_window){part.i, part.j, part.nx, part.ny};
    /* The map is that of the whole raster, which has been described. */
    o.cellsize = 0;
    o.north_up = false;
    o.warn = (io_warner){warn_of_samples, g};
    if (!io_raster_read(g->path, &o, r, error)) return false;
    g->pieces++;
    io_georef_free(&r->georef);
    return true;
}

bool ground_read(ground *g, cw_rectangle piece, bool field, io_error *error) {
    io_raster *r = &g->file.raster;
    raster_field_close(&g->file);
    g->terrain = g->whole;
    if ((field && !ground_check(g, piece, 0, error)) || !read_part(g, piece, r, error)) return false;
    map_of(g, piece, r->map);
    if (field && !raster_field_build(&g->file, g->path, &g->query, &g->watch, error)) return false;
    r->georef = g->about.georef; /* lent */
    const bool described = describe(&g->terrain, r, g->file.field, g->whole.scale, g->path, error);
    r->georef = (io_georef){0};
    g->terrain.whole = &g->whole;
    g->terrain.column = piece.i;
    g->terrain.row = piece.j;
    g->piece = piece;
    return described;
}

bool ground_read_around(ground *g, double x, double y, double metres, io_error *error) {
    cw_rectangle piece = ground_all(g);
    double at[2];
    if (metres > 0) {
        piece = (cw_rectangle){0, 0, 2, 2}; /* a place that is too far away is an error that finding it says */
        if (cw_terrain_find_place(&g->whole, x, y, at)) {
            const cw_rectangle around = cw_reach_around(&g->whole, at, metres);
            if (around.nx > 0) piece = cw_reach_grow(&g->whole, around, 2);
        }
    }
    return ground_check(g, piece, 0, error) && ground_read(g, piece, false, error);
}

/* ---- plans ------------------------------------------------------------------------------------------------------- */

cw_status ground_plan_create(ground_plan *p, const ground_matters *by, const terrain *whole, cw_rectangle window) {
    *p = (ground_plan){.by = *by, .whole = whole, .window = window};
    if (by->sun_count == 1) p->toward = cw_reach_toward(whole, by->suns, window);
    return by->distance > 0 || (by->sun_count == 0 && !by->horizons) ? CW_OK
                                                                     : cw_reach_blocks_create(whole, &p->blocks);
}

void ground_plan_destroy(ground_plan *p) {
    cw_reach_horizons_destroy(&p->reach);
    cw_reach_blocks_destroy(&p->blocks);
}

static bool has_blocks(const ground_plan *p) { return p->blocks.whole != NULL; }

cw_status ground_plan_around(ground_plan *p, cw_rectangle part, cw_rectangle *piece) {
    const ground_matters *by = &p->by;
    const cw_rectangle all = {0, 0, p->whole->nx, p->whole->ny};
    *piece = by->distance > 0 ? cw_reach_beside(p->whole, part, by->distance) : all;
    if (!has_blocks(p)) return CW_OK;
    if (by->horizons && !p->begun) {
        const cw_status status =
            cw_reach_horizons_create(&p->blocks, p->window, by->curvature, by->above_level, &p->reach);
        if (status != CW_OK) return status;
    }
    p->begun = true;
    *piece = by->horizons ? cw_reach_of_horizons(&p->reach, part) : cw_reach_grow(p->whole, part, 2);
    for (size_t k = 0; k < by->sun_count && (piece->nx < all.nx || piece->ny < all.ny); k++) {
        const reach_sunward sunward = cw_reach_toward(p->whole, &by->suns[k], part);
        *piece = cw_reach_both(*piece, cw_reach_of_shadows(&p->blocks, &sunward, part));
    }
    return CW_OK;
}

static bool is_wanted(const ground_plan *p, cw_rectangle block) {
    const cw_rectangle w = p->window, both = cw_reach_both(w, block);
    double first, last;
    return p->by.horizons || p->by.sun_count != 1 || (both.nx < w.nx + block.nx && both.ny < w.ny + block.ny) ||
           cw_reach_passes(&p->toward, w, block, &first, &last);
}

/* The rectangle of all that is wanted of some rows of blocks. */
static cw_rectangle find_wanted(const ground_plan *p, size_t first, size_t end) {
    cw_rectangle all = {0};
    for (size_t y = first; y < end; y++)
        for (size_t x = 0; x < p->blocks.across; x++) {
            const cw_rectangle block = cw_reach_block(&p->blocks, x, y);
            if (is_wanted(p, block)) all = cw_reach_both(all, block);
        }
    return all;
}

/* A few rows of blocks at a time: the way of shadows is slanted, and each reading opens the file anew. */
bool ground_plan_survey(ground_plan *p, ground *g, io_error *error) {
    const double most = fmin(0.5 * room(g), 1e8) / sizeof(float); /* samples */
    const size_t rows = (size_t)fmin(fmax(most / (double)g->about.nx / REACH_BLOCK, 1), 8);
    if (!has_blocks(p)) return true;
    if (g->about.z) {
        cw_reach_blocks_take(&p->blocks, ground_all(g), g->about.z);
        return true;
    }
    for (size_t y = 0; y < p->blocks.down; y += rows) {
        const size_t end = p->blocks.down - y < rows ? p->blocks.down : y + rows;
        const cw_rectangle all = find_wanted(p, y, end);
        const size_t columns = all.ny ? (size_t)fmax(most / (double)all.ny / REACH_BLOCK, 1) * REACH_BLOCK : 1;
        for (size_t i = 0; i < all.nx; i += columns) {
            const cw_rectangle part = {all.i + i, all.j, all.nx - i < columns ? all.nx - i : columns, all.ny};
            io_raster r;
            if (!read_part(g, part, &r, error)) return false;
            cw_reach_blocks_take(&p->blocks, part, r.z);
            io_raster_free(&r);
        }
    }
    return true;
}
