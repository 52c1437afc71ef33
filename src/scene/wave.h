/* SPDX-License-Identifier: Apache-2.0 */
/* One thread's rays. They go through the scene in waves of up to SCENE_BATCH: all are traced, then shaded, then all their
 * shadow rays are traced; those that met a mirror are the next wave. So a tracer always has an array of rays to work on,
 * neighbours in the picture being neighbours in the array. */
#ifndef CELLWALK_SCENE_WAVE_H
#define CELLWALK_SCENE_WAVE_H

#include "surface.h"

/* Pixels a side of the tiles that threads take. */
enum { WAVE_TILE = 32 };

typedef struct wave_path {
    double org[3], dir[3]; /* dir has unit length */
    double tmin;
    float throughput[3]; /* the share of this ray's light that arrives at the pixel */
    uint32_t pixel;      /* of the tile */
} wave_path;

typedef struct wave_shadow {
    float light[3]; /* what arrives at the pixel unless the light is hidden */
    uint32_t pixel;
} wave_shadow;

/* Where a path's ray ended: a height field, a cylinder or nowhere. */
typedef struct wave_end {
    enum { WAVE_MISS, WAVE_FIELD, WAVE_CYLINDER } shape;
    uint32_t number;
    cw_hit hit; /* on a field */
} wave_end;

typedef struct wave {
    const scene *scene;
    const scene_tracer *tracer;
    const atomic_bool *cancel;
    bool phong;
    unsigned samples;
    double sample_distance; /* in pixels, on average */
    double corner[3], along[2][3];

    wave_path paths[2][SCENE_BATCH];
    ray_spread *spreads[2]; /* NULL in a scene without textures, else SCENE_BATCH each */
    size_t count[2];
    cw_user_ray user[SCENE_BATCH];
    cw_ray rays[SCENE_BATCH];
    cw_hit hits[SCENE_BATCH];
    wave_end ends[SCENE_BATCH];

    cw_user_ray shadow_rays[SCENE_BATCH];
    wave_shadow shadows[SCENE_BATCH];
    uint8_t occluded[SCENE_BATCH], hidden[SCENE_BATCH];
    size_t shadow_count;

    double sum[WAVE_TILE * WAVE_TILE][3]; /* over the samples of each pixel */
    scene_render_stats stats;
} wave;

wave *wave_create(const scene *s, const scene_tracer *tracer, const scene_render_options *options, unsigned samples);
void wave_free(wave *w);

/* Renders the tile whose upper left pixel is (x, y) into image. False when cancelled. */
bool wave_render_tile(wave *w, size_t x, size_t y, io_image *image);

#endif
