/* SPDX-License-Identifier: Apache-2.0 */
/* How much every place sees: the ground in sight of an eye above each sample, along even directions.
 *
 * Along each direction the parts of the surface in sight are exact (cw_visible_add). The area is the sum over directions of
 * (2 π / count) ∫ t dt over the distances t in sight: papers/terrain.md has its error by the number of directions. */
#include "area.h"
#include "visible.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIRECTIONS_USUAL = 128, DIRECTIONS_MOST = 3600 };

static const double pi = 3.141592653589793;

typedef struct finding {
    const terrain *terrain;
    const cw_visibility_desc *desc;
    cw_rectangle at;
    size_t nx, ny; /* eyes */
    cw_visible *view;
    double *area, *ground; /* ground: all within reach */
    float *farthest, *direction;
    const cw_visibility_answers *to;
    size_t every, directions, stride;
} finding;

/* Eyes in rows that share their scale, as far as they are in the rectangle. */
typedef struct band {
    size_t row, rows; /* of the eyes */
    double middle;    /* row of the whole raster at which directions are those of the compass */
    size_t until;     /* the whole raster's row at which the next one begins */
} band;

/* Bands begin where they do for all of the raster, so that each eye has the same one in any part of it. */
static band next_band(const finding *f, size_t from) {
    const terrain *whole = terrain_whole(f->terrain);
    const size_t first = f->terrain->row + f->at.j, every = f->every;
    const size_t until = from + cw_terrain_rows_alike(whole, from);
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
        const double at[2] = {(double)(f->terrain->column + f->at.i + column * f->every),
                              (double)(f->terrain->row + f->at.j + row * f->every)};
        const double out = cw_terrain_steps_out(whole, at, g->dir) - 1, t = g->reach > 0 ? fmin(out, g->reach) : out;
        f->ground[row * f->nx + column] += g->weight * t * t / 2;
    }
}

static cw_status add_direction(finding *f, const cw_run *run, size_t number, const band *b) {
    enum { GRAIN = 1 << 14 };
    const terrain *t = f->terrain, *whole = terrain_whole(t);
    const cw_visibility_desc *d = f->desc;
    const double azimuth = 360 * (double)number / (double)f->directions, up = terrain_metres_of_height(t);
    cw_visible_desc way = {.label = (float)azimuth};
    const double length = cw_terrain_direction(whole, 0.5 * (double)(whole->nx - 1), b->middle, azimuth, way.dir);
    way.reach = d->max_distance / length;
    way.drop = d->curvature * length * length / (2 * t->radius * up);
    way.eye = (float)(d->height / up);
    way.target = (float)(d->target / up);
    way.slack = terrain_has_rows(whole) ? 0x1p-7 : 0;
    way.weight = 2 * pi / (double)f->directions * length * length * 1e-6;
    way.length = length;
    const size_t first = b->row * f->nx;
    cw_visible_sums sums = {.area = f->area ? f->area + first : NULL};
    if (f->farthest) {
        sums.farthest = f->farthest + first;
        sums.direction = f->direction + first;
    }
    const cw_status status = cw_visible_add(f->view, run, &way, b->row, b->rows, sums);
    if (status != CW_OK || f->ground == NULL) return status;
    grounding g = {f, b, {way.dir[0], way.dir[1]}, way.reach, way.weight};
    cw_pool_run(run->pool, f->nx * b->rows, GRAIN, add_ground, &g);
    return CW_OK;
}

static cw_status add_directions(finding *f, const cw_run *run) {
    const size_t first = f->terrain->row + f->at.j;
    size_t from = 0;
    while (from + cw_terrain_rows_alike(terrain_whole(f->terrain), from) <= first)
        from += cw_terrain_rows_alike(terrain_whole(f->terrain), from);
    for (size_t k = 0; k < f->directions; k++) {
        band b = {.until = from};
        run_part whole;
        const cw_run direction = cw_run_share(&whole, run, k, f->directions);
        do {
            b = next_band(f, b.until);
            run_part part = {&direction, (double)b.row / (double)f->ny, (double)(b.row + b.rows) / (double)f->ny};
            const cw_run some = cw_run_part_of(&part);
            const cw_status status = b.rows > 0 ? add_direction(f, &some, k, &b) : CW_OK;
            if (status != CW_OK) return status;
        } while (b.row + b.rows < f->ny);
    }
    return CW_OK;
}

static void write_answers(const finding *f) {
    const cw_visibility_answers *to = f->to;
    for (size_t k = 0; k < f->nx * f->ny; k++) {
        const size_t at = k / f->nx * f->stride + k % f->nx;
        if (to->area) to->area[at] = (float)f->area[k];
        if (to->share) /* an eye at the border may have no ground at all */
            to->share[at] = isnan(f->area[k])  ? NAN
                            : f->ground[k] > 0 ? (float)fmin(f->area[k] / f->ground[k], 1)
                                               : (float)f->area[k];
        if (to->farthest) to->farthest[at] = f->farthest[k];
        if (to->azimuth) to->azimuth[at] = f->direction[k];
    }
}

static cw_status check(const cw_visibility_desc *d, const cw_visibility_answers *to) {
    if (to == NULL) return cw_fail(CW_ERROR_ARGUMENT, "answers: NULL");
    cw_status status = cw_check_zeros(d->reserved, 0, "cw_visibility_desc");
    if (status == CW_OK) status = cw_check_zeros(to->reserved, 0, "cw_visibility_answers");
    if (status == CW_OK) status = cw_check_number("height", d->height, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("target", d->target, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("max_distance", d->max_distance, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("directions", d->directions, 0, DIRECTIONS_MOST);
    if (status == CW_OK) status = cw_check_number("every", d->every, 0, CW_SIDE_MAX);
    return status;
}

static cw_status find(finding *f, const cw_run *run) {
    const cw_visibility_answers *to = f->to;
    const size_t n = f->nx * f->ny;
    const bool areas = to->area || to->share, far = to->farthest || to->azimuth;
    if (areas) f->area = calloc(n, sizeof *f->area);
    if (to->share) f->ground = calloc(n, sizeof *f->ground);
    if (far) f->farthest = calloc(n, sizeof *f->farthest);
    if (far) f->direction = malloc(n * sizeof *f->direction);
    if ((areas && !f->area) || (to->share && !f->ground) || (far && !(f->farthest && f->direction)))
        return cw_fail_plainly(CW_ERROR_MEMORY);
    for (size_t k = 0; k < n && far; k++) f->direction[k] = NAN;
    cw_status status = cw_visible_create(f->terrain->field, f->at, f->every, &f->view);
    if (status == CW_OK) status = add_directions(f, run);
    if (status == CW_OK) write_answers(f);
    cw_visible_destroy(f->view);
    return status;
}

cw_status cw_visibility(const cw_terrain *t, const cw_run *run, const cw_visibility_desc *desc, cw_area area,
                        const cw_visibility_answers *answers) {
    cw_run how;
    cw_status status = cw_area_begin(t, desc, "desc", run, &area, &how);
    if (status == CW_OK) status = check(desc, answers);
    if (status != CW_OK) return status;
    finding f = {.terrain = t, .desc = desc, .at = area.at, .to = answers};
    /* One eye a row and column is least; memory grows with every. */
    const size_t side = area.at.nx > area.at.ny ? area.at.nx : area.at.ny;
    f.every = desc->every > 0 ? desc->every : 1;
    if (f.every > side && side > 0) f.every = side;
    f.directions = desc->directions > 0 ? desc->directions : DIRECTIONS_USUAL;
    f.nx = (area.at.nx + f.every - 1) / f.every;
    f.ny = (area.at.ny + f.every - 1) / f.every;
    f.stride = area.stride > 0 ? area.stride : f.nx;
    if (f.stride < f.nx) return cw_fail(CW_ERROR_ARGUMENT, "stride: %zu; a row has %zu eyes", f.stride, f.nx);
    if (f.nx * f.ny > 0) status = find(&f, &how);
    free(f.area);
    free(f.ground);
    free(f.farthest);
    free(f.direction);
    return status;
}
