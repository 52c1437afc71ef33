/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels: W rays in the flat walk until the last one has ended. The build compiles this once
 * for each row of its table. Paper, invariant and a rejected variant are in flat_walk.h. Rejected too: vectors
 * of two registers, from which this walk gains nothing. */

#include "flat_walk.h"
#include "kernels.h"

#include <math.h>
#include <string.h>

/* Walks the first n of W rays to their ends. start: see make_rays. */
CW_INLINE void packet_walk(packet *l, const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any,
                           vstart *start) {
    l->alive = vm_and(vm_first(n), make_rays(&l->r, f, rays, leaf, start));
    const vfloat zero = vf_set(0);
    l->found = vm_set(false);
    /* As it stays in registers, clearing costs nothing, and a branch at the first hit would. */
    l->hit = (found_hits){{zero, zero, l->found}, zero, zero, zero, zero, zero};
    flat_start(l, f);
    while (vm_any(l->alive)) /* at most nx + ny turns: a lane goes one way on each axis and leaves the field */
        flat_step(l, f, leaf, any, true);
}

/* Closest hits, or any hits; the other array is NULL. */
CW_INLINE void packet_rays(const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any, cw_hit *hits,
                           uint8_t *occluded) {
    for (size_t k = 0; k < n; k += W) {
        const size_t count = n - k < W ? n - k : W;
        cw_ray tail[W];
        cw_hit answers[W];
        packet l;
        vstart start;
        packet_walk(&l, f, fill_up(rays + k, count, W, tail), count, leaf, any, &start);
        if (any) {
            const unsigned found = vm_bits(l.found);
            for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        } else {
            packet_hits(&l, &start, count < W ? answers : hits + k);
            if (count < W) memcpy(hits + k, answers, count * sizeof *hits);
        }
    }
}

/* One function for each leaf test. Rejected: one for both with a branch at its top, as compilers then run out of
 * registers. */
static void CW_CODE(packet_mt_)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    packet_rays(f, rays, n, CW_LEAF_MOLLER_TRUMBORE, hits == NULL, hits, occluded);
}
static void CW_CODE(packet_wt_)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    packet_rays(f, rays, n, CW_LEAF_WATERTIGHT, hits == NULL, hits, occluded);
}

/* cw_packet4, cw_packet8 or cw_packet16. */
const cw_kernel_code CW_CODE(packet) = {
    .trace = {[CW_LEAF_MOLLER_TRUMBORE] = CW_CODE(packet_mt_), [CW_LEAF_WATERTIGHT] = CW_CODE(packet_wt_)},
};
