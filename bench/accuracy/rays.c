/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/rays.h"

#include "workload/terrain.h"

#include <math.h>

const char *tradeoff_class_name(int c) {
    if (c == TRADEOFF_VERTICES) return "vertices";
    if (c == TRADEOFF_EDGES) return "edges";
    return c >= 0 && c < WORKLOAD_CLASS_COUNT ? workload_class_name((workload_class)c) : NULL;
}

bool tradeoff_class_is_timed(int c) { return c < WORKLOAD_CLASS_COUNT; }
bool tradeoff_class_is_any(int c) { return tradeoff_class_is_timed(c) && workload_class_is_any((workload_class)c); }
bool tradeoff_class_is_coherent(int c) {
    return tradeoff_class_is_timed(c) && workload_class_is_coherent((workload_class)c);
}

/* In (0, 1), never an end. */
static double uniform(uint32_t seed, size_t ray, uint32_t stream) {
    return ((double)terrain_hash(seed, (uint32_t)ray, stream) + 0.5) * 0x1p-32;
}

static cw_ray aimed_ray(const cw_field *field, const cw_field_info *info, bool edge, uint32_t seed, size_t k) {
    enum { STREAM = 500 };
    const size_t i = 1 + (size_t)(uniform(seed, k, STREAM) * (double)(info->nx - 3));
    const size_t j = 1 + (size_t)(uniform(seed, k, STREAM + 1) * (double)(info->ny - 3));
    /* From sample (i, j), or on the way from there to (i + 1, j), (i, j + 1) or (i + 1, j + 1). */
    const double along = edge ? uniform(seed, k, STREAM + 2) : 0;
    const uint32_t which = terrain_hash(seed, (uint32_t)k, STREAM + 3) % 3;
    const size_t di = which != 1, dj = which != 0;
    const double from = (double)cw_field_sample(field, i, j), to = (double)cw_field_sample(field, i + di, j + dj);
    const double target[3] = {(double)i + along * (double)di, (double)j + along * (double)dj,
                              from + along * (to - from)};
    const double low = (double)info->low, high = (double)info->high, margin = 0.01 * (high - low) + 1;
    const double rise = high + margin - target[2], fall = target[2] - (low - margin);
    /* Any direction of the compass, as steep as keeps both ends within the field, and often much steeper. */
    double compass[2], square;
    uint32_t stream = STREAM + 4;
    do { /* fails once in five times */
        for (int a = 0; a < 2; a++) compass[a] = uniform(seed, k, stream++) * 2 - 1;
        square = compass[0] * compass[0] + compass[1] * compass[1];
    } while (square > 1 || square < 0.01);
    const double end[2] = {(double)(info->nx - 1), (double)(info->ny - 1)};
    double most = 4; /* cells for each of height */
    for (int a = 0; a < 2; a++) {
        const double c = compass[a] / sqrt(square), room = c > 0 ? end[a] - target[a] : target[a];
        const double behind = c > 0 ? target[a] : end[a] - target[a];
        most = fmin(most, fmin(room / fall, behind / rise) / fmax(fabs(c), 1e-9));
    }
    const double lean = 0.99 * most * uniform(seed, k, stream);
    cw_ray ray = {.tmin = 0};
    double length = 0;
    double dir[3] = {lean * compass[0] / sqrt(square), lean * compass[1] / sqrt(square), -1};
    for (int a = 0; a < 3; a++) length += dir[a] * dir[a];
    length = sqrt(length);
    for (int a = 0; a < 3; a++) {
        ray.org[a] = (float)(target[a] - rise * dir[a]);
        ray.dir[a] = (float)(dir[a] / length);
    }
    ray.tmax = (float)((rise + fall) * length);
    return ray;
}

size_t tradeoff_rays_make(const cw_field *field, int c, uint32_t seed, size_t n, cw_ray *rays) {
    if (tradeoff_class_is_timed(c)) return workload_rays_make(field, (workload_class)c, seed, n, rays);
    const cw_field_info info = cw_field_describe(field);
    if (info.nx < 4 || info.ny < 4) return 0;
    for (size_t k = 0; k < n; k++) rays[k] = aimed_ray(field, &info, c == TRADEOFF_EDGES, seed, k);
    return n;
}
