/* SPDX-License-Identifier: Apache-2.0 */
#include "reach.h"

#include "compass.h"

#include <math.h>
#include <stdlib.h>

/* Field coordinates, both ends included. */
typedef struct box {
    double low[2], high[2];
} box;

static box box_of(cw_rectangle r) {
    return (box){{(double)r.i, (double)r.j}, {(double)(r.i + r.nx) - 1, (double)(r.j + r.ny) - 1}};
}

static double last_of(const terrain *whole, int axis) { return (double)((axis ? whole->ny : whole->nx) - 1); }

static cw_rectangle samples_from(const double first[2], const double last[2]) {
    return (cw_rectangle){(size_t)first[0], (size_t)first[1], (size_t)(last[0] - first[0]) + 1,
                          (size_t)(last[1] - first[1]) + 1};
}

/* The part that the raster has of a box with some more columns and rows on each side: at least 2 x 2 samples. */
static cw_rectangle grown(const terrain *whole, box b, double columns, double rows) {
    for (int k = 0; k < 2; k++) {
        const double more = k ? rows : columns, last = last_of(whole, k);
        double *first = &b.low[k], *end = &b.high[k];
        *first = fmin(fmax(floor(*first - more), 0), last);
        *end = fmin(fmax(ceil(*end + more), 0), last);
        if (*end - *first < 1) *first = fmax(*end - 1, 0);
        if (*end - *first < 1) *end = fmin(*first + 1, last);
    }
    return samples_from(b.low, b.high);
}

cw_rectangle cw_reach_grow(const terrain *whole, cw_rectangle part, double more) {
    return grown(whole, box_of(part), more, more);
}

cw_rectangle cw_reach_both(cw_rectangle a, cw_rectangle b) {
    if (a.nx == 0 || a.ny == 0) return b;
    if (b.nx == 0 || b.ny == 0) return a;
    const size_t i = a.i < b.i ? a.i : b.i, j = a.j < b.j ? a.j : b.j;
    const size_t right = a.i + a.nx > b.i + b.nx ? a.i + a.nx : b.i + b.nx;
    const size_t bottom = a.j + a.ny > b.j + b.ny ? a.j + a.ny : b.j + b.ny;
    return (cw_rectangle){i, j, right - i, bottom - j};
}

/* Cells that a metre is long at most, along columns and rows, at a place. */
static void cells_a_metre(const terrain *whole, double i, double j, double cells[2]) {
    double metres[2];
    cw_terrain_metres(whole, i, j, metres);
    for (int k = 0; k < 2; k++) cells[k] = hypot(whole->back[k][0] / metres[0], whole->back[k][1] / metres[1]);
}

cw_rectangle cw_reach_within(const terrain *whole, const double at[2], double metres) {
    double cells[2], low[2], high[2];
    cells_a_metre(whole, at[0], at[1], cells);
    for (int k = 0; k < 2; k++) {
        /* A hair for rounding. */
        const double far = metres * cells[k] * (1 + 0x1p-30) + 0x1p-20;
        low[k] = fmax(ceil(at[k] - far), 0);
        high[k] = fmin(floor(at[k] + far), last_of(whole, k));
        if (!(low[k] <= high[k])) return (cw_rectangle){0};
    }
    return samples_from(low, high);
}

cw_rectangle cw_reach_between(const terrain *whole, const double at[2], cw_rectangle part) {
    box b = box_of(part);
    for (int k = 0; k < 2; k++) {
        b.low[k] = fmin(b.low[k], at[k]);
        b.high[k] = fmax(b.high[k], at[k]);
    }
    return grown(whole, b, REACH_BESIDE, REACH_BESIDE);
}

/* The sweep of a viewshed ends at a square around the place: terrain beyond it changes nothing. */
cw_rectangle cw_reach_around(const terrain *whole, const double at[2], double metres) {
    enum { SWEEP_BESIDE = 8 };
    double each[2];
    cw_terrain_metres(whole, at[0], at[1], each);
    double cells = 0;
    for (int k = 0; k < 2; k++)
        cells = fmax(cells, fabs(whole->back[k][0]) / each[0] + fabs(whole->back[k][1]) / each[1]);
    const double far = metres * cells;
    const box b = {{at[0] - far, at[1] - far}, {at[0] + far, at[1] + far}};
    for (int k = 0; k < 2; k++)
        if (b.high[k] + SWEEP_BESIDE < 0 || b.low[k] - SWEEP_BESIDE > last_of(whole, k)) return (cw_rectangle){0};
    return grown(whole, b, SWEEP_BESIDE, SWEEP_BESIDE);
}

cw_rectangle cw_reach_beside(const terrain *whole, cw_rectangle part, double metres) {
    double most[2] = {0, 0};
    /* The compass has one direction for up to 256 rows. */
    const double from = fmax((double)part.j - 256, 0),
                 until = fmin((double)(part.j + part.ny) + 255, (double)(whole->ny - 1));
    for (double j = from; j <= until; j += terrain_has_rows(whole) ? 0.5 : until - from + 1) {
        double cells[2];
        cells_a_metre(whole, 0.5 * (double)(whole->nx - 1), j, cells);
        for (int k = 0; k < 2; k++) most[k] = fmax(most[k], metres * cells[k] * (1 + 0x1p-19) + REACH_BESIDE);
    }
    return grown(whole, box_of(part), most[0], most[1]);
}

/* ---- blocks ------------------------------------------------------------------------------------------------------ */

cw_status cw_reach_blocks_create(const terrain *whole, reach_blocks *b) {
    *b = (reach_blocks){.whole = whole,
                        .across = (whole->nx + REACH_BLOCK - 1) / REACH_BLOCK,
                        .down = (whole->ny + REACH_BLOCK - 1) / REACH_BLOCK,
                        .highest = -INFINITY,
                        .lowest = INFINITY};
    const size_t n = b->across * b->down;
    b->low = malloc(2 * n * sizeof *b->low);
    b->holes = calloc(n, sizeof *b->holes);
    if (b->low == NULL || b->holes == NULL) {
        cw_reach_blocks_destroy(b);
        return CW_ERROR_MEMORY;
    }
    b->high = b->low + n;
    for (size_t k = 0; k < n; k++) {
        b->low[k] = INFINITY;
        b->high[k] = -INFINITY;
    }
    return CW_OK;
}

void cw_reach_blocks_destroy(reach_blocks *b) {
    free(b->low);
    free(b->holes);
    *b = (reach_blocks){0};
}

void cw_reach_blocks_take(reach_blocks *b, cw_rectangle part, const float *z) {
    for (size_t y = 0; y < part.ny; y++, z += part.nx)
        for (size_t x = 0; x < part.nx;) {
            const size_t column = (part.i + x) / REACH_BLOCK, k = (part.j + y) / REACH_BLOCK * b->across + column;
            const size_t until = (column + 1) * REACH_BLOCK - part.i;
            float low = b->low[k], high = b->high[k];
            bool holes = b->holes[k];
            for (; x < part.nx && x < until; x++) {
                const float here = z[x] - z[x] == 0 ? z[x] : NAN;
                low = here < low ? here : low;
                high = here > high ? here : high;
                holes |= isnan(here);
            }
            b->low[k] = low;
            b->high[k] = high;
            b->holes[k] = holes;
            b->highest = high > b->highest ? high : b->highest;
            b->lowest = low < b->lowest ? low : b->lowest;
        }
}

/* ---- the sun ----------------------------------------------------------------------------------------------------- */

reach_sunward cw_reach_toward(const terrain *whole, const cw_light *light, cw_rectangle part) {
    double azimuths[SUNLIGHT_STRIPS_MOST], sine, cosine;
    const size_t strips = cw_light_azimuths(light, azimuths);
    reach_sunward s = {.cells = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}}};
    const double lowest = light->altitude - light->radius;
    cw_terrain_sine_cosine(fmax(lowest, -90), &sine, &cosine);
    /* Rises are floats. */
    s.tangent = lowest >= 90 ? INFINITY : sine / cosine - 0x1p-20 * fabs(sine / cosine);
    const double from = fmax((double)part.j - 256, 0),
                 until = fmin((double)(part.j + part.ny) + 255, (double)(whole->ny - 1));
    /* Middles of rows that share a heading are multiples of a half. */
    for (double j = from; j <= until; j += terrain_has_rows(whole) ? 0.5 : until - from + 1)
        for (size_t k = 0; k < strips; k++) {
            double dir[2];
            const double metres = cw_terrain_direction(whole, 0.5 * (double)(whole->nx - 1), j, azimuths[k], dir);
            for (int a = 0; a < 2; a++) {
                const double cells = dir[a] / metres, hair = 0x1p-40 / metres;
                s.cells[a][0] = fmin(s.cells[a][0], cells - hair);
                s.cells[a][1] = fmax(s.cells[a][1], cells + hair);
            }
        }
    return s;
}

bool cw_reach_passes(const reach_sunward *s, cw_rectangle part, cw_rectangle over, double *first, double *last) {
    const box from = box_of(part), to = box_of(over);
    *first = 0;
    *last = INFINITY;
    for (int a = 0; a < 2; a++) {
        const double least = to.low[a] - REACH_BESIDE - from.high[a], most = to.high[a] + REACH_BESIDE - from.low[a];
        /* t cells[1] >= least and t cells[0] <= most, for some t >= 0 */
        const double fast = s->cells[a][1], slow = s->cells[a][0];
        if (fast > 0)
            *first = fmax(*first, least / fast);
        else if (least > 0)
            return false;
        else if (fast < 0)
            *last = fmin(*last, least / fast);
        if (slow < 0)
            *first = fmax(*first, most / slow);
        else if (most < 0)
            return false;
        else if (slow > 0)
            *last = fmin(*last, most / slow);
    }
    return *first <= *last;
}

cw_rectangle cw_reach_block(const reach_blocks *b, size_t x, size_t y) {
    const size_t i = x * REACH_BLOCK, j = y * REACH_BLOCK;
    return (cw_rectangle){i, j, b->whole->nx - i < REACH_BLOCK ? b->whole->nx - i : REACH_BLOCK,
                          b->whole->ny - j < REACH_BLOCK ? b->whole->ny - j : REACH_BLOCK};
}

double cw_reach_highest(const reach_blocks *b, size_t x, size_t y) {
    const double high = (double)b->high[y * b->across + x];
    double low = high; /* of the blocks next to it too, which have the other ends of edges */
    for (size_t v = y > 0 ? y - 1 : 0; v <= y + 1 && v < b->down; v++)
        for (size_t u = x > 0 ? x - 1 : 0; u <= x + 1 && u < b->across; u++)
            low = fmin(low, (double)b->low[v * b->across + u]);
    return high > -INFINITY ? high + REACH_ROUNDING * (high - low) : high;
}

/* Blocks first[a] to end[a] - 1 of an axis: none farther away has what the highest sample would throw a shadow from. */
static void blocks_in_reach(const reach_blocks *b, const reach_sunward *s, const box *part, double lowest,
                            size_t first[2], size_t end[2]) {
    const double room = REACH_ROUNDING * ((double)b->highest - (double)b->lowest),
                 over = fmax(((double)b->highest + room - lowest) * terrain_metres_of_height(b->whole), 0);
    for (int a = 0; a < 2; a++) {
        const double count = (double)(a ? b->down : b->across);
        double low = 0, high = count;
        if (s->tangent > 0) {
            const double back = fmin(s->cells[a][0], 0) * (over / s->tangent),
                         on = fmax(s->cells[a][1], 0) * (over / s->tangent);
            low = floor((part->low[a] + back - 2 * REACH_BESIDE) / REACH_BLOCK);
            high = floor((part->high[a] + on + 2 * REACH_BESIDE) / REACH_BLOCK) + 1;
        }
        first[a] = (size_t)fmin(fmax(low, 0), count);
        end[a] = (size_t)fmax(fmin(high, count), 0);
    }
}

/* Compared and not by fmin: GCC 12 for aarch64 crashes on that loop (internal error in vect_transform_reduction). */
static double lowest_of(const reach_blocks *b, cw_rectangle part) {
    const size_t right = (part.i + part.nx - 1) / REACH_BLOCK, bottom = (part.j + part.ny - 1) / REACH_BLOCK;
    float lowest = INFINITY;
    for (size_t y = part.j / REACH_BLOCK; y <= bottom; y++)
        for (size_t x = part.i / REACH_BLOCK; x <= right; x++)
            if (b->low[y * b->across + x] < lowest) lowest = b->low[y * b->across + x];
    return (double)lowest;
}

cw_rectangle cw_reach_of_shadows(const reach_blocks *b, const reach_sunward *s, cw_rectangle part) {
    const double lowest = lowest_of(b, part);
    const box from = box_of(part);
    box all = from;
    size_t begin[2], stop[2];
    blocks_in_reach(b, s, &from, lowest, begin, stop);
    for (size_t y = begin[1]; y < stop[1] && lowest < INFINITY; y++)
        for (size_t x = begin[0]; x < stop[0]; x++) {
            const cw_rectangle block = cw_reach_block(b, x, y);
            double first, last;
            if (!(b->high[y * b->across + x] > -INFINITY) || !cw_reach_passes(s, part, block, &first, &last)) continue;
            const double over = (cw_reach_highest(b, x, y) - lowest) * terrain_metres_of_height(b->whole);
            if (s->tangent > 0) last = fmin(last, over / s->tangent);
            /* Terrain as low as a descending ray can hide it. */
            if (s->tangent < 0 && over < 0) first = fmax(first, over / s->tangent);
            if (!(first <= last)) continue;
            const box ends = box_of(block);
            for (int a = 0; a < 2; a++) {
                const double back = fmin(s->cells[a][0], 0), on = fmax(s->cells[a][1], 0);
                const double nearest = back < 0 ? from.low[a] + back * last : from.low[a],
                             farthest = on > 0 ? from.high[a] + on * last : from.high[a];
                all.low[a] = fmin(all.low[a], fmax(ends.low[a], nearest));
                all.high[a] = fmax(all.high[a], fmin(ends.high[a], farthest));
            }
        }
    return grown(b->whole, all, REACH_BESIDE, REACH_BESIDE);
}
