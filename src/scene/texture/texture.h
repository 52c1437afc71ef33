/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: a pyramid of halved images (Williams 1983), of half-precision floats. Looking colours up is the
 * renderer's work, for many paths at once (render/lookup.inc.h). */
#ifndef CELLWALK_SCENE_TEXTURE_H
#define CELLWALK_SCENE_TEXTURE_H

#include "image.h"

#include <stdint.h>

enum { TEXTURE_LEVELS = 32 };

/* Rows of a level have a texel more on each side, what follows there when the image repeats: so two neighbours always stand
 * side by side. Texel (x, y), for x from -1 to width, is number first + y * stride + x + 1. */
typedef struct texture_level {
    int32_t width, height, stride, first;
} texture_level;

typedef struct texture {
    int count;
    texture_level levels[TEXTURE_LEVELS];
    uint16_t *texels; /* four halves each, the last of them 0 */
} texture;

/* Takes over the image's pixels and builds the smaller levels. NULL when out of memory or too large; the image is then
 * still the caller's. */
texture *texture_create(io_image *image);
void texture_free(texture *t);

#endif
