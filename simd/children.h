/* SPDX-License-Identifier: Apache-2.0 */
/* The 16 children of a node, or the 16 cells of a block: lane 4 y + x is the one in row y and column x.
 *
 * A ray goes through them along a monotone staircase. In walk order columns are numbered from where it enters if it
 * goes up in y, and else from where it leaves. So the nearest of some children is the lowest or the highest bit of
 * their mask. Descending takes that bit. Coming back up needs the rest of the mask, which is all the state of a level.
 * Rejected: lanes in walk order, but for the 16 of a ray alone (one_kernel.c, papers/walks.md). */
#ifndef CELLWALK_SIMD_CHILDREN_H
#define CELLWALK_SIMD_CHILDREN_H

#include "field.h"
#include "vocabulary.h"

#include <math.h>

enum { CHILDREN = 16, CHILD_VECTORS = CHILDREN / W };

/* Low and high border of the child in each lane, in sides of a child. */
static const float lane_x[2][CHILDREN] = {{0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3},
                                          {1, 2, 3, 4, 1, 2, 3, 4, 1, 2, 3, 4, 1, 2, 3, 4}};
static const float lane_y[2][CHILDREN] = {{0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3},
                                          {1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4}};
/* Columns are the same in each row, so vectors of whole rows share what follows from them. */
enum { COLUMNS_STEP = W < 4 ? W : 0 };

/* Whether a ray goes up along the axes. */
typedef struct quadrant {
    bool up_x, up_y;
} quadrant;

/* Bit k of a mask in walk order is child k XOR this. */
static inline int turn(quadrant q) { return q.up_x == q.up_y ? 0 : 3; }

static inline unsigned in_walk_order(unsigned lanes, quadrant q) {
    if (q.up_x == q.up_y) return lanes;
    lanes = (lanes & 0x5555) << 1 | (lanes >> 1 & 0x5555);
    return (lanes & 0x3333) << 2 | (lanes >> 2 & 0x3333);
}

/* Bit of a mask in walk order. */
static inline int nearest(unsigned mask, quadrant q) { return q.up_y ? __builtin_ctz(mask) : 31 - __builtin_clz(mask); }

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
