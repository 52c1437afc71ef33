/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_SCENE_CAMERA_INC_H
#define CELLWALK_SCENE_CAMERA_INC_H

#include "lanes.h"
#include "pattern.h"
#include "wave.h"

#include <string.h>

/* Camera rays of a tile: block by block, sample by sample, pixel by pixel, so that sixteen in a row look almost the
 * same way. (Four samples of 2 x 2 pixels lie closer yet. With them landsea-big renders in 0.90 of the time and texture
 * in 0.98, but landsea-0 in 1.04 and landsea-2 in 1.06, as the rays take longer to make.) */

/* Directions through one sample of each pixel of the block whose corner is (x, y) at depth 1, from place on. */
static void block_directions(wave *w, float x, float y, uint32_t sample, uint32_t seed[2][WAVE_LANES], size_t place) {
    const float pixel = (float)w->plan->pixel;
    const uint32_t second = pattern_second(sample);
    float g[6];
    memcpy(g, w->plan->camera_metric.g, sizeof g);
    float *dx = &w->rays[0].dir[0][place], *dy = &w->rays[0].dir[1][place], *dz = &w->rays[0].dir[2][place];
    float across[WAVE_LANES], down[WAVE_LANES], scale[WAVE_LANES];
    for (int k = 0; k < WAVE_LANES; k++) {
        across[k] = x + ((float)(k % WAVE_BLOCK) + pattern_place(sample, seed[0][k])) * pixel;
        down[k] = y - ((float)(k / WAVE_BLOCK) + pattern_place(second, seed[1][k])) * pixel;
        scale[k] = 1 / sqrtf(lane_square(g, across[k], down[k], 1));
    }
    for (int k = 0; k < WAVE_LANES; k++) {
        dx[k] = across[k] * scale[k];
        dy[k] = down[k] * scale[k];
        dz[k] = scale[k];
    }
}

/* Keeps those of the last WAVE_LANES rays that lie in the region. */
static void keep_in_region(wave_rays *r, size_t x, size_t y, const scene_crop *region) {
    size_t kept = r->count;
    for (size_t k = 0; k < WAVE_LANES; k++) {
        const size_t px = x + k % WAVE_BLOCK, py = y + k / WAVE_BLOCK, from = r->count + k;
        if (px < region->x0 || px >= region->x1 || py < region->y0 || py >= region->y1) continue;
        for (int c = 0; c < 3; c++) r->dir[c][kept] = r->dir[c][from];
        r->pixel[kept++] = r->pixel[from];
    }
    r->count = kept;
}

/* Makes the first wave of those samples, from first on, of the tile at (x, y). */
static void camera_rays(wave *w, size_t x, size_t y, const scene_crop *region, uint32_t first, uint32_t samples) {
    const plan *p = w->plan;
    wave_rays *r = &w->rays[0];
    r->count = 0;
    for (size_t ty = 0; ty < WAVE_TILE; ty += WAVE_BLOCK)
        for (size_t tx = 0; tx < WAVE_TILE; tx += WAVE_BLOCK) {
            const size_t bx = x + tx, by = y + ty;
            if (bx >= region->x1 || by >= region->y1 || bx + WAVE_BLOCK <= region->x0 || by + WAVE_BLOCK <= region->y0)
                continue;
            const bool whole =
                bx >= region->x0 && by >= region->y0 && bx + WAVE_BLOCK <= region->x1 && by + WAVE_BLOCK <= region->y1;
            uint32_t seed[2][WAVE_LANES];
            for (uint32_t k = 0; k < WAVE_LANES; k++) {
                seed[0][k] = pattern_seed((uint32_t)bx + k % WAVE_BLOCK, (uint32_t)by + k / WAVE_BLOCK, p->seed);
                seed[1][k] = pattern_hash(seed[0][k]);
            }
            for (uint32_t sample = first; sample < first + samples; sample++) {
                block_directions(w, (float)(p->corner[0] + (double)bx * p->pixel),
                                 (float)(p->corner[1] - (double)by * p->pixel), sample, seed, r->count);
                for (uint32_t k = 0; k < WAVE_LANES; k++)
                    r->pixel[r->count + k] = wave_pixel((uint32_t)tx, (uint32_t)ty) + k;
                if (whole)
                    r->count += WAVE_LANES;
                else
                    keep_in_region(r, bx, by, region);
            }
        }
    r->segments[0] = (wave_segment){PLAN_CAMERA, 0, r->count};
    r->segment_count = 1;
}

#endif
