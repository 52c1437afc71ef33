/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: a pyramid of halved images (Williams 1983), of half-precision floats. Looking colours up is the
 * renderer's work, for many paths at once (render/lookup.inc.h). */
#ifndef CELLWALK_SCENE_TEXTURE_H
#define CELLWALK_SCENE_TEXTURE_H

#include "image.h"

#include <stdint.h>

enum { TEXTURE_LEVELS = 32 };

/* Rows of a level have one more texel on each side, from the repeated image, so two neighbours always stand
 * side by side. Texel (x, y), for x from -1 to width, is number first + y * stride + x + 1. */
typedef struct texture_level {
    int32_t width, height, stride, first;
} texture_level;

typedef struct texture {
    bool clamps; /* beyond its borders stands the border's colour; else the image repeats */
    int count;
    texture_level levels[TEXTURE_LEVELS];
    uint16_t *texels; /* four halves each, the last of them 0 */
} texture;

/* Takes an image that was read over into a texture that is all zero. False if it is too large; the image is then still
 * the caller's. */
bool texture_fill(texture *t, io_image *image);
void texture_free(texture *t);

#endif
