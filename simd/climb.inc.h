/* SPDX-License-Identifier: Apache-2.0 */
/* Climb: ends the walk of a ray that rises out of the terrain. Shadow, ambient-occlusion and bounce rays start at the
 * surface and mostly leave it within a few cells. Each node stores the highest sample of itself and its eight
 * neighbours (pyramid.h). One comparison a level decides whether the ray is above all of these when it leaves them, and
 * the levels chain:
 *
 *     reach(k)  t at which the ray leaves the 3 × 3 nodes of level k around the one in which it begins
 *     clear(k)  its height at reach(k) is above everything around its node of level k + 1, at the top: above everything
 *     end(k)    t <= reach(k) from which it is above everything around its node of level k
 *
 * If clear holds at all levels k, k + 1, …, nothing lies beyond end(k), and the lowest such k gives the best end.
 *
 * Invariant: skipped cells are entered at t >= end, where the gate's own monotone height function is above every sample
 * in them. So the gate would fail there, and no hit changes. A cell that is entered before end has no hit after it: the
 * watertight test keeps the surface between the samples. reach is the gate's own crossing of the nodes' border.
 * Rounding may put the ray's beginning across a border, so its node may be off by one, which the neighbours cover.
 * Rays with coordinates above 2^20, where floats are 1/8 cell apart, are skipped, so that it is off by no more.
 *
 * No paper is known to us. Rejected: the global maximum, which is too loose a bound, and a walk down the pyramid, which
 * takes longer than the comparisons. */

/* A packet on its way down the levels. */
typedef struct climber {
    vfloat x, y, rise; /* the places where the rays begin, and 1 / dz */
    vfloat above;      /* highest sample around their nodes of the level above */
    vmask chain;       /* those for which clear holds at all levels so far */
} climber;

static inline void climb_start(climber *c, const vray *r, const struct cw_pyramid *p, vmask alive) {
    const vfloat zero = vf_set(0), far = vf_set(0x1p20f);
    c->chain =
        vm_and(vm_and(alive, vf_gt(r->dz, zero)), vm_and(vf_le(vf_abs(r->x.org), far), vf_le(vf_abs(r->y.org), far)));
    c->x = vf_add(r->x.org, vf_mul(r->from, r->x.dir));
    c->y = vf_add(r->y.org, vf_mul(r->from, r->y.dir));
    c->rise = vf_div(vf_set(1), r->dz);
    c->above = vf_set(p->high);
}

/* Shortens r->until to the end that this level gives, if any. */
static inline void climb_level(climber *c, vray *r, const cw_pyramid_level *l) {
    const vfloat zero = vf_set(0), one = vf_set(1), two = vf_set(2);
    count_lanes(COUNT_CLIMB, c->chain);
    const vfloat scale = vf_set(1 / l->side), side = vf_set(l->side);
    const vfloat i = vf_max(zero, vf_min(vf_floor(vf_mul(c->x, scale)), vf_set((float)(4 * l->across - 1))));
    const vfloat j = vf_max(zero, vf_min(vf_floor(vf_mul(c->y, scale)), vf_set((float)(4 * l->down - 1))));
    const vfloat border_x = vf_mul(side, vf_select(r->x.up, vf_add(i, two), vf_sub(i, one)));
    const vfloat border_y = vf_mul(side, vf_select(r->y.up, vf_add(j, two), vf_sub(j, one)));
    const vfloat reach = vf_min(crossing(&r->x, border_x), crossing(&r->y, border_y));
    const vfloat there = vf_mul(vf_min(reach, vf_set(FLT_MAX)), r->dz);
    c->chain = vm_and(c->chain, vf_gt(there, above_origin(r, c->above)));
    if (!vm_any(c->chain)) return;
    const vint node = vi_add(vi_mul(vi_from_vf(vf_select(c->chain, j, zero)), vi_set(4 * l->across)),
                             vi_from_vf(vf_select(c->chain, i, zero)));
    c->above = vf_gather(l->around, node, c->chain);
    /* A guess that lies slightly too far on. The comparison below decides. */
    const vfloat clearance = above_origin(r, c->above);
    const vfloat guess = vf_mul(clearance, c->rise);
    const vfloat end = vf_max(r->from, vf_add(guess, vf_mul(vf_set(0x1p-16f), vf_abs(guess))));
    const vmask holds = vm_and(vm_and(c->chain, vf_le(end, reach)), vf_gt(vf_mul(end, r->dz), clearance));
    r->until = vf_select(holds, vf_min(r->until, end), r->until);
}

/* Shortens r->until of these packets' rays. All packets take one level together: within a packet each level depends
 * on the one above, and the CPU can overlap the packets. */
static inline void climb(packet *packets, packet_set which, const struct cw_pyramid *p) {
    climber c[PACKETS];
    packet_set climbs = 0;
    for (packet_set left = which; left != 0; left &= left - 1) {
        const int k = __builtin_ctzll(left);
        climb_start(&c[k], &packets[k].r, p, packets[k].alive);
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
