/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces: a pyramid of halved images (Williams 1983), of half-precision floats. Looking colours up is the
 * renderer's work, for many paths at once (render/lookup.inc.h). */
#ifndef CELLWALK_SCENE_TEXTURE_H
#define CELLWALK_SCENE_TEXTURE_H

#include "image.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>

enum { TEXTURE_LEVELS = 32 };

/* Rows of a level have one more texel on each side, from the repeated image, so two neighbours always stand
 * side by side. Texel (x, y), for x from -1 to width, is number first + y * stride + x + 1. */
typedef struct texture_level {
    int32_t width, height, stride, first;
} texture_level;

typedef struct texture {
    int count;
    texture_level levels[TEXTURE_LEVELS];
    uint16_t *texels;     /* four halves each, the last of them 0 */
    atomic_bool whole;    /* the smaller levels have been built */
    pthread_mutex_t lock; /* of their building */
    /* Builds them; a pointer, so that a tile's code needs only its arguments (render/wave_tile.c). */
    void (*build)(struct texture *t);
} texture;

/* Without an image yet; NULL when out of memory. */
texture *texture_new(void);
/* Takes over an image that was read, once. False if it is too large; the image is then still the caller's. */
bool texture_fill(texture *t, io_image *image);
/* To be called, by any thread, before a smaller level is read: builds them, as not every picture needs them. */
static inline void texture_need_levels(texture *t) {
    if (!atomic_load_explicit(&t->whole, memory_order_acquire)) t->build(t);
}
void texture_free(texture *t);

#endif
