/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes for tests of rendering, and what is done with all of them. */
#ifndef CELLWALK_TESTS_SCENE_PICTURES_H
#define CELLWALK_TESTS_SCENE_PICTURES_H

#include "scene.h"

/* Loads a scene given as text; anything else fails the test. Texts may name what lies in the working directory. */
scene *pictures_load(const char *text);
io_image pictures_render(const scene *s, const scene_render_options *options, scene_render_stats *stats);
/* Size and every bit. */
bool pictures_same(const io_image *a, const io_image *b);

/* A rough matte field in front of a rippled mirror, under two lights: 70 x 50 pixels, 4 samples each. */
scene *pictures_rough_scene(void);

/* All that a scene can require: matte, textured and mirroring fields of several sizes, a textured cylinder around them and
 * a mirroring one among them, turned and stretched, under three lights of which one is outside. 70 x 50 pixels, 6 samples
 * each. Writes the image into the working directory. */
scene *pictures_full_scene(void);

/* Rough land in the sun, in haze, partly under water, below a sky with a plain. 70 x 50 pixels, 6 samples each. Its field lives until
 * the next such scene is made. */
scene *pictures_landscape(void);

#endif
