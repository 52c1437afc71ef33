/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels: W rays in the flat walk until the last one has ended. The build compiles this once
 * for each row of its table. Paper, invariant and a rejected variant are in flat_walk.h. Rejected too: vectors
 * of two registers, from which this walk gains nothing. */

#include "flat_walk.h"
#include "kernels.h"
#include "short_way.h"

#include <math.h>
#include <string.h>

/* True if some ray is long by the guess of short_way.h. guessed: rays that are short by their slab alone. As the slab can be wrong, they
 * get a nearer end; one that finds nothing before it has no answer yet. */
CW_INLINE bool some_are_long(packet *l, const cw_field *f, const cw_ray *rays, vmask *guessed) {
    const vfloat speed = vf_add(vf_abs(l->r.x.dir), vf_abs(l->r.y.dir));
    *guessed = vm_and(l->alive, vf_gt(vf_mul(vf_sub(l->r.until, l->r.from), speed), vf_set(SHORT_CELLS)));
    if (!vm_any(*guessed)) return false;
    for (unsigned left = vm_bits(*guessed); left != 0; left &= left - 1) {
        const cw_ray *r = &rays[__builtin_ctz(left)];
        if (!short_over_slab(f, r, short_speed(r))) return true;
    }
    const vfloat until = vf_min(vf_add(l->r.from, vf_div(vf_set(SHORT_TURNS), speed)), l->r.until);
    l->r.until = vf_select(*guessed, until, l->r.until);
    return false;
}

/* Walks the first n of W rays to their ends. start: see make_rays. if_short: returns false, with answers missing, if
 * one is not short. */
CW_INLINE bool packet_walk(packet *l, const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any,
                           bool if_short, vstart *start) {
    vmask guessed = vm_set(false);
    l->alive = vm_and(vm_first(n), make_rays(&l->r, f, rays, leaf, start));
    if (if_short && some_are_long(l, f, rays, &guessed)) return false;
    const vfloat zero = vf_set(0);
    l->found = vm_set(false);
    /* As it stays in registers, clearing costs nothing, and a branch at the first hit would. */
    l->hit = (found_hits){{zero, zero, l->found}, zero, zero, zero, zero, zero};
    flat_start(l, f);
    while (vm_any(l->alive)) /* at most nx + ny turns: a lane goes one way on each axis and leaves the field */
        flat_step(l, f, leaf, any, true);
    return !if_short || !vm_any(vm_andnot(guessed, l->found));
}

/* Closest hits, or any hits; the other array is NULL. Returns what packet_walk does. */
CW_INLINE bool packet_rays(const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any, bool if_short,
                           cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k += W) {
        const size_t count = n - k < W ? n - k : W;
        cw_ray tail[W];
        cw_hit answers[W];
        packet l;
        vstart start;
        if (!packet_walk(&l, f, fill_up(rays + k, count, W, tail), count, leaf, any, if_short, &start)) return false;
        if (any) {
            const unsigned found = vm_bits(l.found);
            for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        } else {
            packet_hits(&l, &start, count < W ? answers : hits + k);
            if (count < W) memcpy(hits + k, answers, count * sizeof *hits);
        }
    }
    return true;
}

/* One function for each leaf test. Rejected: one for both with a branch at its top, as compilers then run out of
 * registers; a second copy for short rays, which was slower (papers/walks.md). */
static void CW_CODE(packet_mt_)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    packet_rays(f, rays, n, CW_LEAF_MOLLER_TRUMBORE, hits == NULL, false, hits, occluded);
}
CW_ONE_COPY static bool packet_wt(const cw_field *f, const cw_ray *rays, size_t n, bool if_short, cw_hit *hits,
                                  uint8_t *occluded) {
    return packet_rays(f, rays, n, CW_LEAF_WATERTIGHT, hits == NULL, if_short, hits, occluded);
}
static void CW_CODE(packet_wt_)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    packet_wt(f, rays, n, false, hits, occluded);
}

/* cw_short4, cw_short8 or cw_short16. */
bool CW_CODE(short)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    return packet_wt(f, rays, n, true, hits, occluded);
}

/* cw_packet4, cw_packet8 or cw_packet16. */
const cw_kernel_code CW_CODE(packet) = {
    .trace = {[CW_LEAF_MOLLER_TRUMBORE] = CW_CODE(packet_mt_), [CW_LEAF_WATERTIGHT] = CW_CODE(packet_wt_)},
};
