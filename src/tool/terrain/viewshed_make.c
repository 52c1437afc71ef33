/* SPDX-License-Identifier: Apache-2.0 */
#include "viewshed_make.h"

#include "output.h"
#include "pieces.h"
#include "view_sum.h"
#include "viewshed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COUNT_SMALL = 254, COUNT_MOST = 65534, TIF_BANDS_MOST = 65535 };

typedef struct job {
    ground *ground;
    const viewshed_request *request;
    observers observers;
    view_kind kind; /* the request's; counts that two bytes do not hold are sums */
    sight_bounds *bounds;
    uint16_t *seen; /* one of these */
    double *sums;
    float *numbers;
    size_t observer; /* whose view is being computed */
    size_t made;     /* of bands: the views so far */
    uint16_t *own;   /* what one observer sees; NULL: there is no table */
    io_output table;
} job;

static bool tell(void *context, double share) {
    job *j = context;
    return ground_tell(j->ground, ((double)j->observer + share) / (double)j->observers.count);
}

/* ---- samples ------------------------------------------------------------------------------------------------------- */

/* The samples that one observer's answers in the window come from. */
static cw_rectangle samples_of(const job *j, const double at[2]) {
    const ground *g = j->ground;
    const cw_rectangle all = pieces_all(g);
    const double farthest = j->request->target.limits.farthest;
    if (farthest > 0) return reach_around(&g->whole, at, farthest);
    /* Needed heights are rounded, and how depends on more than the lines. */
    const bool whole = g->window.nx == all.nx && g->window.ny == all.ny;
    return whole || j->kind == VIEW_NEEDED ? all : reach_between(&g->whole, at, g->window);
}

/* Reads the part that all observers need, and sets the window to the part that they can see. */
static bool read_samples(job *j, io_error *error) {
    const double farthest = j->request->target.limits.farthest;
    ground *g = j->ground;
    cw_rectangle near = {0}, piece = {0};
    for (size_t k = 0; k < j->observers.count; k++) {
        char text[OBSERVER_TEXT];
        double at[2];
        const observer *o = &j->observers.list[k];
        if (!terrain_find_place(&g->whole, o->x, o->y, at))
            return io_fail(error, "%s: is too far away from the terrain", observers_place(&j->observers, k, text).text);
        near = reach_both(near, reach_within(&g->whole, at, farthest));
    }
    if (farthest > 0 && !j->request->full && g->options->window == NULL) {
        if (near.nx == 0)
            return io_fail(error,
                           "no sample is within %g m of any observer; --extent full writes a raster all the same",
                           farthest);
        pieces_set_window(g, near);
    }
    for (size_t k = 0; k < j->observers.count; k++) {
        double at[2];
        terrain_find_place(&g->whole, j->observers.list[k].x, j->observers.list[k].y, at);
        piece = reach_both(piece, samples_of(j, at));
    }
    piece = reach_grow(&g->whole, reach_both(piece, g->window), 0);
    const double more = (j->kind == VIEW_WEIGHT ? (double)(sizeof *j->sums - sizeof(float))
                                                : 0) + /* sums are longer than other results */
                        (j->request->table ? (double)sizeof *j->own : 0);
    return pieces_check(g, piece, more, error) && pieces_read(g, piece, false, error);
}

/* ---- views ----------------------------------------------------------------------------------------------------------- */

/* The line of the table about one observer's view of the window, which is then added to those before. */
static bool print_view(job *j, const double eye[3], io_error *error) {
    const terrain *t = &j->ground->terrain;
    const cw_rectangle w = j->ground->window;
    const observer *o = &j->observers.list[j->observer];
    const view_sum v = view_sum_of(t, (cw_rectangle){w.i - t->column, w.j - t->row, w.nx, w.ny}, j->own, eye);
    for (size_t k = 0; k < t->nx * t->ny; k++) {
        if (j->seen) j->seen[k] = (uint16_t)(j->seen[k] + j->own[k]);
        if (j->sums) j->sums[k] += j->own[k];
    }
    if (!io_output_print(&j->table, error, "%zu,%.12g,%.12g,%.0f,%.9g,", j->observer + 1, o->x, o->y, v.samples, v.km2))
        return false;
    if (v.samples == 0) return io_output_print(&j->table, error, ",,\n");
    return io_output_print(&j->table, error, "%.3f,%.12g,%.12g\n", v.farthest, v.farthest_at[0], v.farthest_at[1]);
}

static bool look_from(job *j, io_error *error) {
    const viewshed_request *r = j->request;
    const terrain *t = &j->ground->terrain;
    const cw_run *query = &j->ground->query;
    char text[OBSERVER_TEXT];
    double eye[3];
    const ground_place place = observers_place(&j->observers, j->observer, text);
    if (!ground_find_place(t, &place, eye, NULL, error)) return false;
    const viewshed_desc d = {
        .place = {eye[0], eye[1]},
        .height = eye[2] * terrain_metres_of_height(t),
        .absolute = true,
        .target_height = r->target.height,
        .curvature = ground_curvature(j->ground, r->curvature),
        .limits = r->target.limits,
    };
    const double weight = r->kind == VIEW_WEIGHT ? j->observers.list[j->observer].weight : 1;
    viewshed *v;
    bool done = false;
    cw_status status = viewshed_create(t, j->bounds, &d, &v);
    if (j->own) memset(j->own, 0, t->nx * t->ny * sizeof *j->own);
    if (status == CW_OK)
        status = j->own                   ? viewshed_count(v, query, j->own, tell, j, &done)
                 : j->kind == VIEW_NEEDED ? viewshed_heights(v, query, j->numbers, tell, j, &done)
                 : j->kind == VIEW_ANGLE  ? viewshed_angles(v, query, j->numbers, tell, j, &done)
                 : j->kind == VIEW_WEIGHT ? viewshed_weigh(v, query, weight, j->sums, tell, j, &done)
                                          : viewshed_count(v, query, j->seen, tell, j, &done);
    viewshed_destroy(v);
    if (status != CW_OK) return io_fail(error, "%s", cw_status_message(status));
    if (!done) return io_fail(error, "interrupted");
    return j->own == NULL || print_view(j, eye, error);
}

static bool make_room(job *j, io_error *error) {
    const size_t n = j->ground->terrain.nx * j->ground->terrain.ny;
    if (j->request->table) {
        static const char head[] = "observer,x,y,samples,km2,farthest,farthest_x,farthest_y\n";
        j->own = malloc(n * sizeof *j->own);
        if (j->own == NULL) return io_fail(error, "out of memory");
        if (!io_output_open(&j->table, j->request->table, error) ||
            !io_output_write(&j->table, head, sizeof head - 1, error))
            return false;
    }
    if (j->kind == VIEW_SEEN)
        j->seen = calloc(n, sizeof *j->seen);
    else if (j->kind == VIEW_WEIGHT)
        j->sums = calloc(n, sizeof *j->sums);
    else
        j->numbers = malloc(n * sizeof *j->numbers);
    return j->seen || j->sums || j->numbers || io_fail(error, "out of memory");
}

/* The view of a band's observer, when the band is begun. */
static bool begin_band(job *j, size_t band, io_error *error) {
    const terrain *t = &j->ground->terrain;
    j->observer = band;
    if (j->seen) memset(j->seen, 0, t->nx * t->ny * sizeof *j->seen);
    if (!look_from(j, error)) return false;
    j->made = band + 1;
    return true;
}

static size_t most_seen(const job *j) { return j->request->bands ? 1 : j->observers.count; }

static bool fill(void *context, size_t band, size_t row, size_t rows, void *cells, io_error *error) {
    job *j = context;
    const terrain *t = &j->ground->terrain;
    const size_t first = row * t->nx, n = rows * t->nx;
    const float *z = t->z + first;
    if (j->request->bands && j->made <= band && !begin_band(j, band, error)) return false;
    if (j->numbers) {
        const double metres = terrain_metres_of_height(t);
        float *to = memcpy(cells, j->numbers + first, n * sizeof *to);
        for (size_t k = 0; k < n && j->request->absolute; k++) to[k] = (float)(to[k] + z[k] * metres);
    } else if (j->sums) {
        float *to = cells;
        for (size_t k = 0; k < n; k++) to[k] = isfinite(z[k]) ? (float)j->sums[first + k] : NAN;
    } else if (most_seen(j) <= COUNT_SMALL) {
        uint8_t *to = cells;
        for (size_t k = 0; k < n; k++) to[k] = isfinite(z[k]) ? (uint8_t)j->seen[first + k] : 255;
    } else {
        uint16_t *to = cells;
        for (size_t k = 0; k < n; k++) to[k] = isfinite(z[k]) ? j->seen[first + k] : 65535;
    }
    return true;
}

/* ---- the raster ------------------------------------------------------------------------------------------------------ */

static const char *meaning(const job *j) {
    switch (j->kind) {
    case VIEW_WEIGHT:
        return j->request->kind == VIEW_WEIGHT ? "sum of the weights of the observers that see the target"
                                               : "number of observers that see the target";
    case VIEW_ANGLE:
        return "angle of the target above the observer's horizontal; no data where it is not seen";
    case VIEW_NEEDED:
        return j->request->absolute ? "height that is needed to be seen, absolute"
                                    : "height above ground that is needed to be seen";
    case VIEW_SEEN:
        break;
    }
    return most_seen(j) > 1 ? "number of observers that see the target"
                            : "1 where the target is seen, 0 where it is not";
}

static void note(const job *j, ground_notes *notes) {
    const observers *all = &j->observers;
    const viewshed_request *r = j->request;
    if (r->observers.file) ground_note(notes, "OBSERVERS_FILE=%s", r->observers.file);
    if (r->observers.every > 0) ground_note(notes, "OBSERVERS_EVERY=%.9g", r->observers.every);
    ground_note(notes, "HEIGHTS=metres; an observer's third number is above ground, or absolute behind =");
    if (j->kind != VIEW_NEEDED) ground_note(notes, "TARGET_HEIGHT=%.9g", r->target.height);
    target_note(&r->target, notes);
    ground_note(notes, "CURVATURE=%.9g", ground_curvature(j->ground, r->curvature));
    ground_note(notes, "OBSERVERS=%zu", all->count);
    /* As many as there is room for. */
    for (size_t k = 0; k < all->count; k++) {
        const observer *o = &all->list[k];
        char x[GROUND_NUMBER], y[GROUND_NUMBER], z[GROUND_NUMBER];
        ground_note(notes, "OBSERVER_%zu=%s,%s,%s%s", k + 1, ground_number(o->x, x), ground_number(o->y, y),
                    o->absolute ? "=" : "", ground_number(o->z, z));
        const char *name = observers_name(all, k);
        if (name[0] != '\0') ground_note(notes, "OBSERVER_%zu_NAME=%s", k + 1, name);
    }
}

/* Names of bands, which the caller frees with the array. */
static char **name_bands(const job *j) {
    enum { LONGEST = 160 };
    const size_t count = j->observers.count;
    char **names = malloc(count * (sizeof *names + LONGEST));
    char *text = names ? (char *)(names + count) : NULL;
    for (size_t k = 0; names && k < count; k++, text += LONGEST) {
        const observer *o = &j->observers.list[k];
        const char *name = observers_name(&j->observers, k);
        snprintf(names[k] = text, LONGEST, "observer %zu%s%s%s at %.10g,%.10g", k + 1, name[0] ? " (" : "", name,
                 name[0] ? ")" : "", o->x, o->y);
    }
    return names;
}

/* Where the observers stand, in samples of the whole raster. */
static double *find_marks(const job *j) {
    double *marks = malloc(2 * j->observers.count * sizeof *marks);
    for (size_t k = 0; marks && k < j->observers.count; k++)
        terrain_from_map(&j->ground->whole, j->observers.list[k].x, j->observers.list[k].y, marks + 2 * k);
    return marks;
}

static bool write_raster(job *j, io_error *error) {
    const bool bands = j->request->bands, floats = j->kind != VIEW_SEEN;
    const char *what = meaning(j);
    ground_notes notes = {0};
    io_raster_product product = ground_product(j->ground,
                                               floats                        ? IO_CELL_FLOAT32
                                               : most_seen(j) <= COUNT_SMALL ? IO_CELL_UINT8
                                                                             : IO_CELL_UINT16,
                                               bands ? j->observers.count : 1, &what, &notes);
    char **names = bands ? name_bands(j) : NULL;
    bool good = names || !bands || io_fail(error, "out of memory");
    if (names) product.band_names = (const char *const *)names;
    product.white = j->kind == VIEW_NEEDED ? 100 : (double)most_seen(j);
    if (j->kind == VIEW_ANGLE) product.black = -90, product.white = 90;
    if (j->kind == VIEW_NEEDED) product.unit = "m";
    if (j->kind == VIEW_ANGLE) product.unit = "degree";
    note(j, &notes);
    product.notes = notes.notes;
    double *marks = find_marks(j);
    good = good && (marks != NULL || io_fail(error, "out of memory"));
    j->ground->counted = "in sight";
    j->ground->marks = marks;
    j->ground->mark_count = j->observers.count;
    good = good && ground_write(j->ground, &product, 1, fill, j, error);
    j->ground->marks = NULL;
    ground_notes_free(&notes);
    free(marks);
    free(names);
    return good;
}

static bool check(const job *j, io_error *error) {
    const viewshed_request *r = j->request;
    const char *output = j->ground->options->output;
    const size_t count = j->observers.count;
    if (count > 1 && !r->bands && (r->kind == VIEW_ANGLE || r->kind == VIEW_NEEDED))
        return io_fail(error, "%s is that of one observer, not of %zu; --bands writes a band for each",
                       r->kind == VIEW_ANGLE ? "the angle" : "the height that is needed to be seen", count);
    if (r->kind == VIEW_WEIGHT && !observers_have_weights(&j->observers))
        return io_fail(error, "%s: has no column 'weight', which --weights adds up", r->observers.file);
    if (r->bands && count > TIF_BANDS_MOST && io_raster_is_tif(output))
        return io_fail(error, "%s: a GeoTIFF has room for %d bands, not for %zu", output, TIF_BANDS_MOST, count);
    return !r->bands || io_raster_can_write(output, count, error);
}

static bool make(job *j, io_error *error) {
    if (!observers_find(&j->observers, &j->request->observers, j->ground, error)) return false;
    if (j->kind == VIEW_SEEN && !j->request->bands && j->observers.count > COUNT_MOST) j->kind = VIEW_WEIGHT;
    if (!check(j, error) || !ground_check_output(j->ground, error) || !read_samples(j, error)) return false;
    if (sight_bounds_create(&j->ground->terrain, &j->bounds) != CW_OK) return io_fail(error, "out of memory");
    if (!make_room(j, error)) return false;
    for (j->observer = 0; j->observer < j->observers.count && !j->request->bands; j->observer++)
        if (!look_from(j, error)) return false;
    if (j->own && !io_output_settle(&j->table, error)) return false;
    return write_raster(j, error) && (j->own == NULL || io_output_commit(&j->table, error));
}

bool viewshed_make(ground *g, const viewshed_request *request, io_error *error) {
    job j = {.ground = g, .request = request, .kind = request->kind};
    const bool good = make(&j, error);
    sight_bounds_destroy(j.bounds);
    observers_free(&j.observers);
    io_output_discard(&j.table);
    free(j.own);
    free(j.seen);
    free(j.sums);
    free(j.numbers);
    return good;
}
