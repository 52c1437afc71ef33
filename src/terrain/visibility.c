/* SPDX-License-Identifier: Apache-2.0 */
#include "visibility.h"

#include "visible.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.141592653589793;

typedef struct finding {
    const terrain *terrain;
    const visibility_desc *desc;
    cw_rectangle at;
    size_t nx, ny; /* eyes */
    cw_visible *view;
    double *area, *ground; /* ground: all within reach */
    const visibility_answers *to;

    terrain_progress *progress;
    void *context;
    double done, part; /* of all, before a call of the library and by it */
} finding;

static bool watch(void *context, double share) {
    const finding *f = context;
    return f->progress(f->context, f->done + f->part * share);
}

/* Eyes in rows that share their scale, as far as they are in the rectangle. */
typedef struct band {
    size_t row, rows; /* of the eyes */
    double middle;    /* row of the whole raster at which directions are those of the compass */
    size_t until;     /* the whole raster's row at which the next one begins */
} band;

/* Bands begin where they do for all of the raster, so that each eye has the same one in any part of it. */
static band next_band(const finding *f, size_t from) {
    const terrain *whole = terrain_whole(f->terrain);
    const size_t first = f->terrain->row + f->at.j, every = f->desc->every;
    const size_t until = from + terrain_rows_alike(whole, from);
    band b = {.middle = 0.5 * (double)(from + until - 1), .until = until};
    const size_t before = from > first ? (from - first + every - 1) / every : 0;
    const size_t end = until > first ? (until - first + every - 1) / every : 0;
    b.row = before < f->ny ? before : f->ny;
    b.rows = (end < f->ny ? end : f->ny) - b.row;
    return b;
}

typedef struct grounding {
    const finding *f;
    const band *band;
    double dir[2], reach, weight;
} grounding;

/* All ground along the direction: to the border of the whole raster, or to the reach. */
static void add_ground(void *context, size_t begin, size_t end) {
    const grounding *g = context;
    const finding *f = g->f;
    const terrain *whole = terrain_whole(f->terrain);
    for (size_t k = begin; k < end; k++) {
        const size_t row = g->band->row + k / f->nx, column = k % f->nx;
        const double at[2] = {(double)(f->terrain->column + f->at.i + column * f->desc->every),
                              (double)(f->terrain->row + f->at.j + row * f->desc->every)};
        const double out = terrain_steps_out(whole, at, g->dir) - 1, t = g->reach > 0 ? fmin(out, g->reach) : out;
        f->ground[row * f->nx + column] += g->weight * t * t / 2;
    }
}

static cw_status add_direction(finding *f, const cw_run *run, size_t number, const band *b) {
    enum { GRAIN = 1 << 14 };
    const terrain *t = f->terrain, *whole = terrain_whole(t);
    const visibility_desc *d = f->desc;
    const double azimuth = 360 * (double)number / (double)d->directions, up = terrain_metres_of_height(t);
    cw_visible_desc way = {.label = (float)azimuth};
    const double length = terrain_direction(whole, 0.5 * (double)(whole->nx - 1), b->middle, azimuth, way.dir);
    way.reach = d->max_distance / length;
    way.drop = d->curvature * length * length / (2 * t->radius * up);
    way.eye = (float)(d->eye_height / up);
    way.target = (float)(d->target_height / up);
    way.slack = terrain_has_rows(whole) ? 0x1p-7 : 0;
    way.weight = 2 * pi / (double)d->directions * length * length * 1e-6;
    way.length = length;
    const size_t first = b->row * f->nx;
    cw_visible_sums sums = {.area = f->area ? f->area + first : NULL};
    if (f->to->farthest) {
        sums.farthest = f->to->farthest + first;
        sums.direction = f->to->azimuth + first;
    }
    cw_run how = run ? *run : (cw_run){0};
    how.watch = f->progress ? watch : NULL;
    how.watch_context = f;
    const cw_status status = cw_visible_add(f->view, &how, &way, b->row, b->rows, sums);
    if (status != CW_OK || f->ground == NULL) return status;
    grounding g = {f, b, {way.dir[0], way.dir[1]}, way.reach, way.weight};
    cw_pool_run(how.pool, f->nx * b->rows, GRAIN, add_ground, &g);
    return CW_OK;
}

static cw_status add_directions(finding *f, const cw_run *run) {
    const size_t first = f->terrain->row + f->at.j, directions = f->desc->directions;
    size_t from = 0;
    while (from + terrain_rows_alike(terrain_whole(f->terrain), from) <= first)
        from += terrain_rows_alike(terrain_whole(f->terrain), from);
    for (size_t k = 0; k < directions; k++) {
        band b = {.until = from};
        do {
            b = next_band(f, b.until);
            f->done = ((double)k + (double)b.row / (double)f->ny) / (double)directions;
            f->part = (double)b.rows / (double)f->ny / (double)directions;
            const cw_status status = b.rows > 0 ? add_direction(f, run, k, &b) : CW_OK;
            if (status != CW_OK) return status;
        } while (b.row + b.rows < f->ny);
    }
    return CW_OK;
}

static void write_answers(const finding *f) {
    for (size_t k = 0; k < f->nx * f->ny; k++) {
        if (f->to->area) f->to->area[k] = (float)f->area[k];
        if (f->to->share) /* an eye at the border may have no ground at all */
            f->to->share[k] = f->ground[k] > 0 ? (float)fmin(f->area[k] / f->ground[k], 1) : (float)f->area[k];
        if (f->to->share && isnan(f->area[k])) f->to->share[k] = NAN;
    }
}

static bool is_size(double a) { return a >= 0 && isfinite(a); }

cw_status visibility_find(const terrain *t, const visibility_desc *desc, const cw_run *run, cw_rectangle at,
                          const visibility_answers *to, terrain_progress *progress, void *context, bool *done) {
    *done = false;
    if (desc->directions == 0 || desc->directions > VISIBILITY_DIRECTIONS_MOST || desc->every == 0 ||
        !(is_size(desc->eye_height) && is_size(desc->target_height) && is_size(desc->max_distance) &&
          is_size(desc->curvature)))
        return CW_ERROR_ARGUMENT;
    finding f = {.terrain = t, .desc = desc, .at = at, .to = to, .progress = progress, .context = context};
    f.nx = (at.nx + desc->every - 1) / desc->every;
    f.ny = (at.ny + desc->every - 1) / desc->every;
    const size_t n = f.nx * f.ny;
    if (n == 0) {
        *done = true;
        return CW_OK;
    }
    if (to->area || to->share) f.area = calloc(n, sizeof *f.area);
    if (to->share) f.ground = calloc(n, sizeof *f.ground);
    cw_status status = ((to->area || to->share) && !f.area) || (to->share && !f.ground) ? CW_ERROR_MEMORY : CW_OK;
    for (size_t k = 0; k < n && to->farthest; k++) {
        to->farthest[k] = 0;
        to->azimuth[k] = NAN;
    }
    if (status == CW_OK) status = cw_visible_create(t->field, at, desc->every, &f.view);
    if (status == CW_OK) status = add_directions(&f, run);
    *done = status == CW_OK;
    if (*done) write_answers(&f);
    cw_visible_destroy(f.view);
    free(f.area);
    free(f.ground);
    return status == CW_ERROR_CANCELLED ? CW_OK : status;
}
