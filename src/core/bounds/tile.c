/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid's lower levels, tile by tile: 64 × 64 cells, whose samples come into the cache once for bounds and
 * slabs of blocks, of nodes of 16 × 16 cells and of the tile itself, instead of once for each of these.
 *
 * A slab's plane is the least-squares one, which on the regular grid has a closed form. How far the samples lie off
 * it is found from the samples themselves. All goes over columns, so that compilers vectorize it, and at the end of
 * columns from left to right: the order of sums is part of the result, which is the same with any tiles and threads.
 * A copy of the tile, for rows of 2^k + 1 samples that fall on the same few sets of a cache, cost 1.1 times the time
 * of building 4097² and 8193². */

#include "pyramid.h"

#include <float.h>

enum { COLUMNS = TILE_SIDE + 1 };

/* Samples column to last_column, row to last_row, all in. */
typedef struct tile {
    const cw_field *f;
    struct cw_pyramid *p;
    size_t column, row, last_column, last_row;
    double steepest; /* so far */
} tile;

/* ---- nodes of any size up to the tile's -------------------------------------------------------------------------- */

/* A row of nodes in the tile. */
typedef struct node_row {
    const float *z; /* its first sample */
    size_t stride, side, nodes;
    size_t columns, rows; /* samples */
    cw_pyramid_slab *slab;
} node_row;

static node_row row_of_nodes(const tile *t, int level, size_t y) {
    const size_t side = (size_t)4 << (2 * level), first = t->row + y * side;
    const size_t number = (first / side) * cw_pyramid_across(t->f, level) + t->column / side;
    return (node_row){
        .z = t->f->z + first * t->f->stride + t->column,
        .stride = t->f->stride,
        .side = side,
        .nodes = (t->last_column - t->column - 1) / side + 1,
        .columns = t->last_column - t->column + 1,
        .rows = least(side, t->last_row - first) + 1,
        .slab = t->p->slab + (size_t)t->p->first[level + 1] + number,
    };
}

static size_t last_column(const node_row *r, size_t x) { return least((x + 1) * r->side, r->columns - 1); }

/* Sums over the rows begin to end of z, and of z times the row's distance from the middle. */
static void sum_rows(const node_row *r, size_t begin, size_t end, float sum[COLUMNS], float moment[COLUMNS]) {
    const float middle = 0.5f * (float)(r->rows - 1);
    for (size_t j = begin; j < end; j++) {
        const float *restrict z = r->z + j * r->stride;
        const float dy = (float)j - middle;
        for (size_t i = 0; i < r->columns; i++) {
            sum[i] += z[i];
            moment[i] += dy * z[i];
        }
    }
}

static void fit_planes(const node_row *r, const float sum[COLUMNS], const float moment[COLUMNS]) {
    const float n = (float)r->rows;
    for (size_t x = 0; x < r->nodes; x++) {
        const size_t begin = x * r->side, end = last_column(r, x);
        const float m = (float)(end - begin + 1), half = 0.5f * (float)(end - begin);
        float along_x = 0, along_y = 0;
        for (size_t i = begin; i <= end; i++) {
            along_x += ((float)(i - begin) - half) * sum[i];
            along_y += moment[i];
        }
        /* m numbers one apart have the sum of squares m (m² - 1) / 12 about their middle. */
        const float slope_x = along_x * 12 / (m * (m * m - 1) * n), slope_y = along_y * 12 / (n * (n * n - 1) * m);
        const bool flat = !(fabsf(slope_x) + fabsf(slope_y) <= FLT_MAX); /* holes, or heights near the end of floats */
        r->slab[x] = (cw_pyramid_slab){INFINITY, -INFINITY, flat ? 0 : slope_x, flat ? 0 : slope_y};
    }
}

static void measure_distances(const node_row *r) {
    float plane[COLUMNS], slope_y[COLUMNS], low[COLUMNS], high[COLUMNS];
    const float middle = 0.5f * (float)r->side;
    for (size_t x = 0; x < r->nodes; x++)
        for (size_t i = x * r->side; i <= last_column(r, x); i++) { /* the last column is the next node's first */
            plane[i] = r->slab[x].slope_x * ((float)(i - x * r->side) - middle);
            slope_y[i] = r->slab[x].slope_y;
        }
    for (size_t i = 0; i < r->columns; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (size_t j = 0; j < r->rows; j++) {
        const float *restrict z = r->z + j * r->stride;
        const float dy = (float)j - middle;
        for (size_t i = 0; i < r->columns; i++) {
            const float d = z[i] - (plane[i] + dy * slope_y[i]);
            low[i] = lower(d, low[i]);
            high[i] = higher(d, high[i]);
        }
    }
    for (size_t x = 0; x < r->nodes; x++) {
        cw_pyramid_slab *s = &r->slab[x];
        const size_t begin = x * r->side, end = last_column(r, x);
        for (size_t i = begin; i < end; i++) {
            s->low = lower(low[i], s->low);
            s->high = higher(high[i], s->high);
        }
        const float across = s->slope_x * ((float)(end - begin) - middle);
        for (size_t j = 0; j < r->rows; j++) {
            const float d = r->z[j * r->stride + end] - (across + ((float)j - middle) * s->slope_y);
            s->low = lower(d, s->low);
            s->high = higher(d, s->high);
        }
    }
}

static cw_pyramid_sum *tile_sum(const tile *t) {
    return &t->p->sum[TILE_LEVEL][t->row / TILE_SIDE * cw_pyramid_across(t->f, TILE_LEVEL) + t->column / TILE_SIDE];
}

/* Sums from which the planes of larger nodes are fitted. */
static void add_up(const tile *t, const node_row *r, const float sum[COLUMNS], const float moment[COLUMNS]) {
    const double middle = 0.5 * (double)(r->rows - 1);
    const size_t owned = t->last_column == t->f->nx - 1 ? r->columns : r->columns - 1;
    cw_pyramid_sum s = {0};
    for (size_t i = 0; i < owned; i++) {
        s.z += (double)sum[i];
        s.xz += (double)i * (double)sum[i];
        s.yz += (double)moment[i] + middle * (double)sum[i];
    }
    if (!(fabs(s.z) + fabs(s.xz) + fabs(s.yz) <= DBL_MAX)) s.z = s.xz = s.yz = (double)NAN;
    *tile_sum(t) = s;
}

static void do_nodes(tile *t, int level, size_t y) {
    float sum[COLUMNS] = {0}, moment[COLUMNS] = {0};
    const node_row r = row_of_nodes(t, level, y);
    const size_t owned = level == TILE_LEVEL && t->last_row < t->f->ny - 1 ? r.rows - 1 : r.rows;
    sum_rows(&r, 0, owned, sum, moment);
    if (level == TILE_LEVEL) add_up(t, &r, sum, moment);
    if (level >= t->p->levels) return;
    sum_rows(&r, owned, r.rows, sum, moment);
    fit_planes(&r, sum, moment);
    measure_distances(&r);
    if (level == TILE_LEVEL) tile_sum(t)->slab = r.slab[0];
    for (size_t x = 0; x < r.nodes; x++) {
        const float *bounds = cw_pyramid_node(&t->p->level[level], t->column / r.side + x, t->row / r.side + y);
        t->steepest = fmax((double)cw_slab_outward(&r.slab[x], t->f, bounds[0], bounds[16]), t->steepest);
    }
}

/* ---- blocks, which are most of the work -------------------------------------------------------------------------- */

/* A tile has 16 blocks in a row, which are the lanes here. Column k of all blocks lies together: sample i of a row at
 * (i % 4) * LANES + i / 4. Of k > 0 the last lane has none. Beyond the field's far borders are holes, so that a block
 * with fewer than 4 × 4 cells has a level slab. Rejected: larger nodes' code, 1.7 times as long for 65² and 257². */
enum { BLOCKS = TILE_SIDE / 4, LANES = BLOCKS + 1, PARTED = 4 * LANES };
typedef float lanes[BLOCKS];

static void part(const float *restrict z, float *restrict to) {
    for (size_t x = 0; x < BLOCKS; x++) {
        to[x] = z[4 * x];
        to[LANES + x] = z[4 * x + 1];
        to[2 * LANES + x] = z[4 * x + 2];
        to[3 * LANES + x] = z[4 * x + 3];
    }
    to[BLOCKS] = z[TILE_SIDE];
    for (size_t k = 1; k < 4; k++) to[k * LANES + BLOCKS] = 0;
}

/* Planes of the blocks over five rows, as fit_planes has them, and their bounds. */
static void fit_blocks(const float *restrict row, lanes slope_x, lanes slope_y, lanes low, lanes high) {
    float sum[PARTED], moment[PARTED], least_of[PARTED], most_of[PARTED];
    for (size_t c = 0; c < PARTED; c++) {
        float s = 0, m = 0, lo = INFINITY, hi = -INFINITY;
        for (size_t j = 0; j < 5; j++) {
            const float z = row[j * PARTED + c];
            s += z;
            m += ((float)j - 2) * z;
            lo = lower(z, lo);
            hi = higher(z, hi);
        }
        sum[c] = s;
        moment[c] = m;
        least_of[c] = lo;
        most_of[c] = hi;
    }
    for (size_t x = 0; x < BLOCKS; x++) {
        float along_x = 0, along_y = 0, lo = INFINITY, hi = -INFINITY;
        for (size_t k = 0; k < 5; k++) {
            const size_t c = k % 4 * LANES + x + k / 4;
            along_x += ((float)k - 2) * sum[c];
            along_y += moment[c];
            lo = lower(least_of[c], lo);
            hi = higher(most_of[c], hi);
        }
        const float sx = along_x * 12 / 600, sy = along_y * 12 / 600; /* 600 = 5 (5² - 1) 5 */
        const bool flat = !(fabsf(sx) + fabsf(sy) <= FLT_MAX);
        slope_x[x] = flat ? 0 : sx;
        slope_y[x] = flat ? 0 : sy;
        low[x] = lo;
        high[x] = hi;
    }
}

static void measure_blocks(const float *restrict row, const lanes slope_x, const lanes slope_y, float *restrict low,
                           float *restrict high) {
    for (size_t x = 0; x < BLOCKS; x++) {
        low[x] = INFINITY;
        high[x] = -INFINITY;
    }
    for (size_t k = 0; k < 5; k++) {
        const float *z = row + k % 4 * LANES + k / 4;
        for (size_t x = 0; x < BLOCKS; x++) {
            const float plane = slope_x[x] * ((float)k - 2);
            float lo = low[x], hi = high[x];
            for (size_t j = 0; j < 5; j++) {
                const float d = z[j * PARTED + x] - (plane + ((float)j - 2) * slope_y[x]);
                lo = lower(d, lo);
                hi = higher(d, hi);
            }
            low[x] = lo;
            high[x] = hi;
        }
    }
}

static void do_blocks(tile *t) {
    float row[COLUMNS * PARTED], whole[COLUMNS];
    const size_t columns = t->last_column - t->column, rows = t->last_row - t->row;
    for (size_t j = 0; j < COLUMNS; j++) {
        const float *z = t->f->z + (t->row + least(j, rows)) * t->f->stride + t->column;
        const size_t some = j <= rows ? columns + 1 : 0;
        for (size_t i = 0; i < COLUMNS && some < COLUMNS; i++) whole[i] = i < some ? z[i] : NAN;
        part(some < COLUMNS ? whole : z, row + j * PARTED);
    }
    float steepest = 0;
    for (size_t y = 0; 4 * y < rows; y++) {
        lanes slope_x, slope_y, node_low, node_high, low, high;
        fit_blocks(row + 4 * y * PARTED, slope_x, slope_y, node_low, node_high);
        measure_blocks(row + 4 * y * PARTED, slope_x, slope_y, low, high);
        cw_pyramid_slab *slab = row_of_nodes(t, 0, y).slab;
        for (size_t x = 0; 4 * x < columns; x++) {
            float *node = cw_pyramid_node(&t->p->level[0], t->column / 4 + x, t->row / 4 + y);
            cw_pyramid_set_bounds(node, node_low[x], node_high[x]);
            slab[x] = (cw_pyramid_slab){low[x], high[x], slope_x[x], slope_y[x]};
            steepest = higher(cw_slab_outward(&slab[x], t->f, node_low[x], node_high[x]), steepest);
        }
    }
    t->steepest = (double)steepest;
}

/* ---- the tile ---------------------------------------------------------------------------------------------------- */

/* Bricks that reach beyond the field have nodes that are never set. */
static void clear_bricks(const tile *t, int level) {
    const cw_pyramid_level *l = &t->p->level[level];
    const size_t shift = (size_t)(2 * level + 4);
    for (size_t y = t->row >> shift; y <= (t->last_row - 1) >> shift; y++)
        for (size_t x = t->column >> shift; x <= (t->last_column - 1) >> shift; x++) {
            float *brick = cw_pyramid_node(l, 4 * x, 4 * y);
            for (int k = 0; k < BRICK_FLOATS; k++) brick[k] = NAN;
        }
}

void cw_pyramid_tile(const cw_field *f, struct cw_pyramid *p, size_t x, size_t y) {
    tile t = {.f = f, .p = p, .column = x * TILE_SIDE, .row = y * TILE_SIDE};
    t.last_column = least(t.column + TILE_SIDE, f->nx - 1);
    t.last_row = least(t.row + TILE_SIDE, f->ny - 1);
    for (int l = 0; l < TILE_LEVEL && l < p->levels; l++) clear_bricks(&t, l);
    do_blocks(&t);
    for (int l = 1; l <= TILE_LEVEL && l < p->levels; l++) {
        const size_t shift = (size_t)(2 * l + 2);
        for (size_t b = t.row >> shift; b <= (t.last_row - 1) >> shift; b++)
            for (size_t a = t.column >> shift; a <= (t.last_column - 1) >> shift; a++)
                cw_pyramid_bound_brick(&p->level[l - 1], &p->level[l], a, b);
    }
    for (int l = 1; l <= TILE_LEVEL; l++)
        for (size_t k = 0; k <= (t.last_row - t.row - 1) >> (2 * l + 2); k++)
            if (l < p->levels || l == TILE_LEVEL) do_nodes(&t, l, k);
    tile_sum(&t)->steepest = t.steepest;
}
