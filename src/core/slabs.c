/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs: a plane through the samples of each node of the pyramid, and how far they lie off it.
 *
 * The plane is the least-squares one, which on the regular grid has a closed form. Where the samples lie is found exactly,
 * from the samples, at all levels: slabs of slabs are 1.2 times as thick at 16 cells and 1.6 times at the top, for which
 * random rays pay with 18 % more steps. Sums run over columns, so that compilers vectorize them at any node size. */

#include "pyramid.h"

#include <float.h>
#include <math.h>

/* Work space, a float for each column of samples. */
typedef struct columns {
    float *sum, *moment; /* over the rows of a row of nodes: of z, and of z times the row's distance from the middle */
    float *low, *high;   /* distances from the plane */
} columns;

/* The nodes in one row of a level: samples first_row to last_row, both in. */
typedef struct node_row {
    const cw_field *f;
    cw_pyramid_slab *slab;
    size_t nodes, side, first_row, last_row;
} node_row;

static size_t last_column(const node_row *r, size_t x) {
    const size_t last = (x + 1) * r->side;
    return last < r->f->nx - 1 ? last : r->f->nx - 1;
}

static void fit_planes(const node_row *r, const columns *c) {
    const size_t nx = r->f->nx, rows = r->last_row - r->first_row;
    const float middle = 0.5f * (float)rows;
    float *restrict sum = c->sum, *restrict moment = c->moment;
    for (size_t i = 0; i < nx; i++) sum[i] = moment[i] = 0;
    for (size_t j = 0; j <= rows; j++) {
        const float *restrict z = r->f->z + (r->first_row + j) * r->f->stride;
        const float dy = (float)j - middle;
        for (size_t i = 0; i < nx; i++) {
            sum[i] += z[i];
            moment[i] += dy * z[i];
        }
    }
    const float n = (float)(rows + 1);
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

static void measure_distances(const node_row *r, const columns *c) {
    const size_t nx = r->f->nx, stride = r->f->stride;
    float *restrict plane = c->sum, *restrict slope_y = c->moment, *restrict low = c->low, *restrict high = c->high;
    const float middle = 0.5f * (float)r->side;
    for (size_t x = 0; x < r->nodes; x++)
        for (size_t i = x * r->side; i <= last_column(r, x); i++) { /* the last column is the next node's first */
            plane[i] = r->slab[x].slope_x * ((float)(i - x * r->side) - middle);
            slope_y[i] = r->slab[x].slope_y;
        }
    for (size_t i = 0; i < nx; i++) {
        low[i] = INFINITY;
        high[i] = -INFINITY;
    }
    for (size_t j = 0; j <= r->last_row - r->first_row; j++) {
        const float *restrict z = r->f->z + (r->first_row + j) * stride;
        const float dy = (float)j - middle;
        for (size_t i = 0; i < nx; i++) {
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
        const float *z = r->f->z + r->first_row * stride + end, across = s->slope_x * ((float)(end - begin) - middle);
        for (size_t j = 0; j <= r->last_row - r->first_row; j++) {
            const float d = z[j * stride] - (across + ((float)j - middle) * s->slope_y);
            s->low = lower(d, s->low);
            s->high = higher(d, s->high);
        }
    }
}

/* Sets the slab outward, or level where that makes it no thicker: between the node's lowest and highest sample no room for
 * a ray's place is needed (papers/numerics.md). Returns the largest slope in it. */
static float set_outward(cw_pyramid_slab *s, const cw_field *f, float low, float high) {
    if (!(s->low <= s->high)) return 0;
    const float slope = fabsf(s->slope_x) + fabsf(s->slope_y) + (s->high - s->low);
    const float pad = SLAB_ROUNDING * (2 * (float)(f->nx + f->ny) * slope);
    if (s->high - s->low + 2 * pad < high - low) {
        s->low -= pad;
        s->high += pad;
        return slope;
    }
    *s = (cw_pyramid_slab){low, high, 0, 0};
    return high - low;
}

void cw_pyramid_build_slabs(struct cw_pyramid *p, const cw_field *f, float *columns_of_floats) {
    const columns c = {columns_of_floats, columns_of_floats + f->nx, columns_of_floats + 2 * f->nx,
                       columns_of_floats + 3 * f->nx};
    p->steepest = 0;
    for (int l = 0; l < p->levels; l++) {
        const cw_pyramid_level *level = &p->level[l];
        const size_t side = (size_t)level->side, across = (f->nx - 2) / side + 1, down = (f->ny - 2) / side + 1;
        for (size_t y = 0; y < down; y++) {
            cw_pyramid_slab *row = p->slab + (size_t)p->first[l + 1] + y * across;
            const size_t last = (y + 1) * side < f->ny - 1 ? (y + 1) * side : f->ny - 1;
            const node_row r = {f, row, across, side, y * side, last};
            fit_planes(&r, &c);
            measure_distances(&r, &c);
            for (size_t x = 0; x < across; x++) {
                const float *bounds = cw_pyramid_node(level, x, y);
                p->steepest = higher(set_outward(&row[x], f, bounds[0], bounds[16]), p->steepest);
            }
        }
    }
}
