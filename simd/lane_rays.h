/* SPDX-License-Identifier: Apache-2.0 */
/* Rays made ready for the lane walk (lane_walk.h): mirrored, and with the node in which each begins.
 *
 * Mirroring turns the axes along which a ray goes down, so that all lanes go up: x becomes -x, which no float
 * operation rounds differently. A node is named by its low corner in mirrored coordinates, corner. Its exit borders
 * are corner + side, and its number along the axis is (corner XOR turned) >> 2 level, with turned = -1 for a
 * mirrored axis, else 0. */
#ifndef CELLWALK_SIMD_LANE_RAYS_H
#define CELLWALK_SIMD_LANE_RAYS_H

#include "lane_queue.h"
#include "pyramid.h"
#include "vector_cells.h"

#include <float.h>
#include <math.h>

/* One axis of W rays. */
static inline void mirror_axis(float f[RAY_AXIS][W], int32_t turned[W], const vaxis *a, size_t samples) {
    const vfloat zero = vf_set(0), end = vf_set((float)(samples - 1));
    const vfloat sign = vf_select(a->up, zero, vf_set(-0.0f)), org = vf_flip(a->org, sign);
    vf_store(f[RAY_ORG], org);
    vf_store(f[RAY_EARLY], vf_sub(org, vf_mul(vf_set(0x1p-21f), vf_add(vf_abs(org), vf_set((float)samples)))));
    vf_store(f[RAY_DIR], vf_flip(a->dir, sign));
    vf_store(f[RAY_CENTER], vf_flip(a->center, sign));
    vf_store(f[RAY_INVERSE], vf_flip(a->inverse, sign));
    vf_store(f[RAY_FIRST], vf_select(a->up, zero, vf_sub(zero, end)));
    vf_store(f[RAY_LAST], vf_select(a->up, end, zero));
    vf_store(f[RAY_SIGN], sign);
    vi_store(turned, vi_select(a->up, vi_set(0), vi_set(-1)));
}

/* Makes W rays ready for walks: those of packet p of the present tile, number first_packet + p of the queue. Called
 * only for rays that go on alone, which saves more instructions for coherent rays than it costs for the others. */
CW_INLINE void mirror_packet(lane_queue *q, size_t first_packet, size_t p, const vray *r, const cw_field *f) {
    if (q->mirrored >> p & 1) return;
    q->mirrored |= (uint64_t)1 << p;
    ready_rays *s = &q->ready[first_packet + p];
    mirror_axis(s->f, s->i[RAY_TURNED_X], &r->x, f->nx);
    mirror_axis(s->f + RAY_AXIS, s->i[RAY_TURNED_Y], &r->y, f->ny);
    /* Slabs have room for the rounding of rays that begin within the field, and of the watertight test
     * (papers/numerics.md). For the rest each ray has a pad: 64 u of the heights, and 32 u of the steepest slope
     * times the distance of its origin beyond the field's size. */
    const vfloat size = vf_set((float)(f->nx + f->ny)), origin = vf_add(vf_abs(r->x.org), vf_abs(r->y.org));
    const vfloat excess = vf_max(vf_set(0), vf_sub(origin, size));
    const vfloat tallest = vf_set(fmaxf(fabsf(f->low), fabsf(f->high))), steepest = vf_set(f->pyramid->steepest);
    const vfloat heights = vf_add(vf_mul(vf_set(2), vf_add(vf_abs(r->oz), tallest)), vf_mul(steepest, excess));
    const vfloat lengths = vf_add(vf_add(origin, size), vf_add(vf_abs(r->x.dir), vf_abs(r->y.dir)));
    const vfloat largest = vf_add(vf_add(heights, vf_abs(r->dz)), vf_mul(steepest, lengths));
    /* Denormal products, and denormal t. In so small a t the height of the ray or of the slope changes by less than
     * largest times it. */
    const vfloat longest = vf_max(vf_abs(r->from), vf_abs(r->until));
    const vfloat least = vf_add(vf_add(vf_set(1), longest), vf_mul(vf_set(0x1p-14f), largest));
    const vfloat pad = vf_add(vf_mul(vf_set(SLAB_ROUNDING), heights), vf_mul(vf_set(FLT_MIN), least));
    /* If a height above a slab or its rate might overflow, the pad is infinite and no slab is used. The walk's own sums
     * stay below 8 largest each. */
    vf_store(s->f[RAY_OZ], r->oz);
    vf_store(s->f[RAY_DZ], r->dz);
    vf_store(s->f[RAY_PAD], vf_select(vf_le(largest, vf_set(0x1p120f)), pad, vf_set(INFINITY)));
    vf_store(s->f[RAY_UNTIL], r->until);
    vf_store(s->f[RAY_T0], r->t0);
    vf_store(s->f[RAY_T1], r->t1);
}

/* Low corner, mirrored, of the node of the given side that the rays are in at t, or of an earlier one. */
static inline vint first_corner(float f[RAY_AXIS][W], vfloat t, vfloat side) {
    const vfloat last = vf_sub(vf_load(f[RAY_LAST]), vf_set(0.5f));
    vfloat place = vf_add(vf_load(f[RAY_EARLY]), vf_mul(t, vf_load(f[RAY_DIR])));
    place = vf_max(vf_min(place, last), vf_load(f[RAY_FIRST])); /* in this order NaN would become last */
    return vi_from_vf(vf_mul(vf_floor(vf_div(place, side)), side));
}

/* Queues a packet's rays in the lanes of which, made ready before. Each begins at t in a node of the level. */
static inline void enqueue(lane_queue *q, size_t packet_number, unsigned which, vfloat t, int level) {
    float from[W];
    int32_t x[W], y[W];
    ready_rays *s = &q->ready[packet_number];
    const vfloat side = vf_power_of_2(vi_set(2 * level));
    vf_store(from, t);
    vi_store(x, first_corner(s->f, t, side));
    vi_store(y, first_corner(s->f + RAY_AXIS, t, side));
    for (; which != 0; which &= which - 1) {
        const unsigned k = (unsigned)__builtin_ctz(which);
        q->rays[q->n++] = (queued){
            (uint16_t)packet_number, (uint16_t)k, (uint32_t)(packet_number * W) + k, from[k], x[k], y[k], level};
    }
}

#endif
