/* SPDX-License-Identifier: Apache-2.0 */
/* Walks over turned land, and where their answers go: cw_visible. */

#include "visible_land.h"

#include "codes.h"
#include "fpenv.h"
#include "sister.h"

#include <float.h>
#include <math.h>

/* ---- walks ------------------------------------------------------------------------------------------------------- */

/* Eyes of a group's columns, and so many rows of them. */
enum { ROWS_AT_ONCE = 64 };

typedef struct walking {
    cw_visible *view;
    visible_job job;
    double aside; /* columns that a ray goes for each row of the land */
    const cw_visible_desc *desc;
    size_t row, rows; /* of the answers */
    cw_visible_sums to;
    size_t wide, long_way;          /* eyes across and along the land, in the part */
    size_t groups, pieces;          /* of these: columns, and rows of each */
    size_t first_column, first_row; /* of the part's first eye in the land, in eyes and rows */
    double scale;                   /* of areas */
    float length;                   /* of distances */
} walking;

/* A line of count eyes whose answers lie together in the sums, from number `to` on or backward. */
static void add_line(const walking *w, const float *area, const float *farthest, size_t apart, size_t count,
                     ptrdiff_t to, ptrdiff_t step) {
    double *sum = w->to.area;
    float *far = w->to.farthest, *direction = w->to.direction;
    for (size_t k = 0; k < count && sum; k++) sum[to + (ptrdiff_t)k * step] += w->scale * (double)area[k * apart];
    for (size_t k = 0; k < count && far; k++) {
        const ptrdiff_t at = to + (ptrdiff_t)k * step;
        const float length = farthest[k * apart] * w->length;
        if (isnan(area[k * apart])) {
            far[at] = direction[at] = NAN;
        } else if (length > far[at]) {
            far[at] = length;
            direction[at] = w->desc->label;
        }
    }
}

/* Answers of eyes in columns and rows of the land, to where their samples are in the field. */
static void add_answers(const walking *w, size_t across, size_t wide, size_t along, size_t rows, const float *area,
                        const float *farthest) {
    const cw_visible *v = w->view;
    const ptrdiff_t step = v->rotated ? -1 : 1, nx = (ptrdiff_t)v->nx;
    const size_t x = v->rotated ? w->wide - 1 - across : across, y = v->rotated ? w->long_way - 1 - along : along;
    if (v->transposed)
        for (size_t k = 0; k < wide; k++)
            add_line(w, area + k, farthest + k, VISIBLE_GROUP, rows,
                     ((ptrdiff_t)x + (ptrdiff_t)k * step) * nx + (ptrdiff_t)y, step);
    else
        for (size_t k = 0; k < rows; k++)
            add_line(w, area + k * VISIBLE_GROUP, farthest + k * VISIBLE_GROUP, 1, wide,
                     ((ptrdiff_t)y + (ptrdiff_t)k * step) * nx + (ptrdiff_t)x, step);
}

/* Rows of the land in which some ray of a group's columns is inside it, at most. */
static size_t most_rows(const walking *w, size_t group) {
    const cw_visible *v = w->view;
    const double aside = w->aside, first = (double)((w->first_column + group * VISIBLE_GROUP) * v->every),
                 before = (double)v->before, last = first + (double)((VISIBLE_GROUP - 1) * v->every);
    const double columns = aside > 0 ? (double)(v->across - 1) - (first - before) : last - before;
    return aside == 0 ? SIZE_MAX : (size_t)fmin(ceil(fmax(columns, 0) / fabs(aside)) + 1, 0x1p30);
}

static void walk_some(void *context, size_t begin, size_t end) {
    const walking *w = context;
    const cw_visible *v = w->view;
    float area[ROWS_AT_ONCE * VISIBLE_GROUP], farthest[ROWS_AT_ONCE * VISIBLE_GROUP];
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++) {
        const size_t group = k / w->pieces, along = k % w->pieces * ROWS_AT_ONCE, across = group * VISIBLE_GROUP;
        const size_t rows = w->long_way - along < ROWS_AT_ONCE ? w->long_way - along : ROWS_AT_ONCE;
        v->code->walk(&w->job, (ptrdiff_t)(w->first_column + across), w->first_row + along * v->every, v->every, rows,
                      most_rows(w, group), area, farthest);
        const size_t wide = w->wide - across < VISIBLE_GROUP ? w->wide - across : VISIBLE_GROUP;
        add_answers(w, across, wide, along, rows, area, farthest);
    }
    fpenv_leave(caller);
}

/* Of the height of a place on an edge over the eye, and of a target on it: sums, products and their rounding, each off
 * by u = 2^-24 of the heights' range (papers/numerics.md). */
static double rounding(const samples *f, float eye, float target) {
    const double range = f->high >= f->low ? (double)f->high - (double)f->low : 0;
    return 8 * (double)FLT_EPSILON * (range + (double)eye + (double)target) + (double)FLT_MIN;
}

static void place_eyes(walking *w) {
    const cw_visible *v = w->view;
    w->wide = v->transposed ? w->rows : v->nx;
    w->long_way = v->transposed ? v->nx : w->rows;
    const size_t j = v->j + w->row * v->every;
    const size_t column = v->transposed ? j : v->i, row = v->transposed ? v->i : j, span = v->every;
    const size_t first = v->rotated ? v->across - 1 - (column + (w->wide - 1) * span) : column;
    w->first_column = (first + v->before) / v->every;
    w->first_row = v->rotated ? v->down - 1 - (row + (w->long_way - 1) * span) : row;
    w->groups = (w->wide + VISIBLE_GROUP - 1) / VISIBLE_GROUP;
    w->pieces = (w->long_way + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE;
}

/* ---- the interface ----------------------------------------------------------------------------------------------- */

cw_status cw_visible_create(const cw_field *field, cw_rectangle at, size_t every, cw_visible **visible) {
    cw_visible *v = *visible = calloc(1, sizeof *v);
    if (v == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    v->samples = samples_of(field);
    v->i = at.i;
    v->j = at.j;
    v->every = every;
    v->nx = (at.nx + every - 1) / every;
    return CW_OK;
}

void cw_visible_destroy(cw_visible *v) {
    for (int k = 0; k < ARRAYS && v; k++) large_release(v->array[k].at);
    free(v);
}

cw_status cw_visible_add(cw_visible *v, const cw_run *run, const cw_visible_desc *desc, size_t row, size_t rows,
                         cw_visible_sums to) {
    const double longest = fmax(fabs(desc->dir[0]), fabs(desc->dir[1]));
    walking w = {.view = v, .desc = desc, .row = row, .rows = rows, .to = to};
    cw_run quiet = *run; /* to make the land ready */
    quiet.watch = NULL;
    const terrain_code *code;
    cw_status status = cw_terrain_settle(&quiet, &code);
    if (status != CW_OK) return status;
    v->code = code->visible;
    status = cw_visible_turn(v, desc->dir, &quiet);
    if (status != CW_OK) return status;
    const double sign = v->rotated ? -1 : 1, aside = sign * desc->dir[v->transposed ? 1 : 0] / longest;
    w.aside = fabs(aside) <= PLACE_ROUNDING ? 0 : aside;
    status = cw_visible_make_ways(v, w.aside, desc->reach * longest, desc->drop / (longest * longest), &w.job);
    if (status == CW_OK) status = cw_visible_bound(v, &quiet, w.aside, desc->slack);
    if (status != CW_OK) return status;
    w.job.land = v->array[LAND].at + AROUND + VISIBLE_MARGIN;
    w.job.stride = v->stride;
    w.job.rows = v->down;
    for (int l = 0; l < VISIBLE_LEVELS; l++) w.job.bound[l] = v->array[BOUND + l].at + AROUND + VISIBLE_MARGIN;
    w.job.level = v->array[LEVEL].at + AROUND + VISIBLE_MARGIN;
    w.job.eye = desc->eye;
    w.job.target = desc->target;
    w.job.lift = (float)((double)desc->target + rounding(&v->samples, desc->eye, desc->target));
    w.job.look = (to.area ? VISIBLE_AREA : 0u) | (to.farthest ? VISIBLE_FARTHEST : 0u);
    if (desc->target > 0) w.job.look |= VISIBLE_TARGET | VISIBLE_HOLES;
    if (v->samples.holes > 0) w.job.look |= VISIBLE_HOLES;
    if (v->has_level && !(desc->target > 0)) w.job.look |= VISIBLE_LEVEL;
    w.scale = 0.5 * desc->weight / (longest * longest);
    w.length = (float)(desc->length / longest);
    place_eyes(&w);
    return cw_run_work(run, w.groups * w.pieces, 1, 4, walk_some, &w);
}
