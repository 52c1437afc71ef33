/* SPDX-License-Identifier: Apache-2.0 */
#include "visible_land.h"

#include <math.h>

/* ---- the land ---------------------------------------------------------------------------------------------------- */

static ptrdiff_t below(ptrdiff_t a, ptrdiff_t b) { return a >= 0 ? a / b : -((b - 1 - a) / b); }

/* Where a column lies in a row, seen from one at which an eye stands. */
static ptrdiff_t column_at(const cw_visible *v, ptrdiff_t column) {
    const ptrdiff_t every = (ptrdiff_t)v->every, number = below(column, every);
    return (column - number * every) * v->segment + number;
}

/* Room for so many floats, or NULL with an error. */
static float *make_room(cw_visible *v, int array, size_t count) {
    if (v->array[array].count < count) {
        large_release(v->array[array].at);
        v->array[array].at = large_allocate(count * sizeof(float));
        v->array[array].count = v->array[array].at ? count : 0;
    }
    if (v->array[array].at == NULL) cw_fail_plainly(CW_ERROR_MEMORY);
    return v->array[array].at;
}

/* The same for rows of the land or of blocks, with `none` before and after them. */
static float *make_rows(cw_visible *v, int array, size_t rows, float none) {
    const size_t count = rows * (size_t)v->stride;
    float *at = make_room(v, array, count + 2 * AROUND);
    for (size_t k = 0; k < AROUND && at; k++) at[k] = at[count + AROUND + k] = none;
    return at;
}

static void turn_rows(void *context, size_t begin, size_t end) {
    const cw_visible *v = context;
    const samples *f = &v->samples;
    for (size_t y = begin; y < end; y++) {
        float *row = v->array[LAND].at + AROUND + VISIBLE_MARGIN + (ptrdiff_t)y * v->stride;
        for (ptrdiff_t k = -VISIBLE_MARGIN; k < v->stride - VISIBLE_MARGIN; k++) row[k] = NAN;
        for (size_t c = 0; c < v->across; c++) {
            const size_t x = v->rotated ? v->across - 1 - c : c, z = v->rotated ? v->down - 1 - y : y;
            row[column_at(v, (ptrdiff_t)(c + v->before))] =
                v->transposed ? f->z[x * f->stride + z] : f->z[z * f->stride + x];
        }
    }
}

cw_status cw_visible_turn(cw_visible *v, const double dir[2], const cw_run *how) {
    const bool transposed = fabs(dir[0]) > fabs(dir[1]), rotated = dir[transposed ? 0 : 1] < 0;
    if (v->turned && v->transposed == transposed && v->rotated == rotated) return CW_OK;
    const size_t nx = v->samples.nx, ny = v->samples.ny;
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
    if (!make_rows(v, LAND, v->down, NAN)) return CW_ERROR_MEMORY;
    const cw_status status = cw_run_work(how, v->down, 16, 64, turn_rows, v);
    v->turned = status == CW_OK;
    return status;
}

/* ---- bounds ------------------------------------------------------------------------------------------------------ */

/* Rays differ from the middle of the bounds by so many columns a row, at least; rounding of places is far less. */
static const double hair = 0x1p-20;

typedef struct bounding {
    cw_visible *view;
    int level;
    size_t blocks; /* of the level below; rows at level 0 */
} bounding;

static double lesser(double a, double b) { return a < b ? a : b; }
static double greater(double a, double b) { return a > b ? a : b; }

/* The columns, from the one in which the block is entered, in which row q of a block has samples that a ray reads. A
 * ray reads them at crossings before and after the row: up to a row farther back if it goes to lesser columns. At level
 * 1: in which block q of level 0 is entered. */
static void columns_of(const cw_visible *v, int level, int q, ptrdiff_t *low, ptrdiff_t *high) {
    const double step = level > 0 ? 8 : 1, back = level > 0 || q == 0 ? q : q - 1, on = level > 0 || q == 8 ? q : q + 1;
    *low = (ptrdiff_t)floor(step * lesser(q * v->aside[0], on * v->aside[0]) - hair);
    *high = (ptrdiff_t)floor(step * greater(q * v->aside[1], back * v->aside[1]) + hair) + (level > 0 ? 1 : 2);
}

static void bound_blocks(void *context, size_t begin, size_t end) {
    enum { COLUMNS_MOST = 8 };
    const bounding *b = context;
    cw_visible *v = b->view;
    const int last = b->level > 0 ? 7 : 8;
    for (size_t block = begin; block < end; block++) {
        float *to = v->array[BOUND + b->level].at + AROUND + (ptrdiff_t)block * v->stride;
        float *least = b->level > 0 ? NULL : v->array[LEVEL].at + AROUND + (ptrdiff_t)block * v->stride;
        for (ptrdiff_t k = 0; k < v->stride; k++) to[k] = -INFINITY;
        for (ptrdiff_t k = 0; k < v->stride && least; k++) least[k] = INFINITY;
        for (int q = 0; q <= last && 8 * block + (size_t)q < b->blocks; q++) {
            const float *from =
                v->array[b->level > 0 ? BOUND : LAND].at + AROUND + (ptrdiff_t)(8 * block + (size_t)q) * v->stride;
            ptrdiff_t low, high, at[COLUMNS_MOST];
            columns_of(v, b->level, q, &low, &high);
            for (size_t phase = 0; phase < v->every; phase++) {
                size_t count = 0;
                const ptrdiff_t here = (ptrdiff_t)phase * v->segment;
                for (ptrdiff_t o = low; o <= high && count < COLUMNS_MOST; o++)
                    at[count++] = column_at(v, (ptrdiff_t)phase + o) - here;
                v->code->bound(to + here, least ? least + here : NULL, from + here, at, count, (size_t)v->segment);
            }
        }
        bool found = false;
        for (ptrdiff_t k = 0; k < v->stride && least; k++) {
            const bool is_level = least[k] == to[k] && least[k] > -INFINITY;
            least[k] = is_level ? least[k] : NAN;
            found |= is_level;
        }
        if (found) atomic_store_explicit(&v->has_level, true, memory_order_relaxed);
    }
}

cw_status cw_visible_bound(cw_visible *v, const cw_run *how, double aside, double slack) {
    if (v->bounded && aside >= v->aside[0] + hair && aside <= v->aside[1] - hair) return CW_OK;
    v->aside[0] = aside - slack - 2 * hair;
    v->aside[1] = aside + slack + 2 * hair;
    v->bounded = false;
    atomic_store_explicit(&v->has_level, false, memory_order_relaxed);
    size_t blocks = v->down;
    for (int l = 0; l < VISIBLE_LEVELS; l++) {
        bounding b = {v, l, blocks};
        blocks = (blocks + 7) / 8;
        if (!make_rows(v, BOUND + l, blocks, -INFINITY) || (l == 0 && !make_rows(v, LEVEL, blocks, NAN)))
            return CW_ERROR_MEMORY;
        const cw_status status = cw_run_work(how, blocks, 4, 16, bound_blocks, &b);
        if (status != CW_OK) return status;
    }
    v->bounded = true;
    return CW_OK;
}

/* ---- crossings --------------------------------------------------------------------------------------------------- */

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

/* Up to here all sums are exact in double: the area is at most 2^32, and the least unit 2^-20. */
enum { EXACT_STEPS = 1 << 16, LEAST_UNIT = -20 };

/* Runs near the eye are short, so that their units are small. Units depend on a run's begin and length alone, not on
 * how far the land goes: as each row has a crossing, a run goes through no more rows than it has pieces. */
static void add_areas(visible_piece *piece, size_t pieces, visible_run *run, double *whole) {
    double all = 0;
    for (size_t k = 0; k < pieces; k++) {
        visible_piece *p = &piece[k];
        if (k == 0 || k == run->until) {
            const size_t length = k == 0 ? 8 : k < VISIBLE_RUN ? k : VISIBLE_RUN;
            run += k > 0;
            int e;
            frexp((2 * (double)p->begin + (double)length + 1) * (double)(length + 1), &e);
            const int half = (int)lesser(-LEAST_UNIT / 2, floor(0.5 * (31 - e)));
            *run = (visible_run){ldexp(1, -2 * half), (float)ldexp(1, half), (float)ldexp(1, -half), k + length};
        }
        p->length *= run->scale;
        p->twice *= run->scale;
        all -= trunc((double)(p->length * (p->length - p->twice))) * run->unit;
        whole[k] = all;
    }
}

/* How far the eye must stand over a level block that begins at row k so that slopes rise from each crossing in it to
 * the next, after rounding, too: papers/numerics.md. */
static float sunk_at(const visible_crossing *crossing, const uint32_t *until) {
    enum { LEAST = -80 }; /* whatever is higher does not become denormal on the way */
    const double u = 0x1p-24;
    const visible_crossing *c = crossing + until[0] - 1, *last = crossing + until[8] - 1;
    const double rounding_of_slopes = 5 * u * (double)c->inverse, rounding_of_drops = 5 * u * (double)last->drop;
    double nearer = INFINITY,
           lower = 0; /* slopes rise by this for a height of 1 at least, and fall by curvature at most */
    for (; c < last; c++) {
        nearer = lesser(nearer, (double)c[0].inverse - (double)c[1].inverse);
        lower = greater(lower, (double)c[1].drop - (double)c[0].drop);
    }
    nearer -= rounding_of_slopes;
    return nearer > 0 ? (float)greater((lower + rounding_of_drops) / nearer * (1 + 0x1p-20), ldexp(1, LEAST))
                      : INFINITY;
}

cw_status cw_visible_make_ways(cw_visible *v, double aside, double reach, double drop, visible_job *job) {
    const double columns = fabs(aside) > 0 ? (double)(v->across - 1) / fabs(aside) : INFINITY;
    double rows = lesser((double)(v->down - 1), ceil(columns * (1 + 0x1p-40)));
    if (reach > 0) rows = lesser(rows, ceil(reach) + 1);
    const size_t most = (size_t)rows, room = CROSSINGS_MOST * most + 1, runs = room / VISIBLE_RUN + 8;
    const size_t each = sizeof(double) + sizeof(visible_crossing) + sizeof(visible_piece),
                 row_each = sizeof(ptrdiff_t) + sizeof(float) + sizeof(uint32_t);
    const size_t bytes = room * each + runs * sizeof(visible_run) + (most + 1) * row_each;
    double *whole = (double *)make_room(v, WAYS, bytes / sizeof(float));
    if (whole == NULL) return CW_ERROR_MEMORY;
    visible_crossing *crossing = (visible_crossing *)(whole + room);
    visible_run *run = (visible_run *)(crossing + room);
    ptrdiff_t *entry = (ptrdiff_t *)(run + runs);
    visible_piece *piece = (visible_piece *)(entry + most + 1);
    float *sunk = (float *)(piece + room);
    uint32_t *until = (uint32_t *)(sunk + most + 1);
    double last = 0;
    size_t steps = 0, crossings = 0;
    bool ends = false; /* at the reach */
    until[0] = 0;
    entry[0] = 0;
    while (steps < most && !ends) {
        place row[CROSSINGS_MOST];
        const size_t k = ++steps, count = row_of_crossings(aside, k, row);
        for (size_t n = 0; n < count && !ends; n++) {
            const place *p = &row[n];
            const ptrdiff_t first = column_at(v, (ptrdiff_t)p->first[0]) + (ptrdiff_t)p->first[1] * v->stride;
            const ptrdiff_t second = column_at(v, (ptrdiff_t)p->second[0]) + (ptrdiff_t)p->second[1] * v->stride;
            crossing[crossings] = (visible_crossing){.first = first,
                                                     .second = (int32_t)(second - first),
                                                     .fraction = (float)p->fraction,
                                                     .inverse = (float)(1 / p->at),
                                                     .drop = (float)(drop * p->at)};
            piece[crossings++] = (visible_piece){(float)last, (float)p->at, (float)(p->at - last), 2 * (float)p->at};
            last = p->at;
            ends = reach > 0 && p->at >= reach;
        }
        until[k] = (uint32_t)crossings;
        entry[k] = column_at(v, (ptrdiff_t)row[count - 1].first[0]);
    }
    add_areas(piece, crossings, run, whole);
    for (size_t k = 0; k <= steps; k++)
        sunk[k] = k > 0 && k + 8 <= steps && k + 8 <= EXACT_STEPS ? sunk_at(crossing, until + k) : INFINITY;
    *job = (visible_job){.crossing = crossing,
                         .piece = piece,
                         .run = run,
                         .whole = whole,
                         .sunk = sunk,
                         .until = until,
                         .entry = entry,
                         .steps = steps,
                         .reach = ends ? (float)reach : 0};
    return CW_OK;
}
