/* SPDX-License-Identifier: Apache-2.0 */
/* Climb: ends the walk of a ray that rises out of the terrain. Shadow, ambient-occlusion and bounce rays start at the
 * surface and mostly leave it within a few cells. A ray can only go on into the nodes *ahead*: the one in which it
 * begins, and those next to it in its direction, 2 × 2 in all, whose highest sample is stored (pyramid.h). One
 * comparison a level decides whether the ray is above it when it leaves them, and the levels chain:
 *
 *     reach(k)  t at which the ray leaves its nodes ahead of level k
 *     clear(k)  reach(k) is beyond the walk's end, or the ray's height there is above everything in its nodes ahead of
 *               level k + 1, at the top: above everything
 *     end(k)    t from which the ray is in its nodes ahead of level k or beyond them, and above everything in them;
 *               at most reach(k)
 *
 * If clear holds at all levels k, k + 1, …, nothing lies beyond end(k), and the lowest such k gives the best end.
 *
 * Invariant: in a cell that the ray leaves after end, the gate's own monotone height function is above every sample
 * from end on. So a cell that is entered later fails the gate, and no hit changes. A cell that is entered before end
 * has no hit after it: the watertight test keeps the surface between the samples. All borders are compared by the
 * gate's own crossings, which are monotone. So it does not matter into which node rounding puts the ray's beginning
 * (papers/numerics.md).
 *
 * No paper is known to us. Rejected: the global maximum, which is too loose a bound; a walk down the pyramid, which
 * takes longer than the comparisons; and the nodes on all sides, 3 × 3, which need no crossing behind the ray but are
 * higher (papers/walks.md). */
#ifndef CELLWALK_SIMD_CLIMB_H
#define CELLWALK_SIMD_CLIMB_H

#include "fat_ray.h"
#include "flat_walk.h"
#include "pyramid.h"

/* A packet on its way down the levels. */
typedef struct climber {
    vfloat x, y, rise; /* the places where the rays begin, or near there, within the field; and 1 / dz */
    vfloat above;      /* highest sample of the nodes ahead, of the level above */
    vmask chain;       /* those for which clear holds at all levels so far */
} climber;

/* The place at t along an axis, or near it: within the field, and not on its far border, where no node begins. */
static inline vfloat climb_place(const vaxis *a, vfloat t, size_t samples) {
    const vfloat last = vf_set((float)(samples - 1) - 0.5f);
    return vf_max(vf_min(vf_add(a->org, vf_mul(t, a->dir)), last), vf_set(0));
}

/* Also cuts the ray, as the lane walk needs it. */
static inline void climb_start(climber *c, vray *r, const cw_field *f, vmask alive) {
    c->rise = make_slab(r, f, CW_LEAF_WATERTIGHT);
    c->chain = vm_and(alive, vf_gt(r->dz, vf_set(0)));
    c->x = climb_place(&r->x, r->from, f->nx);
    c->y = climb_place(&r->y, r->from, f->ny);
    c->above = vf_set(f->pyramid->high);
}

/* Two nodes along an axis: the one in which the ray begins, and the next one. */
typedef struct climb_pair {
    vfloat enter, leave; /* crossings of their borders */
    vfloat number;       /* the second in field order, which names them in cw_pyramid_level.ahead */
} climb_pair;

static inline climb_pair climb_pair_of(const vaxis *a, vfloat place, vfloat side, vfloat scale) {
    const vfloat first = vf_floor(vf_mul(place, scale)), next = vf_add(first, vf_set(1));
    const vfloat enter = vf_select(a->up, first, next);
    const vfloat leave = vf_add(enter, vf_select(a->up, vf_set(2), vf_set(-2)));
    return (climb_pair){crossing(a, vf_mul(side, enter)), crossing(a, vf_mul(side, leave)),
                        vf_select(a->up, next, first)};
}

/* Shortens r->until to the end that this level gives, if any. */
static inline void climb_level(climber *c, vray *r, const cw_pyramid_level *l) {
    const vfloat scale = vf_set(1 / l->side), side = vf_set(l->side);
    const climb_pair x = climb_pair_of(&r->x, c->x, side, scale), y = climb_pair_of(&r->y, c->y, side, scale);
    const vfloat reach = vf_min(x.leave, y.leave);
    const vfloat there = vf_mul(vf_min(reach, vf_set(FLT_MAX)), r->dz);
    const vmask clear = vm_or(vf_gt(there, above_origin(r, c->above)), vf_gt(reach, r->until));
    c->chain = vm_and(c->chain, clear);
    if (!vm_any(c->chain)) return;
    const vint number = vi_add(vi_mul(vi_from_vf(vf_select(c->chain, y.number, vf_set(0))), vi_set(4 * l->across + 1)),
                               vi_from_vf(vf_select(c->chain, x.number, vf_set(0))));
    c->above = vf_gather(l->ahead, number, c->chain);
    /* A guess that lies slightly too far on. The comparison below decides. */
    const vfloat clearance = above_origin(r, c->above);
    const vfloat guess = vf_mul(clearance, c->rise);
    const vfloat begin = vf_max(r->from, vf_max(x.enter, y.enter));
    const vfloat end = vf_max(begin, vf_add(guess, vf_mul(vf_set(0x1p-16f), vf_abs(guess))));
    const vmask holds = vm_and(vm_and(c->chain, vf_le(end, reach)), vf_gt(vf_mul(end, r->dz), clearance));
    r->until = vf_select(holds, vf_min(r->until, end), r->until);
}

/* Shortens r->until of these packets' rays; c: one for each packet. All packets take one level together: within a
 * packet each level depends on the one above, and the CPU can overlap the packets. */
static inline void climb(packet *packets, climber *c, packet_set which, const cw_field *f) {
    const struct cw_pyramid *p = f->pyramid;
    packet_set climbs = 0;
    for (packet_set left = which; left != 0; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        climb_start(&c[k], &packets[k].r, f, packets[k].alive);
        climbs |= (packet_set)vm_any(c[k].chain) << k;
    }
    for (int level = p->levels - 1; level >= 0 && climbs != 0; level--)
        for (packet_set left = climbs; left != 0; left &= left - 1) {
            const int k = __builtin_ctzll(left);
            climb_level(&c[k], &packets[k].r, &p->level[level]);
            climbs &= ~((packet_set)!vm_any(c[k].chain) << k);
        }
}

/* Lanes whose remaining way is so short that flat steps may end it. */
static inline vmask short_way(const vray *r, vmask alive) {
    const vfloat speed = vf_max(vf_abs(r->x.dir), vf_abs(r->y.dir));
    return vm_and(alive, vf_le(vf_mul(vf_sub(r->until, r->from), speed), vf_set(8)));
}

#endif
