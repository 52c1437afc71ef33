/* SPDX-License-Identifier: Apache-2.0 */
/* Walks over turned land, and where their answers go: cw_visible. */

#include "visible_land.h"

#include "codes.h"
#include "fpenv.h"
#include "sister.h"

#include <float.h>
#include <math.h>

/* ---- walks ----------------------------------------------------------------------------------------------------------- */

/* Eyes of a group's columns, and so many rows of them. */
enum { ROWS_AT_ONCE = 64 };

typedef struct walking {
    cw_visible *view;
    const visible_code *code;
    visible_job job;
    const cw_visible_desc *desc;
    size_t row, rows; /* of the answers */
    cw_visible_sums to;
    size_t wide, long_way; /* eyes across and along the land, in the part */
    size_t groups;
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
    const double aside = v->ways.aside, first = (double)((w->first_column + group * VISIBLE_GROUP) * v->every),
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
        const size_t pieces = (w->long_way + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE;
        const size_t group = k / pieces, along = k % pieces * ROWS_AT_ONCE, across = group * VISIBLE_GROUP;
        const size_t rows = w->long_way - along < ROWS_AT_ONCE ? w->long_way - along : ROWS_AT_ONCE;
        w->code->walk(&w->job, (ptrdiff_t)(w->first_column + across), w->first_row + along * v->every, v->every, rows,
                      most_rows(w, group), area, farthest);
        const size_t wide = w->wide - across < VISIBLE_GROUP ? w->wide - across : VISIBLE_GROUP;
        add_answers(w, across, wide, along, rows, area, farthest);
    }
    fpenv_leave(caller);
}

/* Of the height of a place on an edge over the eye, and of a target on it: sums, products and their rounding, each off by
 * u = 2^-24 of the heights' range (papers/numerics.md). */
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
}

static cw_status add(cw_visible *v, const cw_run *how, const cw_visible_desc *desc, size_t row, size_t rows,
                     cw_visible_sums to) {
    const double longest = fmax(fabs(desc->dir[0]), fabs(desc->dir[1]));
    cw_status status = cw_visible_turn(v, desc->dir, how);
    if (status != CW_OK) return status;
    const double sign = v->rotated ? -1 : 1, aside = sign * desc->dir[v->transposed ? 1 : 0] / longest;
    cw_visible_free_ways(&v->ways);
    v->ways.aside = fabs(aside) <= PLACE_ROUNDING ? 0 : aside;
    v->ways.reach = desc->reach * longest;
    v->ways.drop = desc->drop / (longest * longest);
    status = cw_visible_make_ways(v, &v->ways);
    if (status == CW_OK) status = cw_visible_bound(v, how, v->ways.aside, desc->slack);
    if (status != CW_OK) return status;
    const ways *s = &v->ways;
    walking w = {.view = v, .code = v->code, .desc = desc, .row = row, .rows = rows, .to = to};
    w.job = (visible_job){.land = v->memory + AROUND + VISIBLE_MARGIN,
                          .stride = v->stride,
                          .rows = v->down,
                          .crossing = s->crossing,
                          .piece = s->piece,
                          .whole = s->whole,
                          .run = s->run,
                          .sunk = s->sunk,
                          .until = s->until,
                          .entry = s->entry,
                          .steps = s->steps,
                          .reach = s->ends ? (float)s->reach : 0,
                          .look = (to.area ? VISIBLE_AREA : 0u) | (to.farthest ? VISIBLE_FARTHEST : 0u),
                          .eye = desc->eye,
                          .target = desc->target};
    if (desc->target > 0) w.job.look |= VISIBLE_TARGET | VISIBLE_HOLES;
    if (v->samples.holes > 0) w.job.look |= VISIBLE_HOLES;
    for (int l = 0; l < VISIBLE_LEVELS; l++) w.job.bound[l] = v->bound_memory[l] + AROUND + VISIBLE_MARGIN;
    if (v->has_level && !(desc->target > 0)) w.job.look |= VISIBLE_LEVEL;
    w.job.level = v->level_memory + AROUND + VISIBLE_MARGIN;
    w.job.lift = (float)((double)desc->target + rounding(&v->samples, desc->eye, desc->target));
    w.scale = 0.5 * desc->weight / (longest * longest);
    w.length = (float)(desc->length / longest);
    place_eyes(&w);
    const size_t pieces = (w.long_way + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE;
    return cw_run_work(how, w.groups * pieces, 1, 4, walk_some, &w);
}

/* ---- the interface --------------------------------------------------------------------------------------------------- */

cw_status cw_visible_create(const cw_field *field, cw_rectangle at, size_t every, cw_visible **visible) {
    if (visible == NULL) return cw_fail(CW_ERROR_ARGUMENT, "visible: NULL");
    *visible = NULL;
    if (field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    if (every == 0 || every > CW_SIDE_MAX) return cw_fail(CW_ERROR_ARGUMENT, "every: %zu", every);
    const samples of = samples_of(field);
    const cw_status in = cw_check_rectangle(field, &at);
    if (in != CW_OK) return in;
    cw_visible *v = calloc(1, sizeof *v);
    if (v == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    v->field = field;
    v->samples = of;
    v->i = at.i;
    v->j = at.j;
    v->every = every;
    v->nx = (at.nx + every - 1) / every;
    v->ny = (at.ny + every - 1) / every;
    *visible = v;
    return CW_OK;
}

void cw_visible_destroy(cw_visible *v) {
    if (v == NULL) return;
    cw_visible_free_ways(&v->ways);
    large_release(v->memory);
    for (int l = 0; l < VISIBLE_LEVELS; l++) large_release(v->bound_memory[l]);
    large_release(v->level_memory);
    free(v);
}

static bool is_size(double a, double most) { return a >= 0 && a <= most; }

cw_status cw_visible_add(cw_visible *v, const cw_run *run, const cw_visible_desc *desc, size_t row, size_t rows,
                         cw_visible_sums to) {
    if (v == NULL || desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", v ? "desc" : "visible");
    if ((to.farthest == NULL) != (to.direction == NULL))
        return cw_fail(CW_ERROR_ARGUMENT, "farthest and direction go together");
    const double *dir = desc->dir, longest = fmax(fabs(dir[0]), fabs(dir[1]));
    if (!(isfinite(dir[0]) && isfinite(dir[1]) && longest >= 0x1p-40 && longest <= 0x1p40))
        return cw_fail(CW_ERROR_ARGUMENT, "dir: (%g, %g); its longer component is from 2^-40 to 2^40", dir[0], dir[1]);
    const struct {
        const char *name;
        double value, most;
    } sizes[] = {
        {"reach", desc->reach, DBL_MAX},
        {"drop", desc->drop, (double)CW_HEIGHT_MAX / (CW_SIDE_MAX / longest)},
        {"eye", (double)desc->eye, (double)CW_HEIGHT_MAX},
        {"target", (double)desc->target, (double)CW_HEIGHT_MAX},
        {"slack", desc->slack, 0x1p-7},
        {"weight", fabs(desc->weight), DBL_MAX},
        {"length", fabs(desc->length), DBL_MAX},
    };
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++)
        if (!is_size(sizes[k].value, sizes[k].most))
            return cw_fail(CW_ERROR_ARGUMENT, "%s: %g; its limit is %g", sizes[k].name, sizes[k].value, sizes[k].most);
    if (row > v->ny || rows > v->ny - row)
        return cw_fail(CW_ERROR_ARGUMENT, "rows %zu to %zu of %zu", row, row + rows, v->ny);
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    const terrain_code *code;
    if (status == CW_OK) status = cw_terrain_settle(&how, &code);
    if (status != CW_OK || rows == 0 || v->nx == 0) return status;
    v->code = code->visible;
    door_pass in;
    if (!cw_field_enter(v->field, &in)) return cw_fail_plainly(CW_ERROR_BUSY);
    const fpenv caller = fpenv_enter();
    status = add(v, &how, desc, row, rows, to);
    fpenv_leave(caller);
    cw_field_leave(in);
    return status;
}
