/* SPDX-License-Identifier: Apache-2.0 */
/* The 16 children of a node, or the 16 cells of a block: lanes are places.
 *
 * Lane 4 y + x is the child in row y of walk order, counted from where the ray enters y, and in column x of the field. Masks of
 * children are in walk order along x too, so their lowest set bit is always the nearest: a ray goes through the 4 × 4 children
 * along a monotone staircase. Descending takes the lowest bit. Coming back up needs the rest of the mask, which is all the state
 * of a level. */
#ifndef CELLWALK_SIMD_CHILDREN_H
#define CELLWALK_SIMD_CHILDREN_H

#include "field.h"
#include "vocabulary.h"

#include <math.h>

enum { CHILDREN = 16, CHILD_VECTORS = CHILDREN / W };

/* Column, for rays that go down and up in x, and row, in walk order, of the child in each lane. */
static const float lane_x[2][CHILDREN] = {{3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0, 3, 2, 1, 0},
                                          {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}};
static const float lane_y[CHILDREN] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
/* Columns are the same in each row, so vectors of whole rows share what follows from them. */
enum { COLUMNS_STEP = W < 4 ? W : 0 };

/* A mask of lanes in walk order. */
static inline unsigned in_walk_order(unsigned lanes, bool up_x) {
    if (up_x) return lanes;
    lanes = (lanes & 0x5555) << 1 | (lanes >> 1 & 0x5555);
    return (lanes & 0x3333) << 2 | (lanes >> 2 & 0x3333);
}

/* Number in walk order, XOR this, is the number in the field. */
static inline int flip(bool up) { return up ? 0 : 3; }

/* First row, in walk order, of a block with rows stride floats apart; and the step to the next row. */
static inline const float *first_row(bool up_y, const float *block, size_t stride) {
    return block + (size_t)flip(up_y) * stride;
}
static inline ptrdiff_t row_step(bool up_y, size_t stride) { return up_y ? (ptrdiff_t)stride : -(ptrdiff_t)stride; }

/* The block's 5 × 5 samples: in place, or a copy with holes outside the field if part of the block lies outside. */
typedef struct block_samples {
    const float *z;
    size_t stride;
    float copy[5 * 5];
    float low[CHILDREN], high[CHILDREN]; /* lowest and highest sample of each cell, by lanes; set by fat_cells */
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
