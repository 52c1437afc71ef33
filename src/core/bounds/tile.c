/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid's lower levels, tile by tile: 64 × 64 cells, whose samples come into the cache once for bounds and
 * slabs of blocks, of nodes of 16 × 16 cells and of the tile itself, instead of once for each of these.
 *
 * A slab's plane is the least-squares one, which on the regular grid has a closed form. How far the samples lie off
 * it is found from the samples themselves. All goes over columns, and at the end of columns from left to right: the order
 * of sums is part of the result, which is the same with any tiles and threads.
 *
 * Most of the work are blocks, of which a tile has 16 in a row. So that compilers vectorize the work from left to right too, the
 * tile is copied, and column k of all blocks lies together: sample i of a row at (i % 4) * LANES + i / 4. */

#include "pyramid.h"

#include <float.h>

enum { COLUMNS = TILE_SIDE + 1, BLOCKS = TILE_SIDE / 4, LANES = BLOCKS + 1, PARTED = 4 * LANES };

/* All of these must see the constants of blocks. */
#define INLINE static inline __attribute__((always_inline))

/* Samples column to last_column, row to last_row, all in. */
typedef struct tile {
    const cw_field *f;
    struct cw_pyramid *p;
    size_t column, row, last_column, last_row;
    float steepest; /* so far */
    float z[COLUMNS * PARTED];
} tile;

/* Beyond the field's far borders there are holes. Of columns k > 0 the last lane has no sample. */
static void copy_samples(tile *t) {
    const size_t columns = t->last_column - t->column + 1, rows = t->last_row - t->row + 1;
    for (size_t j = 0; j < COLUMNS; j++) {
        const float *z = t->f->z + (t->row + least(j, rows - 1)) * t->f->stride + t->column;
        float *restrict to = t->z + j * PARTED, whole[COLUMNS];
        const size_t some = j < rows ? columns : 0;
        for (size_t i = 0; i < COLUMNS && some < COLUMNS; i++) whole[i] = i < some ? z[i] : NAN;
        if (some < COLUMNS) z = whole;
        for (size_t x = 0; x < BLOCKS; x++) {
            to[x] = z[4 * x];
            to[LANES + x] = z[4 * x + 1];
            to[2 * LANES + x] = z[4 * x + 2];
            to[3 * LANES + x] = z[4 * x + 3];
        }
        for (size_t k = 0; k < 4; k++) to[k * LANES + BLOCKS] = k == 0 ? z[TILE_SIDE] : 0;
    }
}

/* A row of nodes in the tile. If they are blocks, it ends with the tile, and a block that the field ends in has holes. */
typedef struct node_row {
    const float *z; /* its first sample */
    size_t side, nodes, last_column;
    size_t rows; /* of samples */
} node_row;

/* Cells of node x along x; and the place in a row of the samples in its column k. */
INLINE size_t width(const node_row *r, size_t x) { return least(r->side, r->last_column - x * r->side); }
INLINE size_t place(const node_row *r, size_t x, size_t k) { return k % 4 * LANES + x * (r->side / 4) + k / 4; }

/* Of each column: sums of samples, and of these times the row's distance from the middle. */
typedef struct column_sums {
    float sum[PARTED], moment[PARTED], low[PARTED], high[PARTED];
} column_sums;

INLINE void add_rows(const node_row *r, size_t begin, size_t end, column_sums *s) {
    const float middle = 0.5f * (float)(r->rows - 1);
    for (size_t j = begin; j < end; j++) {
        const float *restrict z = r->z + j * PARTED;
        const float dy = (float)j - middle;
        for (size_t c = 0; c < PARTED; c++) {
            s->sum[c] += z[c];
            s->moment[c] += dy * z[c];
            s->low[c] = lower(z[c], s->low[c]);
            s->high[c] = higher(z[c], s->high[c]);
        }
    }
}

/* What is found of each node: bounds of its samples, the plane, and bounds of their distances from it. */
typedef struct found_nodes {
    float low[BLOCKS], high[BLOCKS], slope_x[BLOCKS], slope_y[BLOCKS], below[BLOCKS], above[BLOCKS];
} found_nodes;

INLINE void fit_planes(const node_row *r, const column_sums *s, found_nodes *n) {
    const float rows = (float)r->rows;
    for (size_t x = 0; x < r->nodes; x++) {
        const size_t cells = width(r, x);
        const float m = (float)(cells + 1), half = 0.5f * (float)cells;
        float along_x = 0, along_y = 0, low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k <= cells; k++) {
            const size_t c = place(r, x, k);
            along_x += ((float)k - half) * s->sum[c];
            along_y += s->moment[c];
            low = lower(s->low[c], low);
            high = higher(s->high[c], high);
        }
        /* m numbers one apart have the sum of squares m (m² - 1) / 12 about their middle. */
        const float slope_x = along_x * 12 / (m * (m * m - 1) * rows),
                    slope_y = along_y * 12 / (rows * (rows * rows - 1) * m);
        const bool flat = !(fabsf(slope_x) + fabsf(slope_y) <= FLT_MAX); /* holes, or heights near the end of floats */
        n->slope_x[x] = flat ? 0 : slope_x;
        n->slope_y[x] = flat ? 0 : slope_y;
        n->low[x] = low;
        n->high[x] = high;
    }
}

INLINE void measure_distances(const node_row *r, found_nodes *n) {
    float plane[PARTED] = {0}, slope_y[PARTED] = {0}, low[PARTED], high[PARTED];
    const float middle = 0.5f * (float)r->side;
    for (size_t k = 0; k < r->side; k++)
        for (size_t x = 0; x < r->nodes; x++) {
            plane[place(r, x, k)] = n->slope_x[x] * ((float)k - middle);
            slope_y[place(r, x, k)] = n->slope_y[x];
        }
    for (size_t c = 0; c < PARTED; c++) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
    }
    for (size_t j = 0; j < r->rows; j++) {
        const float *restrict z = r->z + j * PARTED;
        const float dy = (float)j - middle;
        for (size_t c = 0; c < PARTED; c++) {
            const float d = z[c] - (plane[c] + dy * slope_y[c]);
            low[c] = lower(d, low[c]);
            high[c] = higher(d, high[c]);
        }
    }
    for (size_t x = 0; x < r->nodes; x++) {
        float below = INFINITY, above = -INFINITY;
        const size_t cells = width(r, x); /* the last column is the next node's first */
        for (size_t k = 0; k < cells; k++) {
            below = lower(low[place(r, x, k)], below);
            above = higher(high[place(r, x, k)], above);
        }
        const float across = n->slope_x[x] * ((float)cells - middle);
        for (size_t j = 0; j < r->rows; j++) {
            const float d = r->z[j * PARTED + place(r, x, cells)] - (across + ((float)j - middle) * n->slope_y[x]);
            below = lower(d, below);
            above = higher(d, above);
        }
        n->below[x] = below;
        n->above[x] = above;
    }
}

static cw_pyramid_sum *tile_sum(const tile *t) {
    return &t->p->sum[TILE_LEVEL][t->row / TILE_SIDE * cw_pyramid_across(t->f, TILE_LEVEL) + t->column / TILE_SIDE];
}

/* Sums from which the planes of larger nodes are fitted. */
static void add_up(const tile *t, const node_row *r, const column_sums *sums) {
    const double middle = 0.5 * (double)(r->rows - 1);
    const size_t owned = t->last_column == t->f->nx - 1 ? r->last_column + 1 : r->last_column;
    cw_pyramid_sum s = {0};
    for (size_t i = 0; i < owned; i++) {
        const double sum = (double)sums->sum[place(r, 0, i)];
        s.z += sum;
        s.xz += (double)i * sum;
        s.yz += (double)sums->moment[place(r, 0, i)] + middle * sum;
    }
    if (!(fabs(s.z) + fabs(s.xz) + fabs(s.yz) <= DBL_MAX)) s.z = s.xz = s.yz = (double)NAN;
    *tile_sum(t) = s;
}

/* The nodes of a level in row y of the tile. */
INLINE void do_nodes(tile *t, int level, size_t y) {
    const size_t side = (size_t)4 << 2 * level, columns = t->last_column - t->column, rows = t->last_row - t->row;
    const size_t nodes = (columns - 1) / side + 1, blocks = level == 0;
    const node_row r = {
        .z = t->z + y * side * PARTED,
        .side = side,
        .nodes = blocks ? BLOCKS : nodes,
        .last_column = blocks ? TILE_SIDE : columns,
        .rows = (blocks ? 4 : least(side, rows - y * side)) + 1,
    };
    const size_t owned = level == TILE_LEVEL && t->last_row < t->f->ny - 1 ? r.rows - 1 : r.rows;
    column_sums s;
    for (size_t c = 0; c < PARTED; c++) {
        s.sum[c] = s.moment[c] = 0;
        s.low[c] = INFINITY;
        s.high[c] = -INFINITY;
    }
    add_rows(&r, 0, owned, &s);
    if (level == TILE_LEVEL) add_up(t, &r, &s);
    if (level >= t->p->levels) return;
    add_rows(&r, owned, r.rows, &s);
    found_nodes n;
    fit_planes(&r, &s, &n);
    measure_distances(&r, &n);
    const size_t first = t->column / side, row = t->row / side + y;
    cw_pyramid_slab *slab = t->p->slab + (size_t)t->p->first[level + 1] + row * cw_pyramid_across(t->f, level) + first;
    for (size_t x = 0; x < nodes; x++) {
        cw_pyramid_set_bounds(cw_pyramid_node(&t->p->level[level], first + x, row), n.low[x], n.high[x]);
        slab[x] = (cw_pyramid_slab){n.below[x], n.above[x], n.slope_x[x], n.slope_y[x]};
        t->steepest = higher(cw_slab_outward(&slab[x], t->f, n.low[x], n.high[x]), t->steepest);
    }
    if (level == TILE_LEVEL) tile_sum(t)->slab = (cw_pyramid_slab){n.below[0], n.above[0], n.slope_x[0], n.slope_y[0]};
}

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
    tile t;
    t.f = f;
    t.p = p;
    t.column = x * TILE_SIDE;
    t.row = y * TILE_SIDE;
    t.last_column = least(t.column + TILE_SIDE, f->nx - 1);
    t.last_row = least(t.row + TILE_SIDE, f->ny - 1);
    t.steepest = 0;
    copy_samples(&t);
    const size_t last = t.last_row - t.row - 1;
    for (int l = 0; l < TILE_LEVEL && l < p->levels; l++) clear_bricks(&t, l);
    for (size_t k = 0; k <= last / 4; k++) do_nodes(&t, 0, k);
    for (int l = 1; l <= TILE_LEVEL; l++)
        for (size_t k = 0; k <= last >> (2 * l + 2); k++)
            if (l < p->levels || l == TILE_LEVEL) do_nodes(&t, l, k);
    tile_sum(&t)->steepest = (double)t.steepest;
}
