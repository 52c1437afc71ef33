/* SPDX-License-Identifier: Apache-2.0 */
#include "pyramid.h"

#include "field.h"
#include "memory.h"

#include <math.h>
#include <stdlib.h>

static size_t blocks(size_t n) { return (n + 3) / 4; }

/* Lowest and highest of each column over the rows of one row of blocks. */
static void column_bounds(const cw_field *f, size_t row, float *restrict low, float *restrict high) {
    const size_t last = row + 4 < f->ny - 1 ? row + 4 : f->ny - 1;
    for (size_t i = 0; i < f->nx; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (size_t j = row; j <= last; j++) {
        const float *restrict z = f->z + j * f->stride;
        for (size_t i = 0; i < f->nx; i++) {
            low[i] = lower(z[i], low[i]);
            high[i] = higher(z[i], high[i]);
        }
    }
}

static void set_bounds(float *node, float low, float high) {
    if (!(low <= high)) return; /* all holes */
    node[0] = low;
    node[16] = high;
}

static void build_blocks(const cw_field *f, const cw_pyramid_level *l, float *low, float *high) {
    for (size_t y = 0; y < blocks(f->ny - 1); y++) {
        column_bounds(f, 4 * y, low, high);
        for (size_t x = 0; x < blocks(f->nx - 1); x++) {
            const size_t last = 4 * x + 4 < f->nx - 1 ? 4 * x + 4 : f->nx - 1;
            float lo = INFINITY, hi = -INFINITY;
            for (size_t i = 4 * x; i <= last; i++) {
                lo = lower(low[i], lo);
                hi = higher(high[i], hi);
            }
            set_bounds(cw_pyramid_node(l, x, y), lo, hi);
        }
    }
}

static void build_level(const cw_pyramid_level *from, const cw_pyramid_level *to) {
    for (size_t y = 0; y < (size_t)from->down; y++)
        for (size_t x = 0; x < (size_t)from->across; x++) {
            const float *brick = cw_pyramid_node(from, 4 * x, 4 * y);
            float lo = INFINITY, hi = -INFINITY;
            for (int k = 0; k < 16; k++) {
                lo = lower(brick[k], lo);
                hi = higher(brick[16 + k], hi);
            }
            set_bounds(cw_pyramid_node(to, x, y), lo, hi);
        }
}

/* Separable: the highest of three nodes in a row, then of three such rows. */
static void build_around(const cw_pyramid_level *l, float *row[3]) {
    const size_t n = 4 * (size_t)l->across, rows = 4 * (size_t)l->down;
    for (size_t y = 0; y <= rows; y++) {
        float *below = row[(y + 2) % 3], *here = row[y % 3];
        for (size_t x = 0; x < n; x++) {
            if (y == rows) {
                here[x] = -INFINITY;
                continue;
            }
            float high = higher(cw_pyramid_node(l, x, y)[16], -INFINITY); /* a node of holes alone is NaN */
            if (x > 0) high = higher(cw_pyramid_node(l, x - 1, y)[16], high);
            if (x + 1 < n) high = higher(cw_pyramid_node(l, x + 1, y)[16], high);
            here[x] = high;
        }
        if (y == 0) {
            for (size_t x = 0; x < n; x++) below[x] = -INFINITY;
            continue;
        }
        float *out = l->around + (y - 1) * n, *further = row[(y + 1) % 3];
        for (size_t x = 0; x < n; x++) out[x] = higher(y >= 2 ? further[x] : -INFINITY, higher(below[x], here[x]));
    }
}

cw_status cw_pyramid_build(cw_field *f) {
    struct cw_pyramid *p = calloc(1, sizeof *p);
    float *columns = malloc((4 * f->nx + 64) * sizeof *columns); /* three rows of nodes fit as well */
    if (p == NULL || columns == NULL) goto no_memory;

    size_t bricks = 0, begin[PYRAMID_LEVELS_MAX];
    size_t x = blocks(f->nx - 1), y = blocks(f->ny - 1);
    float side = 4;
    do {
        cw_pyramid_level *l = &p->level[p->levels];
        x = blocks(x);
        y = blocks(y);
        *l = (cw_pyramid_level){.across = (int32_t)x, .down = (int32_t)y, .side = side};
        begin[p->levels++] = bricks;
        bricks += x * y;
        side *= 4;
    } while (x > 1 || y > 1);

    size_t slabs = 0;
    for (int l = 0; l < p->levels; l++) {
        const size_t node_side = (size_t)p->level[l].side;
        p->first[l + 1] = (int32_t)slabs;
        slabs += ((f->nx - 2) / node_side + 1) * ((f->ny - 2) / node_side + 1);
    }
    p->bytes = bricks * (BRICK_FLOATS + 16) * sizeof(float) + slabs * sizeof(cw_pyramid_slab);
    p->memory = cw_memory_allocate(p->bytes);
    if (p->memory == NULL) goto no_memory;
    for (int l = 0; l < p->levels; l++) {
        p->level[l].bricks = (float *)p->memory + begin[l] * BRICK_FLOATS;
        p->level[l].around = (float *)p->memory + bricks * BRICK_FLOATS + begin[l] * 16;
        const size_t count = (size_t)p->level[l].across * (size_t)p->level[l].down;
        for (size_t k = 0; k < count * BRICK_FLOATS; k++) p->level[l].bricks[k] = NAN;
    }
    p->slab = (cw_pyramid_slab *)((float *)p->memory + bricks * (BRICK_FLOATS + 16));
    build_blocks(f, &p->level[0], columns, columns + f->nx);
    for (int l = 1; l < p->levels; l++) build_level(&p->level[l - 1], &p->level[l]);
    cw_pyramid_build_slabs(p, f, columns);
    for (int l = 0; l < p->levels; l++) {
        const size_t n = 4 * (size_t)p->level[l].across;
        build_around(&p->level[l], (float *[3]){columns, columns + n, columns + 2 * n});
    }
    free(columns);
    p->high = f->high;
    f->pyramid = p;
    f->bytes_built += sizeof *p + p->bytes;
    return CW_OK;
no_memory:
    free(columns);
    cw_pyramid_destroy(p);
    return CW_ERROR_MEMORY;
}

void cw_pyramid_destroy(struct cw_pyramid *p) {
    if (p == NULL) return;
    cw_memory_free(p->memory);
    free(p);
}
