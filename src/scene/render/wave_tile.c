/* SPDX-License-Identifier: Apache-2.0 */
/* A tile of the picture, from its camera rays to its pixels. Compiled once for each instruction set, as CELLWALK_TILE
 * (CMakeLists.txt): the loops become vectors of other widths, the bits stay the same. */

#include "air.inc.h"
#include "camera.inc.h"
#include "shade.inc.h"
#include "trace.inc.h"

#include <string.h>

/* Mirrors behind the first hit that a path may meet. */
enum { BOUNCES = 4 };

/* Takes the paths of the first wave through all their bounces. */
static void run_waves(wave *w) {
    const bool has_water = w->plan->scene->water != NULL;
    const sky *from = w->plan->scene->sky;
    w->stats.camera_rays += w->rays[0].count;
    int current = 0;
    for (int bounce = 0; w->rays[current].count > 0; bounce++) {
        const wave_rays *r = &w->rays[current];
        trace_paths(w, r);
        if (bounce == 0 && has_water) meet_water(w);
        if (bounce == 0 && from != NULL) add_sky(w, r, from->up, from->sun);
        if (bounce > 0 && has_water) add_sky(w, r, w->plan->up, w->plan->sun);
        shade(w, r, bounce == BOUNCES, &w->rays[1 - current]);
        if (bounce == 0 && has_water) shade_water(w, &w->rays[1 - current]);
        for (size_t l = 0; l < w->plan->light_count; l++) trace_shadows(w, l);
        current = 1 - current;
    }
}

static void put_pixels(wave *w, size_t x, size_t y, const scene_crop *region, io_image *image) {
    const double share = 1 / (double)w->plan->samples;
    const size_t x0 = x > region->x0 ? x : region->x0, x1 = x + WAVE_TILE < region->x1 ? x + WAVE_TILE : region->x1;
    const size_t y0 = y > region->y0 ? y : region->y0, y1 = y + WAVE_TILE < region->y1 ? y + WAVE_TILE : region->y1;
    float mean[3][WAVE_TILE * WAVE_TILE];
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < WAVE_TILE * WAVE_TILE; k++) {
            const float light = (float)(w->sum[c][k] * share);
            mean[c][k] = light > 0 ? light : 0;
        }
    for (size_t py = y0; py < y1; py++) {
        float *rgb = &image->rgb[((py - region->y0) * image->width + x0 - region->x0) * 3];
        for (size_t px = x0; px < x1; px++, rgb += 3) {
            const uint32_t pixel = wave_pixel((uint32_t)(px - x), (uint32_t)(py - y));
            for (int c = 0; c < 3; c++) rgb[c] = mean[c][pixel];
        }
    }
}

wave_tile_fn CELLWALK_TILE;
void CELLWALK_TILE(wave *w, size_t x, size_t y, const scene_crop *region, io_image *image) {
    memset(w->sum, 0, sizeof w->sum);
    /* A tile's samples are divided into the same waves for any region, so that a pixel's sum is made in the same
     * order. */
    for (uint32_t first = 0; first < w->plan->samples; first += WAVE_SAMPLES) {
        const uint32_t left = w->plan->samples - first;
        camera_rays(w, x, y, region, first, left < WAVE_SAMPLES ? left : WAVE_SAMPLES);
        run_waves(w);
    }
    put_pixels(w, x, y, region, image);
}
