/* SPDX-License-Identifier: Apache-2.0 */
/* The example of papers/using.md for near and far cells in one view. */
#include <cellwalk.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 1025, LEVELS = 4, VIEW = 100 };
static float heights[SIDE * SIDE];
static cw_field *level[LEVELS];
static int borders;

/* How far a place of a ray lies above a level: NAN where that has no surface. */
static double above(const cw_field *field, const cw_user_ray *ray, double t, cw_hit *hit) {
    double p[3], ground[3];
    for (int c = 0; c < 3; c++) p[c] = ray->org[c] + t * ray->dir[c];
    cw_field_at_user(field, p[0], p[1], hit);
    cw_hit_points(field, NULL, hit, 1, ground);
    return p[2] - ground[2];
}

/* The level that the ray hits, or -1; pixel: the width of a pixel at t = 1, times the pixels that a cell may cover. */
static int closest(cw_user_ray ray, double pixel, cw_hit *hit) {
    for (int k = 0; k < LEVELS; k++) {
        ray.tmax = k + 1 < LEVELS ? (2 << k) / pixel : INFINITY;
        if (cw_closest_user(level[k], NULL, &ray, 1, hit) == CW_OK && hit->i >= 0) return k;
        if (k + 1 == LEVELS) break;
        ray.tmin = ray.tmax; /* the border: here the next level takes over */
        cw_hit there;
        const double near = above(level[k], &ray, ray.tmax, &there), far = above(level[k + 1], &ray, ray.tmax, hit);
        if (near * far <= 0) { /* between the two surfaces: the ray would slip through */
            hit->t = (float)ray.tmax;
            borders++;
            return k + 1;
        }
    }
    return -1;
}

int main(void) {
    for (int k = 0; k < SIDE * SIDE; k++) heights[k] = (float)(abs(k % SIDE % 20 - 10) * abs(k / SIDE % 30 - 15) / 5);
    const cw_field_desc desc = {.samples = heights, .nx = SIDE, .ny = SIDE};
    int hits[LEVELS] = {0};
    if (cw_field_create(&desc, NULL, &level[0]) != CW_OK) return 1;
    for (int k = 1; k < LEVELS; k++)
        if (cw_field_coarser(level[0], NULL, (size_t)1 << k, CW_FILTER_MEAN, &level[k], NULL) != CW_OK) return 1;
    for (int k = 0; k < VIEW * VIEW; k++) {
        const cw_user_ray ray = {.org = {512, 2, 50},
                                 .dir = {(double)(k % VIEW) / VIEW - 0.5, 1, -0.02 - 0.3 * (k / VIEW) / VIEW}};
        cw_hit hit;
        const int on = closest(ray, 0.01, &hit); /* a cell may cover one pixel */
        if (on >= 0) hits[on]++;
    }
    printf("%d, %d, %d and %d hits, of these %d at borders\n", hits[0], hits[1], hits[2], hits[3], borders);
    for (int k = 0; k < LEVELS; k++) cw_field_destroy(level[k]);
    return 0;
}
