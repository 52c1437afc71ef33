/* SPDX-License-Identifier: Apache-2.0 */
#include "wave.h"

#include <stdlib.h>
#include <string.h>

/* Mirrors behind the first hit that a path may meet. */
enum { BOUNCES = 4 };

wave *wave_create(const scene *s, const scene_tracer *tracer, const scene_render_options *options, unsigned samples) {
    wave *w = calloc(1, sizeof *w);
    if (w == NULL) return NULL;
    w->scene = s;
    w->tracer = tracer;
    w->cancel = options->cancel;
    w->phong = options->phong;
    w->samples = samples;
    w->camera = camera_of(s, samples);
    for (int k = 0; s->textured && k < 2; k++) {
        w->spreads[k] = malloc(SCENE_BATCH * sizeof *w->spreads[k]);
        if (w->spreads[k] != NULL) continue;
        wave_free(w);
        return NULL;
    }
    return w;
}

void wave_free(wave *w) {
    if (w == NULL) return;
    free(w->spreads[0]);
    free(w->spreads[1]);
    free(w);
}

static bool cancelled(const wave *w) {
    return w->cancel != NULL && atomic_load_explicit(w->cancel, memory_order_relaxed);
}

/* Takes the paths of the first wave through all their bounces. */
static void run_waves(wave *w) {
    w->stats.camera_rays += w->count[0];
    int current = 0;
    for (int bounce = 0; w->count[current] > 0; bounce++) {
        wave_trace_paths(w, current);
        wave_shade(w, current, bounce, bounce == BOUNCES);
        wave_trace_shadows(w);
        current = 1 - current;
    }
    w->count[0] = 0;
}

/* Appends one sample of each pixel of the block at (tx, ty) of the tile, as far as they are in the picture, of which the
 * tile has width x height pixels. */
static void add_block(wave *w, const camera_block *block, unsigned sample, size_t tx, size_t ty, size_t width,
                      size_t height) {
    float dir[3][CAMERA_BLOCK];
    camera_directions(&w->camera, block, sample, dir);
    const transform *eye = &w->scene->camera_to_world;
    for (size_t k = 0; k < CAMERA_BLOCK; k++) {
        const size_t x = tx + k % CAMERA_SIDE, y = ty + k / CAMERA_SIDE;
        if (x >= width || y >= height) continue;
        w->paths[0][w->count[0]] = (wave_path){.throughput = {1, 1, 1}, .pixel = (uint32_t)(y * WAVE_TILE + x)};
        w->rays[0][w->count[0]++] = (cw_user_ray){.org = {eye->m[0][3], eye->m[1][3], eye->m[2][3]},
                                                  .tmin = 0,
                                                  .dir = {(double)dir[0][k], (double)dir[1][k], (double)dir[2][k]},
                                                  .tmax = INFINITY};
    }
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

bool wave_render_tile(wave *w, size_t x, size_t y, io_image *image) {
    const size_t width = least(WAVE_TILE, image->width - x), height = least(WAVE_TILE, image->height - y);
    memset(w->sum, 0, sizeof w->sum);
    w->count[0] = w->count[1] = w->shadow_count = 0;
    /* Block by block, sample by sample, pixel by pixel: sixteen rays in a row look almost the same way. */
    for (size_t ty = 0; ty < height; ty += CAMERA_SIDE)
        for (size_t tx = 0; tx < width; tx += CAMERA_SIDE) {
            const camera_block block = camera_block_at(&w->camera, x + tx, y + ty);
            for (unsigned sample = 0; sample < w->samples; sample++) {
                if (w->count[0] + CAMERA_BLOCK > SCENE_BATCH) {
                    if (cancelled(w)) return false;
                    run_waves(w);
                }
                add_block(w, &block, sample, tx, ty, width, height);
            }
        }
    if (cancelled(w)) return false;
    run_waves(w);
    for (size_t ty = 0; ty < height; ty++)
        for (size_t tx = 0; tx < width; tx++)
            for (size_t c = 0; c < 3; c++) {
                const double light = w->sum[ty * WAVE_TILE + tx][c] / w->samples;
                image->rgb[((y + ty) * image->width + x + tx) * 3 + c] = light > 0 ? (float)light : 0;
            }
    return true;
}
