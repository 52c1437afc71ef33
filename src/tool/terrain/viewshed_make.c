/* SPDX-License-Identifier: Apache-2.0 */
#include "viewshed_make.h"

#include "command.h"
#include "large.h"
#include "sight.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT_SMALL = 254, COUNT_MOST = 65534, TIF_BANDS_MOST = 65535 };

static bool tell(void *context, double share) {
    viewshed_command *c = context;
    product_tell(&c->product, ((double)c->observer + share) / (double)c->observers.count);
    return true;
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

/* The samples that one observer's answers in the window come from. */
static cw_rectangle samples_of(const viewshed_command *c, const double at[2]) {
    const ground *g = &c->product.ground;
    const cw_rectangle all = ground_all(g);
    const double farthest = c->look.farthest;
    if (farthest > 0) return cw_reach_around(&g->whole, at, farthest);
    /* Needed heights are rounded, and how depends on more than the lines. */
    const bool whole = g->window.nx == all.nx && g->window.ny == all.ny;
    return whole || c->kind == VIEW_NEEDED ? all : cw_reach_between(&g->whole, at, g->window);
}

/* Reads the part that all observers need, and sets the window to the part that they can see. */
static bool read_samples(viewshed_command *c, io_error *error) {
    const double farthest = c->look.farthest;
    ground *g = &c->product.ground;
    cw_rectangle near = {0}, piece = {0};
    for (size_t k = 0; k < c->observers.count; k++) {
        char text[IO_PLACE_ROOM];
        double at[2];
        const io_place *o = &c->observers.list[k];
        if (!cw_terrain_find_place(&g->whole, o->x, o->y, at))
            return io_fail(error, "%s: is too far away from the terrain", io_place_text(o, text));
        near = cw_reach_both(near, cw_reach_within(&g->whole, at, farthest));
    }
    if (farthest > 0 && c->product.window == NULL) {
        if (near.nx == 0) return io_fail(error, "no sample is within %g m of any observer", farthest);
        ground_set_window(g, near);
    }
    for (size_t k = 0; k < c->observers.count; k++) {
        double at[2];
        cw_terrain_find_place(&g->whole, c->observers.list[k].x, c->observers.list[k].y, at);
        piece = cw_reach_both(piece, samples_of(c, at));
    }
    piece = cw_reach_grow(&g->whole, cw_reach_both(piece, g->window), 0);
    double more = c->table ? (double)sizeof *c->own : 0;
    if (c->kind == VIEW_WEIGHT) more += (double)(sizeof *c->sums - sizeof(float)); /* longer than other results */
    if (c->within) more += (double)sizeof *c->inside;
    return ground_check(g, piece, more, error) && ground_read(g, piece, false, error);
}

/* ---- observers that see nothing ---------------------------------------------------------------------------------- */

/* Whether an observer has a place to look from; before samples are read, whether it stands on the raster. */
static bool can_look(const viewshed_command *c, const io_place *place, bool read, io_error *why) {
    const ground *g = &c->product.ground;
    char text[IO_PLACE_ROOM];
    double at[3];
    if (read) return ground_find_place(&g->terrain, place, at, NULL, why);
    if (cw_terrain_find_place(&g->whole, place->x, place->y, at) &&
        (place->absolute ||
         (at[0] >= 0 && at[1] >= 0 && at[0] <= (double)(g->whole.nx - 1) && at[1] <= (double)(g->whole.ny - 1))))
        return true;
    return io_fail(why, "%s: lies outside", io_place_text(place, text));
}

static bool skip_observers(viewshed_command *c, bool read, io_error *error) {
    const io_warner *to = &c->product.ground.watch.warn;
    io_points *o = &c->observers;
    size_t kept = 0;
    io_error why;
    if (!c->skip) return true;
    for (size_t k = 0; k < o->count; k++) {
        if (can_look(c, &o->list[k], read, &why))
            o->list[kept++] = o->list[k];
        else
            io_warn(to, "skipped: %s", why.text);
    }
    c->skipped += o->count - kept;
    o->count = kept;
    if (kept == 0) return io_fail(error, "none of %zu observers has ground to stand on", c->skipped);
    if (read && c->skipped > 0) io_warn(to, "%zu of %zu observers are skipped", c->skipped, c->skipped + kept);
    return true;
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

/* The line of the table about one observer's view of the window, which is then added to those before. */
static bool print_view(viewshed_command *c, const double eye[3], io_error *error) {
    const terrain *t = &c->product.ground.terrain;
    const cw_rectangle w = c->product.ground.window;
    const io_place *o = &c->observers.list[c->observer];
    const view_sum v =
        view_sum_of(t, (cw_rectangle){w.i - t->column, w.j - t->row, w.nx, w.ny}, c->own, c->inside, eye);
    for (size_t k = 0; k < t->nx * t->ny; k++) {
        if (c->seen) c->seen[k] = (uint16_t)(c->seen[k] + c->own[k]);
        if (c->sums) c->sums[k] += c->own[k];
    }
    io_output *to = &c->table_file;
    return io_output_print(to, error, "%zu,%.12g,%.12g,%.0f,%.9g,", isnan(o->along) ? o->order + 1 : c->observer + 1,
                           o->x, o->y, v.samples, v.km2) &&
           (v.samples > 0
                ? io_output_print(to, error, "%.3f,%.12g,%.12g", v.farthest, v.farthest_at[0], v.farthest_at[1])
                : io_output_write(to, ",,", 2, error)) &&
           (!c->observers.has_names || io_table_write_cell(to, o->name, error)) && io_output_write(to, "\n", 1, error);
}

static bool look_from(viewshed_command *c, io_error *error) {
    const terrain *t = &c->product.ground.terrain;
    const io_place *place = &c->observers.list[c->observer];
    double eye[3];
    if (!ground_find_place(t, place, eye, NULL, error)) return false;
    cw_observer from = c->look;
    from.x = place->x;
    from.y = place->y;
    from.height = eye[2] * terrain_metres_of_height(t);
    from.absolute = 1;
    cw_view view = {.seen = c->own ? c->own : c->seen};
    if (!c->own) {
        if (c->kind == VIEW_NEEDED) view.needed = c->numbers;
        if (c->kind == VIEW_ANGLE) view.angle = c->numbers;
        view.sum = c->sums;
        view.weight = c->weights ? place->weight : 1;
        if (view.weight == 0) view.sum = NULL; /* adds nothing */
    }
    cw_run run = c->product.ground.query;
    run.watch = tell;
    run.watch_context = c;
    if (c->own) memset(c->own, 0, t->nx * t->ny * sizeof *c->own);
    return product_good(cw_viewshed(t, &run, &from, (cw_area){0}, &view), error) &&
           (c->own == NULL || print_view(c, eye, error));
}

/* The samples that count in the table. */
static bool find_inside(viewshed_command *c, io_error *error) {
    const ground *g = &c->product.ground;
    const terrain *t = &g->terrain;
    const io_points_options reading = {.crs = g->about.georef.crs, .warn = g->watch.warn};
    double map[3][4];
    const io_mask mask = {(const double(*)[4])map, t->nx, t->ny, c->inside = calloc(t->nx, t->ny)};
    if (c->inside == NULL) return io_fail(error, "out of memory");
    memcpy(map, t->map, sizeof map);
    for (int k = -1; k < 2; k++) { /* longitudes from -180 or from 0 on */
        map[0][3] = t->map[0][3] + k * ground_round(t);
        if ((k == 0 || t->geographic) && !io_areas_read(c->within, &reading, &mask, error)) return false;
    }
    if (memchr(c->inside, 1, t->nx * t->ny) == NULL)
        io_warn(&g->watch.warn, "%s: no sample that is looked at lies inside its polygons", c->within);
    return true;
}

static bool make_room(viewshed_command *c, io_error *error) {
    const size_t n = c->product.ground.terrain.nx * c->product.ground.terrain.ny;
    if (c->table) {
        c->own = large_allocate(n * sizeof *c->own);
        if (c->own == NULL) return io_fail(error, "out of memory");
        if (!io_output_open(&c->table_file, c->table, error) ||
            !io_output_print(&c->table_file, error, "observer,x,y,samples,km2,farthest,farthest_x,farthest_y%s\n",
                             c->observers.has_names ? ",name" : ""))
            return false;
    }
    const bool counts = c->kind == VIEW_SEEN, sums = c->kind == VIEW_WEIGHT;
    const size_t bytes = n * (counts ? sizeof *c->seen : sums ? sizeof *c->sums : sizeof *c->numbers);
    void *memory = large_allocate(bytes);
    if (memory == NULL) return io_fail(error, "out of memory");
    if (counts || sums) memset(memory, 0, bytes);
    if (counts)
        c->seen = memory;
    else if (sums)
        c->sums = memory;
    else
        c->numbers = memory;
    return true;
}

static size_t most_seen(const viewshed_command *c) { return c->bands ? 1 : c->observers.count; }

/* Cells of a row, whose samples are z, from those of the terrain number first on. */
static void fill_row(const viewshed_command *c, size_t first, const float *restrict z, size_t n, void *restrict cells) {
    float *numbers = cells;
    uint8_t *bytes = cells;
    uint16_t *words = cells;
    const uint16_t *seen = c->seen ? c->seen + first : NULL;
    const bool small = most_seen(c) <= COUNT_SMALL;
    if (c->numbers)
        memcpy(cells, c->numbers + first, n * sizeof *numbers);
    else if (c->sums)
        for (size_t k = 0; k < n; k++) numbers[k] = isfinite(z[k]) ? (float)c->sums[first + k] : NAN;
    else
        for (size_t k = 0; k < n; k++) {
            const uint16_t count = seen[k]; /* read even where it is not used, so that the loop can be vectorized */
            if (small)
                bytes[k] = isfinite(z[k]) ? (uint8_t)count : 255;
            else
                words[k] = isfinite(z[k]) ? count : 65535;
        }
}

/* The view of a band's observer is found when the band is begun. */
bool viewshed_fill(product *p, const product_block *b, void *cells, io_error *error) {
    viewshed_command *c = p->context;
    const terrain *t = &p->ground.terrain;
    const cw_rectangle at = b->area.at;
    if (c->bands && c->made <= b->band) {
        c->observer = b->band;
        if (c->seen) memset(c->seen, 0, t->nx * t->ny * sizeof *c->seen);
        if (!look_from(c, error)) return false;
        c->made = b->band + 1;
    }
    for (size_t y = 0; y < at.ny; y++) {
        const size_t first = (at.j + y) * t->nx + at.i;
        fill_row(c, first, t->z + first, at.nx, (char *)cells + y * at.nx * io_cell_bytes(p->raster.cell));
    }
    return true;
}

/* ---- the raster -------------------------------------------------------------------------------------------------- */

static const char *meaning(const viewshed_command *c) {
    if (c->weights) return "sum of the weights of the observers that see the target";
    if (c->kind == VIEW_ANGLE)
        return "angle of the target above the observer's horizontal; no data where it is not seen";
    if (c->kind == VIEW_NEEDED) return "height above ground that is needed to be seen";
    return most_seen(c) > 1 ? "number of observers that see the target"
                            : "1 where the target is seen, 0 where it is not";
}

static void note(viewshed_command *c) {
    product *p = &c->product;
    const io_points *all = &c->observers;
    const cw_observer *l = &c->look;
    if (c->from.file) product_note(p, "OBSERVERS_FILE=%s", c->from.file);
    if (c->from.every > 0) product_note(p, "OBSERVERS_EVERY=%.9g", c->from.every);
    product_note(p, "HEIGHTS=metres; an observer's third number is above ground, or absolute behind =");
    if (c->kind != VIEW_NEEDED) product_note(p, "TARGET_HEIGHT=%.9g", l->target);
    if (l->farthest > 0) product_note(p, "MAX_DISTANCE=%.9g", l->farthest);
    if (l->nearest > 0) product_note(p, "MIN_DISTANCE=%.9g", l->nearest);
    if (c->azimuth) product_note(p, "AZIMUTH=%s", c->azimuth);
    if (c->vertical) product_note(p, "VERTICAL=%s", c->vertical);
    product_note(p, "CURVATURE=%.9g", l->curvature);
    product_note(p, "OBSERVERS=%zu", all->count);
    /* As many as there is room for. */
    for (size_t k = 0; k < all->count && k < PRODUCT_NOTES_MOST; k++) {
        const io_place *o = &all->list[k];
        char x[GROUND_NUMBER], y[GROUND_NUMBER], z[GROUND_NUMBER];
        product_note(p, "OBSERVER_%zu=%s,%s,%s%s", k + 1, ground_number(o->x, x), ground_number(o->y, y),
                     o->absolute ? "=" : "", ground_number(o->z, z));
        if (o->name[0] != '\0') product_note(p, "OBSERVER_%zu_NAME=%s", k + 1, o->name);
    }
}

static bool name_bands(viewshed_command *c, io_error *error) {
    for (size_t k = 0; k < c->observers.count; k++) {
        const io_place *o = &c->observers.list[k];
        if (!product_name_band(&c->product, k, error, "observer %zu%s%s%s at %.10g,%.10g", k + 1,
                               o->name[0] ? " (" : "", o->name, o->name[0] ? ")" : "", o->x, o->y))
            return false;
    }
    return true;
}

/* Where the observers stand, in samples of the whole raster. */
static bool find_marks(viewshed_command *c, io_error *error) {
    product *p = &c->product;
    p->mark_count = c->observers.count;
    p->marks = malloc(2 * p->mark_count * sizeof *p->marks);
    for (size_t k = 0; p->marks && k < p->mark_count; k++)
        terrain_from_map(&p->ground.whole, c->observers.list[k].x, c->observers.list[k].y, p->marks + 2 * k);
    return p->marks != NULL || io_fail(error, "out of memory");
}

static bool describe(viewshed_command *c, io_error *error) {
    product *p = &c->product;
    const bool floats = c->kind != VIEW_SEEN;
    product_describe(p,
                     floats                        ? IO_CELL_FLOAT32
                     : most_seen(c) <= COUNT_SMALL ? IO_CELL_UINT8
                                                   : IO_CELL_UINT16,
                     c->bands ? c->observers.count : 1, meaning(c));
    if (c->kind == VIEW_NEEDED) p->raster.unit = "m";
    if (c->kind == VIEW_ANGLE) p->raster.unit = "degree";
    p->in_memory = true;
    p->counted = "in sight";
    note(c);
    return find_marks(c, error) && (!c->bands || name_bands(c, error));
}

static bool check(const viewshed_command *c, io_error *error) {
    const char *output = c->product.output;
    const size_t count = c->observers.count;
    if (count > 1 && !c->bands && (c->kind == VIEW_ANGLE || c->kind == VIEW_NEEDED))
        return io_fail(error, "%s is that of one observer, not of %zu; --bands writes a band for each",
                       c->kind == VIEW_ANGLE ? "the angle" : "the height that is needed to be seen", count);
    if (c->weights && !c->observers.has_weight)
        return io_fail(error, "%s: has no column 'weight', which --weights adds up", c->from.file);
    if (c->bands && count > TIF_BANDS_MOST && io_raster_is_tif(output))
        return io_fail(error, "%s: a GeoTIFF has room for %d bands, not for %zu", output, TIF_BANDS_MOST, count);
    return !c->bands || io_raster_can_write(output, count, error);
}

bool viewshed_begin(product *p, io_error *error) {
    viewshed_command *c = p->context;
    c->look.curvature = ground_curvature(&p->ground, c->look.curvature);
    if (!product_check_table(c->table, "--table", error)) return false;
    if (!observers_find(&c->observers, &c->from, &p->ground, error) || !skip_observers(c, false, error)) return false;
    if (c->kind == VIEW_SEEN && !c->bands && c->observers.count > COUNT_MOST) c->kind = VIEW_WEIGHT;
    if (!check(c, error) || !product_check_output(p, error) || !read_samples(c, error) ||
        !skip_observers(c, true, error))
        return false;
    if (cw_sight_bounds_create(&p->ground.terrain, &c->bounds) != CW_OK) return io_fail(error, "out of memory");
    p->ground.terrain.bounds = c->bounds;
    if ((c->within && !find_inside(c, error)) || !make_room(c, error)) return false;
    for (c->observer = 0; c->observer < c->observers.count && !c->bands; c->observer++)
        if (!look_from(c, error)) return false;
    return (c->own == NULL || io_output_settle(&c->table_file, error)) && describe(c, error);
}

bool viewshed_finish(product *p, io_error *error) {
    viewshed_command *c = p->context;
    if (c->own != NULL && !io_output_commit(&c->table_file, error)) return false;
    command_wrote(p->name, p->quiet, c->table, p->start, "views from %zu place%s", c->observers.count,
                  c->observers.count == 1 ? "" : "s");
    return true;
}

void viewshed_end(void *context) {
    viewshed_command *c = context;
    cw_sight_bounds_destroy(c->bounds);
    io_points_free(&c->observers);
    io_output_discard(&c->table_file);
    large_release(c->own);
    free(c->inside);
    large_release(c->seen);
    large_release(c->sums);
    large_release(c->numbers);
}
