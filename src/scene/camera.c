/* SPDX-License-Identifier: Apache-2.0 */
#include "camera.h"

#include "float3.h"
#include "pattern.h"

camera camera_of(const scene *s, unsigned samples) {
    camera c = {.sample_distance = 1 / sqrtf((float)samples)};
    const double width = (double)s->width, height = (double)s->height;
    const double reach = tan(s->field_of_view * (acos(-1) / 360)) / fmin(width, height);
    const transform *world = &s->camera_to_world;
    transform_vector(world, (double[3]){-width * reach, height * reach, 1}, c.corner);
    transform_vector(world, (double[3]){2 * reach, 0, 0}, c.along[0]);
    transform_vector(world, (double[3]){0, -2 * reach, 0}, c.along[1]);
    for (int k = 0; k < 2; k++) float3_from(c.along[k], c.across[k]);
    /* Square to the picture's plane. */
    double square[3];
    cross(c.along[0], c.along[1], square);
    const double scale = dot(square, c.corner);
    for (int k = 0; k < 3; k++) c.depth[k] = (float)(square[k] / scale);
    return c;
}

camera_block camera_block_at(const camera *c, size_t x, size_t y) {
    camera_block block;
    for (int k = 0; k < 3; k++)
        block.corner[k] = (float)(c->corner[k] + (double)x * c->along[0][k] + (double)y * c->along[1][k]);
    for (uint32_t k = 0; k < CAMERA_BLOCK; k++) {
        uint32_t seed[2];
        pattern_seeds((uint32_t)x + k % CAMERA_SIDE, (uint32_t)y + k / CAMERA_SIDE, seed);
        block.seed[0][k] = seed[0];
        block.seed[1][k] = seed[1];
    }
    return block;
}

void camera_directions(const camera *c, const camera_block *block, unsigned sample, float dir[3][CAMERA_BLOCK]) {
    const uint32_t first = pattern_first(sample), second = pattern_second(sample);
    const float *right = c->across[0], *down = c->across[1];
    float x[CAMERA_BLOCK], y[CAMERA_BLOCK];
    for (int k = 0; k < CAMERA_BLOCK; k++) {
        x[k] = (float)(k % CAMERA_SIDE) + pattern_place(first, block->seed[0][k]);
        y[k] = (float)(k / CAMERA_SIDE) + pattern_place(second, block->seed[1][k]);
    }
    for (int k = 0; k < CAMERA_BLOCK; k++) {
        const float v[3] = {block->corner[0] + x[k] * right[0] + y[k] * down[0],
                            block->corner[1] + x[k] * right[1] + y[k] * down[1],
                            block->corner[2] + x[k] * right[2] + y[k] * down[2]};
        const float scale = 1 / sqrtf(float3_dot(v, v));
        dir[0][k] = v[0] * scale;
        dir[1][k] = v[1] * scale;
        dir[2][k] = v[2] * scale;
    }
}

/* The derivative of the unit vector over a pixel, shortened to the mean distance between samples. */
void camera_spread(const camera *c, const float dir[3], ray_spread *spread) {
    const float scale = float3_dot(c->depth, dir) * c->sample_distance;
    for (int k = 0; k < 2; k++) {
        const float *along = c->across[k];
        const float forward = float3_dot(along, dir);
        for (int i = 0; i < 3; i++) {
            spread->org[k][i] = 0;
            spread->dir[k][i] = (along[i] - forward * dir[i]) * scale;
        }
    }
}
