/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels: W rays in the flat walk until the last one has ended. A stub includes a vocabulary and then this
 * body. */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "lanes.inc.h"

/* Walks the first n of W rays to their ends. */
static inline void packet_walk(lanes *l, const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any) {
    cw_ray tail[W];
    if (n < W) { /* lanes beyond the array get a ray of their own to read */
        for (size_t k = 0; k < W; k++) tail[k] = rays[k < n ? k : 0];
        rays = tail;
    }
    l->alive = vm_and(vm_first(n), make_rays(&l->r, f, rays));
    lanes_clear(l);
    lanes_start(l, f);
    while (vm_any(l->alive)) /* at most nx + ny turns: a lane goes one way on each axis and leaves the field */
        lanes_step(l, f, leaf, any);
}

static inline void packet_closest(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, cw_leaf leaf) {
    for (size_t k = 0; k < n; k += W) {
        const size_t count = n - k < W ? n - k : W;
        lanes l;
        packet_walk(&l, f, rays + k, count, leaf, false);
        const unsigned found = lanes_hits(&l, hits + k);
        for (size_t m = 0; m < count; m++)
            if (!(found >> m & 1)) hits[k + m] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
    }
}

static inline void packet_any(const cw_field *f, const cw_ray *rays, size_t n, uint8_t *occluded, cw_leaf leaf) {
    for (size_t k = 0; k < n; k += W) {
        const size_t count = n - k < W ? n - k : W;
        lanes l;
        packet_walk(&l, f, rays + k, count, leaf, true);
        const unsigned found = vm_bits(l.found);
        for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
    }
}
