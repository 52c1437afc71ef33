/* SPDX-License-Identifier: Apache-2.0 */
/* The perspective camera: rays through the pixels of a block, which look almost the same way. */
#ifndef CELLWALK_SCENE_CAMERA_H
#define CELLWALK_SCENE_CAMERA_H

#include "model.h"
#include "spread.h"

#include <stdint.h>

/* Pixels a side of a block, and in a block. */
enum { CAMERA_SIDE = 4, CAMERA_BLOCK = CAMERA_SIDE * CAMERA_SIDE };

typedef struct camera {
    double corner[3],
        along[2][3];       /* the way through the picture's upper left corner, and its change from pixel to pixel */
    float across[2][3];    /* along, in float */
    float depth[3];        /* its product with any of these ways is 1 */
    float sample_distance; /* in pixels, on average */
} camera;

/* A block's upper left pixel and its pixels' seeds. */
typedef struct camera_block {
    float corner[3];
    uint32_t seed[2][CAMERA_BLOCK];
} camera_block;

camera camera_of(const scene *s, unsigned samples);

camera_block camera_block_at(const camera *c, size_t x, size_t y);

/* Unit directions through one sample of each pixel, row by row. */
void camera_directions(const camera *c, const camera_block *block, unsigned sample, float dir[3][CAMERA_BLOCK]);

/* How the rays of neighbouring samples spread around one in direction dir. */
void camera_spread(const camera *c, const float dir[3], ray_spread *spread);

#endif
