/* SPDX-License-Identifier: Apache-2.0 */
/* Images on surfaces, filtered over the part of them that a pixel covers. */
#ifndef CELLWALK_SCENE_TEXTURE_H
#define CELLWALK_SCENE_TEXTURE_H

#include "image.h"

typedef struct texture texture;

/* Takes over the image's pixels and builds the smaller levels. NULL when out of memory; the image is then still the
 * caller's. */
texture *texture_create(io_image *image);
void texture_free(texture *t);

/* Mean colour around (u, v), repeated beyond [0, 1), row 0 at v = 0, over the parallelogram between this sample and the
 * next ones: the changes of (u, v) along the picture's x and y. */
void texture_lookup(const texture *t, const float uv[2], const float along_x[2], const float along_y[2],
                    float colour[3]);

#endif
