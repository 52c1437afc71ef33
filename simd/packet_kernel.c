/* SPDX-License-Identifier: Apache-2.0 */
/* The packet kernels: W rays in the flat walk (flat_walk.h) until the last one has ended. Rejected: vectors of two
 * registers, from which this walk gains nothing. */

#include "flat_walk.h"
#include "kernels.h"

#include <string.h>

/* Below SHORT_CELLS cells, a few rays take less time from cell to cell than over the pyramid, where they are queued. */
enum { SHORT_CELLS = 32, SHORT_TURNS = 40 };

/* True if a ray, in its first cell, seems to cross more cells. guessed: rays that seem short only because they soon
 * fall to the height of that cell's first sample. As the ground may fall away, they get a nearer end; finding nothing
 * before it is no answer yet. Rejected: the slab of 16 × 16 cells below, more often right but one more cache miss. */
CW_INLINE bool some_are_long(packet *l, const cw_field *f, vmask *guessed) {
    vray *r = &l->r;
    const vfloat speed = vf_add(vf_abs(r->x.dir), vf_abs(r->y.dir)), most = vf_set(SHORT_CELLS);
    *guessed = vm_and(l->alive, vf_gt(vf_mul(vf_sub(r->until, r->from), speed), most));
    if (!vm_any(*guessed)) return false;
    const vfloat height = vf_sub(vf_mul(r->from, r->dz), above_origin(r, vf_gather(f->z, l->sample, l->alive)));
    const vfloat zero = vf_set(0);
    const vmask falls = vm_and(vf_ge(height, zero), vf_le(vf_mul(height, speed), vf_mul(most, vf_sub(zero, r->dz))));
    if (vm_any(vm_andnot(*guessed, falls))) return true;
    const vfloat until = vf_min(vf_add(r->from, vf_div(vf_set(SHORT_TURNS), speed)), r->until);
    r->until = vf_select(*guessed, until, r->until);
    return false;
}

/* Walks the first n of W rays to their ends. start: see make_rays. if_short: returns false, with answers missing, if
 * one is not short. */
CW_INLINE bool packet_walk(packet *l, const cw_field *f, const cw_ray *rays, size_t n, cw_leaf leaf, bool any,
                           bool if_short, vstart *start) {
    vmask guessed = vm_set(false);
    l->alive = vm_and(vm_first(n), make_rays(&l->r, f, rays, leaf, true, start));
    const vfloat zero = vf_set(0);
    l->found = vm_set(false);
    /* As it stays in registers, clearing costs nothing, and a branch at the first hit would. */
    l->hit = (found_hits){{zero, zero, l->found}, zero, zero, zero, zero, zero};
    flat_start(l, f);
    if (if_short && some_are_long(l, f, &guessed)) return false;
    while (vm_any(l->alive)) { /* at most nx + ny turns: a lane goes one way on each axis and leaves the field */
        const vmask candidates = flat_gate(l, f);
        if (vm_any(candidates)) flat_leaf(l, candidates, leaf, any, true);
        flat_next(l, f);
    }
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
 * registers; a second copy for short rays, which was slower. */
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

#if W < 16 /* see FEW_16 in kernels.c */
bool CW_CODE(short)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    return packet_wt(f, rays, n, true, hits, occluded);
}
#endif

const cw_kernel_code CW_CODE(packet) = {
    .trace = {[CW_LEAF_MOLLER_TRUMBORE] = CW_CODE(packet_mt_), [CW_LEAF_WATERTIGHT] = CW_CODE(packet_wt_)},
};
