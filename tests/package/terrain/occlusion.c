/* SPDX-License-Identifier: Apache-2.0 */
/* An ambient-occlusion bake: 8 bits a texel for a tile of a game's terrain, on a pool, into a texture with a pitch. */
#include <cellwalk_terrain.h>

#include <stdio.h>

enum { SIDE = 129, TILE = 64, PITCH = 80 };

static bool watch(void *context, double done) {
    *(double *)context = done;
    return true; /* false would cancel */
}

int main(void) {
    static float samples[SIDE * SIDE], light[TILE * PITCH];
    static uint8_t texels[TILE * PITCH];
    for (int k = 0; k < SIDE * SIDE; k++) samples[k] = (float)(k % 7 * (k / SIDE % 5)) * 0.25f;
    const cw_field_desc field_desc = {.samples = samples, .nx = SIDE, .ny = SIDE, .storage = CW_BORROW};
    cw_field *field = NULL;
    cw_terrain *terrain = NULL;
    cw_pool *pool = NULL;
    double done = 0;
    cw_status status = cw_field_create(&field_desc, NULL, &field);
    if (status == CW_OK) status = cw_terrain_create(&(cw_terrain_desc){.field = field}, NULL, &terrain);
    if (status == CW_OK) status = cw_pool_create(0, &pool);
    const cw_run run = {.pool = pool, .watch = watch, .watch_context = &done};
    const cw_horizon sky = {.count = 64, .max_distance = 100, .flags = CW_HORIZON_TILTED};
    const cw_area tile = {.at = {64, 64, TILE, TILE}, .stride = PITCH};
    if (status == CW_OK) status = cw_sky_view(terrain, &run, &sky, tile, light);
    if (status != CW_OK) fprintf(stderr, "%s\n", cw_last_error());
    int darkest = 255, brightest = 0;
    for (int k = 0; k < TILE * PITCH; k++) {
        texels[k] = (uint8_t)(255 * light[k] + 0.5f);
        if (k % PITCH >= TILE) continue;
        darkest = texels[k] < darkest ? texels[k] : darkest;
        brightest = texels[k] > brightest ? texels[k] : brightest;
    }
    printf("texels from %d to %d\n", darkest, brightest);
    cw_pool_destroy(pool);
    cw_terrain_destroy(terrain);
    cw_field_destroy(field);
    return status == CW_OK && done == 1 && darkest > 20 && darkest < brightest && light[TILE] == 0 ? 0 : 1;
}
