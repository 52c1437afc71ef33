/* SPDX-License-Identifier: Apache-2.0 */
/* How much every place sees: the ground in sight of an eye above each sample, along even directions.
 *
 * Along each direction the parts of the surface in sight are exact (cw_visible_add). The area is the sum over
 * directions of (2 π / count) ∫ t dt over the distances t in sight: papers/terrain.md has its error by count. */
#include "area.h"
#include "fpenv.h"
#include "visible.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { DIRECTIONS_USUAL = 128, DIRECTIONS_MOST = 3600 };

static const double pi = 3.141592653589793;

typedef struct finding {
    const terrain *terrain, *whole;
    const cw_visibility_desc *desc;
    cw_rectangle at;
    size_t nx, ny; /* eyes */
    cw_visible *view;
    double *area, *ground; /* ground: all within reach */
    float *farthest, *azimuth;
    size_t every, directions;
} finding;

/* Eyes in rows of the whole raster before that one. */
static size_t eyes_before(const finding *f, size_t row) {
    const size_t first = f->terrain->row + f->at.j, rows = row > first ? (row - first + f->every - 1) / f->every : 0;
    return rows < f->ny ? rows : f->ny;
}

/* Rows of eyes from one on, and the direction in which they look. */
typedef struct looking {
    const finding *f;
    cw_visible_desc way;
    size_t row;
} looking;

/* All ground along the direction: to the border of the whole raster, or to the reach. */
static void add_ground(void *context, size_t begin, size_t end) {
    const looking *l = context;
    const finding *f = l->f;
    for (size_t k = begin; k < end; k++) {
        const size_t row = l->row + k / f->nx, column = k % f->nx;
        const double at[2] = {(double)(f->terrain->column + f->at.i + column * f->every),
                              (double)(f->terrain->row + f->at.j + row * f->every)};
        const double out = cw_terrain_steps_out(f->whole, at, l->way.dir) - 1;
        const double t = l->way.reach > 0 ? fmin(out, l->way.reach) : out;
        f->ground[row * f->nx + column] += l->way.weight * t * t / 2;
    }
}

/* middle: row of the whole raster at which directions are those of the compass. */
static cw_status add_direction(finding *f, const cw_run *run, size_t number, size_t row, size_t rows, double middle) {
    enum { GRAIN = 1 << 14 };
    const terrain *t = f->terrain;
    const cw_visibility_desc *d = f->desc;
    const double azimuth = 360 * (double)number / (double)f->directions, up = terrain_metres_of_height(t);
    looking l = {.f = f, .row = row};
    cw_visible_desc *way = &l.way;
    const double length = cw_terrain_direction(f->whole, 0.5 * (double)(f->whole->nx - 1), middle, azimuth, way->dir);
    way->label = (float)azimuth;
    way->reach = d->max_distance / length;
    way->drop = d->curvature * length * length / (2 * t->radius * up);
    way->eye = (float)(d->height / up);
    way->target = (float)(d->target / up);
    way->slack = terrain_has_rows(f->whole) ? 0x1p-7 : 0;
    way->weight = 2 * pi / (double)f->directions * length * length * 1e-6;
    way->length = length;
    if (!(way->drop <= (double)CW_HEIGHT_MAX / CW_SIDE_MAX && way->weight > 0 && way->weight <= DBL_MAX))
        return cw_fail(CW_ERROR_ARGUMENT, "curvature: %g; with cells of %g m that is too much", d->curvature, length);
    const size_t first = row * f->nx;
    cw_visible_sums sums = {.area = f->area ? f->area + first : NULL};
    if (f->farthest) {
        sums.farthest = f->farthest + first;
        sums.direction = f->azimuth + first;
    }
    const cw_status status = cw_visible_add(f->view, run, way, row, rows, sums);
    if (status == CW_OK && f->ground) cw_pool_run(run->pool, f->nx * rows, GRAIN, add_ground, &l);
    return status;
}

/* Eyes in rows that share their scale look together. These rows begin where they do for all of the raster, so that each
 * eye has the same ones in any part of it. */
static cw_status add_directions(finding *f, const cw_run *run) {
    size_t start = 0;
    while (eyes_before(f, start + cw_terrain_rows_alike(f->whole, start)) == 0)
        start += cw_terrain_rows_alike(f->whole, start);
    for (size_t k = 0; k < f->directions; k++) {
        const cw_run direction = cw_run_share(&(run_part){0}, run, k, k + 1, f->directions);
        for (size_t from = start, until, row = 0, end; row < f->ny; from = until, row = end) {
            until = from + cw_terrain_rows_alike(f->whole, from);
            end = eyes_before(f, until);
            if (end == row) continue;
            const cw_run some = cw_run_share(&(run_part){0}, &direction, row, end, f->ny);
            const cw_status status = add_direction(f, &some, k, row, end - row, 0.5 * (double)(from + until - 1));
            if (status != CW_OK) return status;
        }
    }
    return CW_OK;
}

static void write_answers(const finding *f, const cw_visibility_answers *to, size_t stride) {
    for (size_t k = 0; k < f->nx * f->ny; k++) {
        const size_t at = k / f->nx * stride + k % f->nx;
        if (to->area) to->area[at] = (float)f->area[k];
        if (to->share) /* an eye at the border may have no ground at all */
            to->share[at] = isnan(f->area[k])  ? NAN
                            : f->ground[k] > 0 ? (float)fmin(f->area[k] / f->ground[k], 1)
                                               : (float)f->area[k];
        if (to->farthest) to->farthest[at] = f->farthest[k];
        if (to->azimuth) to->azimuth[at] = f->azimuth[k];
    }
}

static cw_status check(const cw_visibility_desc *d, const cw_visibility_answers *to, double up) {
    if (to == NULL) return cw_fail(CW_ERROR_ARGUMENT, "answers: NULL");
    cw_status status = cw_check_reserved(d->reserved, 8, 0, "cw_visibility_desc");
    if (status == CW_OK) status = cw_check_reserved(to->reserved, 8, 0, "cw_visibility_answers");
    if (status == CW_OK) status = cw_check_number("height", d->height, 0, (double)CW_HEIGHT_MAX * up);
    if (status == CW_OK) status = cw_check_number("target", d->target, 0, (double)CW_HEIGHT_MAX * up);
    if (status == CW_OK) status = cw_check_number("max_distance", d->max_distance, 0, DBL_MAX);
    if (status == CW_OK) status = cw_check_number("curvature", d->curvature, 0, 1e9);
    if (status == CW_OK) status = cw_check_number("directions", d->directions, 0, DIRECTIONS_MOST);
    if (status == CW_OK) status = cw_check_number("every", d->every, 0, CW_SIDE_MAX);
    return status;
}

static cw_status find(finding *f, const cw_run *run, const cw_visibility_answers *to, size_t stride) {
    const size_t n = f->nx * f->ny;
    double *sums = calloc(n, 2 * sizeof(double) + 2 * sizeof(float));
    if (sums == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    if (to->area || to->share) f->area = sums;
    if (to->share) f->ground = sums + n;
    if (to->farthest || to->azimuth) {
        f->farthest = (float *)(sums + 2 * n);
        f->azimuth = f->farthest + n;
        for (size_t k = 0; k < n; k++) f->azimuth[k] = NAN;
    }
    cw_status status = cw_visible_create(f->terrain->field, f->at, f->every, &f->view);
    if (status == CW_OK) status = add_directions(f, run);
    if (status == CW_OK) write_answers(f, to, stride);
    cw_visible_destroy(f->view);
    free(sums);
    return status;
}

cw_status cw_visibility(const cw_terrain *t, const cw_run *run, const cw_visibility_desc *desc, cw_area area,
                        const cw_visibility_answers *answers) {
    FPENV_HERE;
    cw_run how;
    const size_t every = desc && desc->every > 0 ? desc->every : 1;
    cw_status status = cw_area_begin(t, desc, "desc", run, every, &area, &how);
    if (status == CW_OK) status = check(desc, answers, terrain_metres_of_height(t));
    if (status != CW_OK) return status;
    finding f = {.terrain = t, .whole = terrain_whole(t), .desc = desc, .at = area.at, .every = every};
    /* One eye a row and column is least; memory grows with every. */
    const size_t side = area.at.nx > area.at.ny ? area.at.nx : area.at.ny;
    if (f.every > side && side > 0) f.every = side;
    f.directions = desc->directions > 0 ? desc->directions : DIRECTIONS_USUAL;
    f.nx = (area.at.nx + f.every - 1) / f.every;
    f.ny = (area.at.ny + f.every - 1) / f.every;
    if (f.nx * f.ny == 0) return CW_OK;
    door_pass in;
    if (!cw_field_enter(t->field, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    status = find(&f, &how, answers, area.stride);
    cw_field_leave(in);
    return status;
}
