/* SPDX-License-Identifier: Apache-2.0 */
/* The land turned toward a direction, its bounds, and the walks over it: cw_visible. */

#include "visible.h"

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "memory.h"
#include "run.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* How far rounding can put a place on the ray off, as a part of the distance: as in heading.c. A place nearer to a sample than
 * that is the sample's. */
#define PLACE_ROUNDING 0x1p-50

/* Rays of one direction. Distances count in cells along the longer axis, which leads to greater rows. */
typedef struct ways {
    double aside; /* columns that a ray goes for each row, -1 to 1 */
    double reach; /* 0: none */
    double drop;  /* of the ground, times the squared distance */
    visible_crossing *crossing;
    visible_piece *piece;
    uint32_t *until;
    ptrdiff_t *entry;
    size_t steps, crossings;
    bool ends; /* at the reach */
} ways;

struct cw_visible {
    const cw_field *field;
    size_t i, j, every, nx, ny; /* eyes: the first one's sample, the gaps, and how many of them */

    /* The land, turned: column c of it lies at column_at(c). */
    bool turned, transposed, rotated;
    size_t across, down;       /* columns and rows of the land */
    size_t before;             /* columns that stand before its first, so that eyes are in columns 0, every, … */
    ptrdiff_t segment, stride; /* columns of one remainder; a row */
    float *memory, *bound_memory[VISIBLE_LEVELS];
    size_t room, bound_room[VISIBLE_LEVELS];
    double aside[2]; /* of the rays that the bounds are right for */
    bool bounded;
    ways ways;
};

/* ---- the land -------------------------------------------------------------------------------------------------------- */

static ptrdiff_t below(ptrdiff_t a, ptrdiff_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/* Where a column lies in a row, seen from one at which an eye stands. */
static ptrdiff_t column_at(const cw_visible *v, ptrdiff_t column) {
    const ptrdiff_t every = (ptrdiff_t)v->every, number = below(column, every);
    return (column - number * every) * v->segment + number;
}

static bool make_room(float **memory, size_t *room, size_t count) {
    if (*room >= count) return true;
    cw_memory_free(*memory);
    *memory = cw_memory_allocate(count * sizeof(float));
    *room = *memory ? count : 0;
    return *memory != NULL;
}

/* Floats before the first row and after the last one: bounds of the outermost columns are looked for there. */
enum { AROUND = 256 };
static const float *land_of(const cw_visible *v) { return v->memory + AROUND + VISIBLE_MARGIN; }

typedef struct turning {
    cw_visible *view;
    float *to;
} turning;

static void turn_rows(void *context, size_t begin, size_t end) {
    const turning *t = context;
    const cw_visible *v = t->view;
    const cw_field *f = v->field;
    for (size_t y = begin; y < end; y++) {
        float *row = t->to + (ptrdiff_t)y * v->stride;
        for (ptrdiff_t k = -VISIBLE_MARGIN; k < v->stride - VISIBLE_MARGIN; k++) row[k] = NAN;
        for (size_t c = 0; c < v->across; c++) {
            const size_t x = v->rotated ? v->across - 1 - c : c, z = v->rotated ? v->down - 1 - y : y;
            row[column_at(v, (ptrdiff_t)(c + v->before))] =
                v->transposed ? f->z[x * f->stride + z] : f->z[z * f->stride + x];
        }
    }
}

/* Turns the land so that the direction leads to greater rows. */
static cw_status turn(cw_visible *v, const double dir[2], const cw_run *how) {
    const bool transposed = fabs(dir[0]) > fabs(dir[1]), rotated = dir[transposed ? 0 : 1] < 0;
    if (v->turned && v->transposed == transposed && v->rotated == rotated) return CW_OK;
    const size_t nx = v->field->nx, ny = v->field->ny;
    v->turned = v->bounded = false;
    v->transposed = transposed;
    v->rotated = rotated;
    v->across = transposed ? ny : nx;
    v->down = transposed ? nx : ny;
    const size_t eye = transposed ? v->j : v->i;
    const size_t first = (rotated ? v->across - 1 - eye : eye) % v->every;
    v->before = (v->every - first) % v->every;
    const size_t number = (v->across + v->before + v->every - 1) / v->every;
    v->segment = (ptrdiff_t)((number + 2 * VISIBLE_MARGIN + VISIBLE_GROUP - 1) / VISIBLE_GROUP * VISIBLE_GROUP);
    v->stride = v->segment * (ptrdiff_t)v->every;
    if (!make_room(&v->memory, &v->room, v->down * (size_t)v->stride + 2 * AROUND))
        return cw_fail_plainly(CW_ERROR_MEMORY);
    for (size_t k = 0; k < AROUND; k++) v->memory[k] = v->memory[v->down * (size_t)v->stride + AROUND + k] = NAN;
    turning t = {v, v->memory + AROUND + VISIBLE_MARGIN};
    cw_run quiet = *how;
    quiet.watch = NULL;
    const cw_status status = cw_run_work(&quiet, v->down, 16, 64, turn_rows, &t);
    v->turned = status == CW_OK;
    return status;
}

/* ---- bounds ---------------------------------------------------------------------------------------------------------- */

/* Rays differ from the middle of the bounds by so many columns a row, at least; rounding of places is far less. */
static const double hair = 0x1p-20;

typedef struct bounding {
    const cw_visible *view;
    const visible_code *code;
    int level;
    size_t blocks; /* of the level below; rows at level 0 */
} bounding;

static double lesser(double a, double b) { return a < b ? a : b; }
static double greater(double a, double b) { return a > b ? a : b; }

/* The columns, from the one in which the block is entered, in which row q of a block has samples that a ray reads. A ray reads
 * them at crossings before and after the row: up to a row farther back if it goes to lesser columns. At level 1: in which
 * block q of level 0 is entered. */
static void columns_of(const cw_visible *v, int level, int q, ptrdiff_t *low, ptrdiff_t *high) {
    const double step = level > 0 ? 8 : 1, back = level > 0 || q == 0 ? q : q - 1, on = level > 0 || q == 8 ? q : q + 1;
    *low = (ptrdiff_t)floor(step * lesser(q * v->aside[0], on * v->aside[0]) - hair);
    *high = (ptrdiff_t)floor(step * greater(q * v->aside[1], back * v->aside[1]) + hair) + (level > 0 ? 1 : 2);
}

static void bound_blocks(void *context, size_t begin, size_t end) {
    enum { COLUMNS_MOST = 8 };
    const bounding *b = context;
    const cw_visible *v = b->view;
    const int last = b->level > 0 ? 7 : 8;
    for (size_t block = begin; block < end; block++) {
        float *to = v->bound_memory[b->level] + AROUND + (ptrdiff_t)block * v->stride;
        for (ptrdiff_t k = 0; k < v->stride; k++) to[k] = -INFINITY;
        for (int q = 0; q <= last && 8 * block + (size_t)q < b->blocks; q++) {
            const float *from = (b->level > 0 ? v->bound_memory[0] : v->memory) + AROUND +
                                (ptrdiff_t)(8 * block + (size_t)q) * v->stride;
            ptrdiff_t low, high, at[COLUMNS_MOST];
            columns_of(v, b->level, q, &low, &high);
            for (size_t phase = 0; phase < v->every; phase++) {
                size_t count = 0;
                const ptrdiff_t here = (ptrdiff_t)phase * v->segment;
                for (ptrdiff_t o = low; o <= high && count < COLUMNS_MOST; o++)
                    at[count++] = column_at(v, (ptrdiff_t)phase + o) - here;
                b->code->bound(to + here, from + here, at, count, (size_t)v->segment);
            }
        }
    }
}

/* Bounds that are right for rays that go aside by that much, give or take slack. */
static cw_status bound(cw_visible *v, const cw_run *how, double aside, double slack) {
    if (v->bounded && aside >= v->aside[0] + hair && aside <= v->aside[1] - hair) return CW_OK;
    v->aside[0] = aside - slack - 2 * hair;
    v->aside[1] = aside + slack + 2 * hair;
    v->bounded = false;
    cw_run quiet = *how;
    quiet.watch = NULL;
    size_t blocks = v->down;
    for (int l = 0; l < VISIBLE_LEVELS; l++) {
        bounding b = {v, how->kernel->visible, l, blocks};
        blocks = (blocks + 7) / 8;
        if (!make_room(&v->bound_memory[l], &v->bound_room[l], blocks * (size_t)v->stride + 2 * AROUND))
            return cw_fail_plainly(CW_ERROR_MEMORY);
        for (size_t k = 0; k < AROUND; k++)
            v->bound_memory[l][k] = v->bound_memory[l][blocks * (size_t)v->stride + AROUND + k] = -INFINITY;
        const cw_status status = cw_run_work(&quiet, blocks, 4, 16, bound_blocks, &b);
        if (status != CW_OK) return status;
    }
    v->bounded = true;
    return CW_OK;
}

/* ---- crossings ------------------------------------------------------------------------------------------------------- */

typedef struct place {
    double at;                  /* distance */
    double first[2], second[2]; /* the edge's samples: column and row, from the eye's */
    double fraction;
} place;

/* Sorted into those of the row that come before. */
static void add_place(place *row, size_t *count, place p) {
    size_t k = (*count)++;
    for (; k > 0 && row[k - 1].at > p.at; k--) row[k] = row[k - 1];
    row[k] = p;
}

/* Whether a place on a line across the ray is between two samples, and then its fraction of the way. */
static bool is_between(double at, double along, double *fraction) {
    *fraction = along - floor(along);
    return fabs(along - nearbyint(along)) > PLACE_ROUNDING * at;
}

enum { CROSSINGS_MOST = 4 }; /* in a row: a column, two diagonals, the row */

/* The crossings from row k - 1 on, without it, to row k. */
static size_t row_of_crossings(double aside, size_t k, place row[CROSSINGS_MOST]) {
    const double low = (double)(k - 1), high = (double)k, steep = aside - 1;
    size_t count = 0;
    double fraction;
    /* Columns, crossed at column / aside. */
    for (double c = aside > 0 ? floor(aside * low) : ceil(aside * low); aside != 0; c += aside > 0 ? 1 : -1) {
        const double at = c / aside;
        if (at > high) break;
        if (at <= low || !is_between(at, at, &fraction)) continue;
        add_place(row, &count, (place){at, {c, low}, {c, high}, fraction});
    }
    /* Diagonals column - row = number, crossed at number / (aside - 1). */
    for (double n = ceil(steep * low); steep < -PLACE_ROUNDING; n--) {
        const double at = n / steep;
        if (at > high) break;
        if (at <= low || !is_between(at, at, &fraction)) continue;
        add_place(row, &count, (place){at, {n + low, low}, {n + high, high}, fraction});
    }
    const double x = aside * high;
    const bool between = is_between(high, x, &fraction);
    const double c = between ? floor(x) : nearbyint(x);
    add_place(row, &count, (place){high, {c, high}, {between ? c + 1 : c, high}, between ? fraction : 0});
    return count;
}

static void free_ways(ways *w) {
    cw_memory_free(w->crossing);
    cw_memory_free(w->piece);
    cw_memory_free(w->until);
    cw_memory_free(w->entry);
    *w = (ways){0};
}

/* Crossings up to the first one beyond the reach. */
static cw_status make_ways(const cw_visible *v, ways *w) {
    const double columns = fabs(w->aside) > 0 ? (double)(v->across - 1) / fabs(w->aside) : INFINITY;
    double rows = lesser((double)(v->down - 1), ceil(columns * (1 + 0x1p-40)));
    if (w->reach > 0) rows = lesser(rows, ceil(w->reach) + 1);
    const size_t most = (size_t)rows, room = CROSSINGS_MOST * most + 1;
    w->crossing = cw_memory_allocate(room * sizeof *w->crossing);
    w->piece = cw_memory_allocate(room * sizeof *w->piece);
    w->until = cw_memory_allocate((most + 1) * sizeof *w->until);
    w->entry = cw_memory_allocate((most + 1) * sizeof *w->entry);
    if (w->crossing == NULL || w->piece == NULL || w->until == NULL || w->entry == NULL)
        return cw_fail_plainly(CW_ERROR_MEMORY);
    double last = 0;
    w->until[0] = 0;
    w->entry[0] = 0;
    while (w->steps < most && !w->ends) {
        place row[CROSSINGS_MOST];
        const size_t k = ++w->steps, count = row_of_crossings(w->aside, k, row);
        for (size_t n = 0; n < count && !w->ends; n++) {
            const place *p = &row[n];
            const ptrdiff_t first = column_at(v, (ptrdiff_t)p->first[0]) + (ptrdiff_t)p->first[1] * v->stride;
            const ptrdiff_t second = column_at(v, (ptrdiff_t)p->second[0]) + (ptrdiff_t)p->second[1] * v->stride;
            w->crossing[w->crossings] = (visible_crossing){.first = first,
                                                           .second = (int32_t)(second - first),
                                                           .fraction = (float)p->fraction,
                                                           .inverse = (float)(1 / p->at),
                                                           .drop = (float)(w->drop * p->at)};
            w->piece[w->crossings++] = (visible_piece){(float)last, (float)p->at, (float)(p->at - last)};
            last = p->at;
            w->ends = w->reach > 0 && p->at >= w->reach;
        }
        w->until[k] = (uint32_t)w->crossings;
        w->entry[k] = column_at(v, (ptrdiff_t)row[count - 1].first[0]);
    }
    return CW_OK;
}

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
    return aside == 0 ? SIZE_MAX : (size_t)lesser(ceil(greater(columns, 0) / fabs(aside)) + 1, 0x1p30);
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
static double rounding(const cw_field *f, float eye, float target) {
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
    cw_status status = turn(v, desc->dir, how);
    if (status != CW_OK) return status;
    const double sign = v->rotated ? -1 : 1, aside = sign * desc->dir[v->transposed ? 1 : 0] / longest;
    free_ways(&v->ways);
    v->ways.aside = fabs(aside) <= PLACE_ROUNDING ? 0 : aside;
    v->ways.reach = desc->reach * longest;
    v->ways.drop = desc->drop / (longest * longest);
    status = make_ways(v, &v->ways);
    if (status == CW_OK) status = bound(v, how, v->ways.aside, desc->slack);
    if (status != CW_OK) return status;
    const ways *s = &v->ways;
    walking w = {.view = v, .code = how->kernel->visible, .desc = desc, .row = row, .rows = rows, .to = to};
    w.job = (visible_job){.land = land_of(v),
                          .stride = v->stride,
                          .rows = v->down,
                          .crossing = s->crossing,
                          .piece = s->piece,
                          .until = s->until,
                          .entry = s->entry,
                          .steps = s->steps,
                          .reach = s->ends ? (float)s->reach : 0,
                          .eye = desc->eye,
                          .target = desc->target,
                          .curved = desc->drop > 0};
    for (int l = 0; l < VISIBLE_LEVELS; l++) w.job.bound[l] = v->bound_memory[l] + AROUND + VISIBLE_MARGIN;
    w.job.lift = (float)((double)desc->target + rounding(v->field, desc->eye, desc->target));
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
    const cw_status status = cw_check_rectangle(field, &at);
    if (status != CW_OK) return status;
    cw_visible *v = cw_memory_clear(sizeof *v);
    if (v == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    v->field = field;
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
    free_ways(&v->ways);
    cw_memory_free(v->memory);
    for (int l = 0; l < VISIBLE_LEVELS; l++) cw_memory_free(v->bound_memory[l]);
    cw_memory_free(v);
}

static bool is_size(double a, double most) { return a >= 0 && a <= most; }

cw_status cw_visible_add(cw_visible *v, const cw_run *run, const cw_visible_desc *desc, size_t row, size_t rows,
                         cw_visible_sums to) {
    if (v == NULL || desc == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", v ? "desc" : "visible");
    if ((to.farthest == NULL) != (to.direction == NULL))
        return cw_fail(CW_ERROR_ARGUMENT, "farthest and direction go together");
    const cw_status reserved = cw_check_reserved(desc->reserved, "cw_visible_desc");
    if (reserved != CW_OK) return reserved;
    const double *dir = desc->dir, longest = fmax(fabs(dir[0]), fabs(dir[1]));
    if (!(isfinite(dir[0]) && isfinite(dir[1]) && longest >= 0x1p-40 && longest <= 0x1p40))
        return cw_fail(CW_ERROR_ARGUMENT, "dir: (%g, %g); its longer component is from 2^-40 to 2^40", dir[0], dir[1]);
    if (!(is_size(desc->reach, DBL_MAX) && is_size(desc->drop * (CW_SIDE_MAX / longest), (double)CW_HEIGHT_MAX) &&
          is_size((double)desc->eye, (double)CW_HEIGHT_MAX) && is_size((double)desc->target, (double)CW_HEIGHT_MAX) &&
          is_size(desc->slack, 0x1p-7)))
        return cw_fail(CW_ERROR_ARGUMENT, "reach, drop, eye, target or slack is out of range");
    if (row > v->ny || rows > v->ny - row)
        return cw_fail(CW_ERROR_ARGUMENT, "rows %zu to %zu of %zu", row, row + rows, v->ny);
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    how.leaf = CW_LEAF_DEFAULT;
    if (status == CW_OK) status = cw_run_settle(v->field, &how);
    if (status != CW_OK || rows == 0 || v->nx == 0) return status;
    const door_pass in = door_enter(&v->field->door);
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    const fpenv caller = fpenv_enter();
    status = add(v, &how, desc, row, rows, to);
    fpenv_leave(caller);
    door_leave(in);
    return status;
}
