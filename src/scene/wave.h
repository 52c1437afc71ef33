/* SPDX-License-Identifier: Apache-2.0 */
/* One thread's rays. They go through the scene in waves of up to SCENE_BATCH: all are traced, then shaded, then all their
 * shadow rays are traced; those that met a mirror are the next wave. So a tracer always has an array of rays to work on,
 * neighbours in the picture being neighbours in the array. */
#ifndef CELLWALK_SCENE_WAVE_H
#define CELLWALK_SCENE_WAVE_H

#include "camera.h"
#include "surface.h"

/* Pixels a side of the tiles that threads take. */
enum { WAVE_TILE = 32 };

/* The shape on which a path's ray ends: height fields come first, then cylinders. */
enum { WAVE_MISS = -1 };

typedef struct wave_path {
    float throughput[3]; /* the share of this ray's light that arrives at the pixel */
    uint32_t pixel;      /* of the tile */
} wave_path;

typedef struct wave_shadow {
    float light[3]; /* what arrives at the pixel unless the light is hidden */
    uint32_t pixel;
} wave_shadow;

typedef struct wave {
    const scene *scene;
    const scene_tracer *tracer;
    const atomic_bool *cancel;
    bool phong;
    unsigned samples;
    camera camera;

    /* Two waves, the one at hand and the next. Of rays, dir has unit length, and tmax is where they end once traced. */
    cw_user_ray rays[2][SCENE_BATCH];
    wave_path paths[2][SCENE_BATCH];
    ray_spread *spreads[2]; /* of mirrored rays; NULL in a scene without textures, else SCENE_BATCH each */
    size_t count[2];
    int32_t shape[SCENE_BATCH];
    cw_hit hits[SCENE_BATCH]; /* where shape is a height field */

    cw_user_ray shadow_rays[SCENE_BATCH];
    wave_shadow shadows[SCENE_BATCH];
    uint8_t hidden[SCENE_BATCH];
    size_t shadow_count;

    /* What the tracer is asked about one field, and its answers about fields after the first. */
    cw_ray field_rays[SCENE_BATCH];
    cw_hit other_hits[SCENE_BATCH];
    uint8_t other_hidden[SCENE_BATCH];

    double sum[WAVE_TILE * WAVE_TILE][3]; /* over the samples of each pixel */
    scene_render_stats stats;
} wave;

wave *wave_create(const scene *s, const scene_tracer *tracer, const scene_render_options *options, unsigned samples);
void wave_free(wave *w);

/* Renders the tile whose upper left pixel is (x, y) into image. False when cancelled. */
bool wave_render_tile(wave *w, size_t x, size_t y, io_image *image);

/* Finds where each path of this wave ends. */
void wave_trace_paths(wave *w, int current);

/* Traces the shadow rays that have come together and adds the light that gets through. */
void wave_trace_shadows(wave *w);

/* Queues the shadow rays of the wave at hand and makes the next one of its mirrored rays. No mirror counts in the last
 * bounce; bounce 0 comes from the camera. */
void wave_shade(wave *w, int current, int bounce, bool last);

#endif
