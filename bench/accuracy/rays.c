/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/tradeoff.h"

#include "workload/aimed.h"

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

size_t tradeoff_rays_make(const cw_field *field, const workload_field *samples, int c, uint32_t seed, size_t n,
                          cw_ray *rays) {
    if (tradeoff_class_is_timed(c)) return workload_rays_make(field, (workload_class)c, seed, n, rays);
    if (samples->nx < 4 || samples->ny < 4) return 0;
    aimed_field f = aimed_field_of(samples);
    f.bounded = true; /* or errors would tell how far rays come from, not how they meet the surface */
    random_state r = {(uint64_t)seed << 8 | (unsigned)c};
    for (size_t k = 0; k < n; k++) {
        const aim edge = k % 3 ? AIM_EDGE : AIM_DIAGONAL;
        rays[k] = aimed_ray_make(c == TRADEOFF_EDGES ? edge : AIM_VERTEX, &f, &r).ray;
    }
    return n;
}
