/* SPDX-License-Identifier: Apache-2.0 */
/* The 16 children of a node, or the 16 cells of a block, in walk order: lanes are places.
 *
 * Lane 4 y + x is the child in column x and row y of walk order (vorder), so the lowest set bit of a mask of
 * children is always the nearest: a ray goes through the 4 × 4 children along a monotone staircase. Descending takes
 * the lowest bit. Coming back up needs the rest of the mask, which is all the state of a level. */
#ifndef CELLWALK_SIMD_CHILDREN_H
#define CELLWALK_SIMD_CHILDREN_H

#include "field.h"
#include "vocabulary.h"

#include <math.h>

enum { CHILDREN = 16, CHILD_VECTORS = CHILDREN / W };

/* Column and row, in walk order, of the child in each lane. */
static const float lane_x[CHILDREN] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
static const float lane_y[CHILDREN] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

/* First row, in walk order, of a block with rows stride floats apart; and the step to the next row. */
static inline const float *first_row(const vorder *o, const float *block, size_t stride) {
    return block + (size_t)o->flip_y * stride;
}
static inline ptrdiff_t row_step(const vorder *o, size_t stride) {
    return o->flip_y == 0 ? (ptrdiff_t)stride : -(ptrdiff_t)stride;
}

/* The block's 5 × 5 samples: in place, or a copy with holes outside the field if part of the block lies outside. */
typedef struct block_samples {
    const float *z;
    size_t stride;
    float copy[5 * 5];
    float low[CHILDREN], high[CHILDREN]; /* lowest and highest sample of each cell, in walk order; set by fat_cells */
} block_samples;

static inline void load_samples(block_samples *s, const cw_field *f, size_t i, size_t j) {
    s->z = f->z + j * f->stride + i;
    s->stride = f->stride;
    if (i + 4 < f->nx && j + 4 < f->ny) return;
    for (size_t y = 0; y < 5; y++)
        for (size_t x = 0; x < 5; x++)
            s->copy[5 * y + x] = i + x < f->nx && j + y < f->ny ? s->z[y * s->stride + x] : NAN;
    s->z = s->copy;
    s->stride = 5;
}

#endif
