/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk, for rays that have nothing in common. Each lane has a ray, a node and a level, and reads that
 * node's bounds. Lanes share only instructions. A lane whose ray has ended is refilled from the queue, so the vector
 * stays full.
 *
 * If the ray of a lane meets the slab of its node, the lane goes down to a child. Otherwise it steps to the next
 * node of the same size, and up if that node has another parent. Going down cuts the ray to its part within the
 * slab: the lane goes on where the ray enters it, and skips the rest of the node from the t at which it leaves it
 * (leave). A lane stores that t for its lowest node only. The sides of levels differ by a factor of four, so going
 * down and up is rare. Lanes that have reached a cell wait for others, since the leaf test costs as much as two
 * steps.
 *
 * Invariant: at all t before s->t, and from s->leave on within the parent, the leaf test's height of the ray above
 * the surface has one strict sign. So a cell in which the computed sign may change is never skipped: a node is
 * skipped only if the sign is strict on all of it. papers/numerics.md derives how wide slabs must be for that. Going
 * down picks a child by the ray's place at t, set back by more than its rounding error. If that is a child too
 * early, its interval is empty and the walk steps on.
 *
 * Papers: Tevs, Ihrke and Seidel 2008 (a pyramid of maxima), Smits, Shirley and Stark 2000 (parallel planes that
 * bound a displaced triangle). We know of no pyramid of slabs over a height field. Rejected: testing 16 children of
 * one ray's node at once. It takes as many instructions, mispredicts more branches and gains less from wider vectors
 * (papers/walks.md). */
#ifndef CELLWALK_SIMD_LANE_WALK_H
#define CELLWALK_SIMD_LANE_WALK_H

#include "lane_queue.h"
#include "pyramid.h"
#include "vector_watertight.h"
#if REGISTERS == 1
#include "vector_refine.h"
#endif

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- finds, and their conversion to hits ---- */

#if REGISTERS == 1 /* vectors of two registers call it, too */
CW_ONE_COPY void CW_CODE(lane_write)(lane_answers *a, const cw_field *f) {
    const size_t count = a->found;
    const cw_ray *rays[W];
    for (size_t m = count; m < W; m++) {
        for (int k = 0; k < FOUND_NUMBERS; k++) a->find[k][m] = 0; /* not numbers that nothing has set */
        a->number[m] = a->number[0];
    }
    for (size_t k = 0; k < W; k++) rays[k] = &a->rays[a->number[k]];
    vfloat n[FOUND_NUMBERS];
    for (int k = 0; k < FOUND_NUMBERS; k++) n[k] = vf_load(a->find[k]);
    const found_hits found = {{n[FOUND_T0], n[FOUND_T1], vf_gt(n[FOUND_B], vf_set(0))},
                              n[FOUND_I],
                              n[FOUND_J],
                              n[FOUND_H00],
                              n[FOUND_CORNER],
                              n[FOUND_H11]};
    vfloat c[8];
    vf_load_each_ray(rays, c);
    vstart s, moved;
    (void)start_rays(&s, f, c, &moved); /* all of them do hit */
    if (s.moved) s = moved;
    const vhit h = refine_hits(&s, &found);
    cw_hit hits[W];
    vf_store_hits(hits, h.t, h.u, h.v, found.i, found.j, found.find.b);
    for (size_t k = 0; k < count; k++) a->hits[a->number[k]] = hits[k];
    a->found = 0;
}
#endif

/* Adds a ray's find, in cell (i, j). */
CW_INLINE void one_found(lane_answers *a, const cw_field *f, uint32_t ray, float t0, float t1, bool b, int32_t i,
                         int32_t j) {
    if (a->occluded) {
        a->occluded[ray] = 1;
        return;
    }
    const float *row = f->z + (size_t)j * f->stride + (size_t)i, *corner = b ? row + f->stride : row + 1;
    const float find[FOUND_NUMBERS] = {t0, t1, (float)i, (float)j, row[0], *corner, row[f->stride + 1], b};
    for (int k = 0; k < FOUND_NUMBERS; k++) a->find[k][a->found] = find[k];
    a->number[a->found++] = ray;
    if (a->found == W) CW_CODE(lane_write)(a, f);
}

/* Adds the finds that lanes of found have left in t and leave; in_b: those in triangle B. */
CW_INLINE void lanes_found(lane_answers *a, const cw_field *f, const lane_set *l, unsigned found, unsigned in_b) {
    for (; found != 0; found &= found - 1) {
        const unsigned k = (unsigned)__builtin_ctz(found);
        one_found(a, f, l->ray[k], l->t[k], l->leave[k], in_b >> k & 1, l->x[k] ^ l->rays.i[RAY_TURNED_X][k],
                  l->y[k] ^ l->rays.i[RAY_TURNED_Y][k]);
    }
}

/* ---- the walk ---- */

/* REFILL_AT: empty lanes at which they are refilled. LEAF_AT: lanes waiting at cells at which the next
 * step tests these. */
enum { REFILL_AT = LANES < 4 ? 1 : LANES < 16 ? LANES / 4 : 3, LEAF_AT = (3 * LANES + 7) / 8 };

/* If the queue is empty, two registers stop when one can hold the rest. */
enum { LANES_LEFT = REGISTERS == 2 ? W : 0 };

/* The part of a lane's state that changes from step to step, in registers between two refills. The rest is in
 * lane_rays. */
typedef struct lane_state {
    vfloat t;
    vfloat leave; /* t from which the rest of the parent is skipped; -infinity: skip this node; infinity: nothing */
    vint x, y;    /* low corner of the node, mirrored */
    vint level;   /* 0 for cells; side 4^level */
    vmask alive;
    int waited; /* lanes that waited at cells a step ago; 0 after a leaf test */
    /* Lanes that ended with a find, its t in t and leave, which no step changes as t <= leave; those in triangle B. */
    unsigned found, in_b;
} lane_state;

/* Copies a ray that has been made ready into a lane, in loops of at most 16 turns, which compilers unroll. */
static inline void copy_ray(lane_rays *to, size_t lane, const ready_rays *from, size_t k) {
    for (int c = 0; c < RAY_AXIS; c++) to->f[c][lane] = from->f[c][k];
    for (int c = RAY_AXIS; c < 2 * RAY_AXIS; c++) to->f[c][lane] = from->f[c][k];
    for (int c = 2 * RAY_AXIS; c < RAY_FLOATS; c++) to->f[c][lane] = from->f[c][k];
    for (int c = 0; c < RAY_INTS; c++) to->i[c][lane] = from->i[c][k];
}

CW_INLINE void refill_lane(lane_set *l, size_t lane, const lane_queue *queue, const queued *q) {
    copy_ray(&l->rays, lane, &queue->ready[q->packet], q->lane);
    l->t[lane] = q->t;
    l->leave[lane] = INFINITY;
    l->x[lane] = q->x;
    l->y[lane] = q->y;
    l->level[lane] = q->level;
    l->ray[lane] = queue->first + q->ray;
    l->born[lane] = l->clock;
}

CW_INLINE lane_state load_lanes(const lane_set *l) {
    return (lane_state){.t = vf_load(l->t),
                        .leave = vf_load(l->leave),
                        .x = vi_load(l->x),
                        .y = vi_load(l->y),
                        .level = vi_load(l->level),
                        .alive = vm_from_bits(l->living)};
}

CW_INLINE void store_lanes(lane_set *l, const lane_state *s) {
    vf_store(l->t, s->t);
    vf_store(l->leave, s->leave);
    vi_store(l->x, s->x);
    vi_store(l->y, s->y);
    vi_store(l->level, s->level);
    l->living = vm_bits(s->alive);
}

/* The numbers of one axis in a step. */
typedef struct lane_axis {
    vfloat org, dir, corner, border, out;
} lane_axis;

CW_INLINE lane_axis look_along(float f[RAY_AXIS][SLOTS], vint corner, vfloat side) {
    lane_axis a;
    a.org = vf_load(f[RAY_ORG]);
    a.dir = vf_load(f[RAY_DIR]);
    a.corner = vf_from_vi(corner);
    a.border = vf_add(a.corner, side);
    a.out = vf_mul(vf_sub(a.border, vf_load(f[RAY_CENTER])), vf_load(f[RAY_INVERSE]));
    return a;
}

/* An axis without mirroring, for leaf tests. */
CW_INLINE void turn_back(vaxis *a, float f[RAY_AXIS][SLOTS], vint turned) {
    const vfloat sign = vf_load(f[RAY_SIGN]);
    a->org = vf_flip(vf_load(f[RAY_ORG]), sign);
    a->dir = vf_flip(vf_load(f[RAY_DIR]), sign);
    a->up = vi_eq(turned, vi_set(0));
}

/* Tests the cells at which lanes wait; returns the lanes that hit. Their finds stay in the lanes until these are
 * refilled. Rejected: to take them out at once (papers/walks.md). */
CW_INLINE vmask lane_leaf(lane_state *s, lane_rays *rays, const cw_field *f, const lane_axis axis[2], vmask waits) {
    const vint turned_x = vi_load(rays->i[RAY_TURNED_X]), turned_y = vi_load(rays->i[RAY_TURNED_Y]);
    const vint i = vi_xor(s->x, turned_x), j = vi_xor(s->y, turned_y);
    float(*fx)[SLOTS] = rays->f, (*fy)[SLOTS] = rays->f + RAY_AXIS;
    vray r; /* no initialisers: they would clear all of it first */
    turn_back(&r.x, fx, turned_x);
    turn_back(&r.y, fy, turned_y);
    r.oz = vf_load(rays->f[RAY_OZ]);
    r.dz = vf_load(rays->f[RAY_DZ]);
    r.t0 = vf_load(rays->f[RAY_T0]);
    r.t1 = vf_load(rays->f[RAY_T1]);
    vcell c;
    c.i = vf_from_vi(i);
    c.j = vf_from_vi(j);
    c.x_in = vf_mul(vf_sub(axis[0].corner, vf_load(fx[RAY_CENTER])), vf_load(fx[RAY_INVERSE]));
    c.y_in = vf_mul(vf_sub(axis[1].corner, vf_load(fy[RAY_CENTER])), vf_load(fy[RAY_INVERSE]));
    c.x_out = axis[0].out;
    c.y_out = axis[1].out;
    clip_cell(&c, &r);
    const vint sample = vi_add(vi_mul(j, vi_set((int32_t)f->stride)), i);
    vf_gather_pairs(f->z, sample, waits, &c.h00, &c.h10);
    vf_gather_pairs(f->z + f->stride, sample, waits, &c.h01, &c.h11);
    const vmask gate = vm_and(waits, cell_gate(&r, &c));
    if (!vm_any(gate)) return gate;
    vfind find;
    const vmask found = wt_cell(&r, &c, gate, &find);
    const unsigned bits = vm_bits(found);
    s->t = vf_select(found, find.t0, s->t);
    s->leave = vf_select(found, find.t1, s->leave);
    s->found |= bits;
    s->in_b |= vm_bits(find.b) & bits;
    return found;
}

/* Number along the axis, of 0 to 3, of the child in which the ray is at t, or of an earlier one. */
CW_INLINE vint child_at(float f[RAY_AXIS][SLOTS], const lane_axis *a, vfloat t, vfloat inverse_side) {
    const vfloat last = vf_sub(vf_load(f[RAY_LAST]), vf_set(0.5f));
    vfloat place = vf_add(vf_mul(t, a->dir), vf_load(f[RAY_EARLY]));
    place = vf_max(vf_min(place, last), vf_load(f[RAY_FIRST]));
    const vfloat number = vf_mul(vf_sub(place, a->corner), inverse_side);
    return vi_from_vf(vf_max(vf_min(number, vf_set(3)), vf_set(0))); /* in this order NaN would become 3 */
}

/* Returns the lanes of moves that go down to a child of their node, and sets their t, leave and place. */
CW_INLINE vmask lane_descend(lane_state *s, lane_rays *rays, const cw_field *f, const lane_axis axis[2], vfloat side,
                             vfloat out, vmask moves) {
    const struct cw_pyramid *p = f->pyramid;
    const vint shift = vi_add(s->level, s->level), one = vi_set(1);
    const vint i = vi_shift_right(vi_xor(s->x, vi_load(rays->i[RAY_TURNED_X])), shift);
    const vint j = vi_shift_right(vi_xor(s->y, vi_load(rays->i[RAY_TURNED_Y])), shift);
    const vint across = vi_add(one, vi_shift_right(vi_set((int32_t)f->nx - 2), shift));
    const vint node = vi_add(vi_add(vi_mul(j, across), i), vi_lookup(p->first, s->level));
    vfloat slab[4];
    vf_gather_quads(&p->slab->low, node, moves, slab);
    const vfloat pad = vf_load(rays->f[RAY_PAD]), low = vf_sub(slab[0], pad), high = vf_add(slab[1], pad);
    const vfloat slope[2] = {vf_flip(slab[2], vf_load(rays->f[RAY_SIGN])),
                             vf_flip(slab[3], vf_load(rays->f[RAY_AXIS + RAY_SIGN]))};
    /* The height above the plane is origin + t rate; slopes are mirrored, and places are from the node's middle. */
    const vfloat half = vf_mul(side, vf_set(0.5f)), place_x = vf_sub(axis[0].org, vf_add(axis[0].corner, half)),
                 place_y = vf_sub(axis[1].org, vf_add(axis[1].corner, half)), oz = vf_load(rays->f[RAY_OZ]);
    const vfloat origin = vf_sub(vf_sub(oz, vf_mul(slope[0], place_x)), vf_mul(slope[1], place_y)),
                 rise = vf_sub(vf_load(rays->f[RAY_DZ]), vf_mul(slope[0], axis[0].dir)),
                 rate = vf_sub(rise, vf_mul(slope[1], axis[1].dir));
    const vfloat t = s->t, t1 = vf_min(out, vf_load(rays->f[RAY_UNTIL]));
    const vfloat d0 = vf_add(vf_mul(t, rate), origin), d1 = vf_add(vf_mul(t1, rate), origin);
    const vmask misses = vm_or(vf_gt(vf_min(d0, d1), high), vf_lt(vf_max(d0, d1), low));
    const vmask wanted = vf_le(t, s->leave);
    s->leave = vf_select(wanted, s->leave, vf_set(INFINITY));
    const vmask enters = vm_and(moves, vm_andnot(vm_and(wanted, vf_le(t, t1)), misses));
    if (!vm_any(enters)) return enters;
    /* Cut off the parts before and after the slab: t where the ray enters it and leaves it again. If the rate is
     * NaN, so are both products, and the comparisons select t and infinity. */
    const vfloat zero = vf_set(0), per = vf_div(vf_set(1), vf_max(vf_set(FLT_MIN), vf_abs(rate)));
    const vfloat before = vf_max(zero, vf_max(vf_sub(d0, high), vf_sub(low, d0)));
    const vfloat after = vf_max(zero, vf_max(vf_sub(d1, high), vf_sub(low, d1)));
    const vfloat start = vf_min(vf_max(vf_add(vf_mul(before, per), t), t), t1);
    const vfloat leave = vf_max(start, vf_min(vf_sub(t1, vf_mul(after, per)), vf_set(INFINITY)));
    s->t = vf_select(enters, start, t);
    s->leave = vf_select(enters, leave, s->leave);
    const vint child_shift = vi_add(shift, vi_set(-2)), none = vi_set(0);
    const vfloat inverse = vf_power_of_2(vi_add(none, vi_sub(none, child_shift)));
    const vint x = child_at(rays->f, &axis[0], start, inverse),
               y = child_at(rays->f + RAY_AXIS, &axis[1], start, inverse);
    s->x = vi_add(s->x, vi_where(enters, vi_shift_left(x, child_shift)));
    s->y = vi_add(s->y, vi_where(enters, vi_shift_left(y, child_shift)));
    s->level = vi_add(s->level, vi_where(enters, vi_set(-1)));
    return enters;
}

/* Moves lanes to the next node of the same size, and up to the parent if that is another one or if the rest of the
 * parent is skipped. */
CW_INLINE void lane_advance(lane_state *s, lane_rays *rays, const lane_axis axis[2], vfloat out, vmask moves) {
    const vmask in_x = vf_le(axis[0].out, axis[1].out);
    const vmask leaves = vm_or(vm_and(in_x, vf_ge(axis[0].border, vf_load(rays->f[RAY_LAST]))),
                               vm_andnot(vf_ge(axis[1].border, vf_load(rays->f[RAY_AXIS + RAY_LAST])), in_x));
    const vmask ends = vm_and(moves, vm_or(leaves, vf_gt(out, vf_load(rays->f[RAY_UNTIL]))));
    s->alive = vm_andnot(s->alive, ends);
    const vint one = vi_set(1), side = vi_shift_left(one, vi_add(s->level, s->level));
    const vint x = vi_add(s->x, vi_where(vm_and(moves, in_x), side));
    const vint y = vi_add(s->y, vi_where(vm_andnot(moves, in_x), side));
    const vint parent = vi_sub(vi_set(0), vi_add(vi_add(side, side), vi_add(side, side)));
    const vint changed = vi_and(vi_or(vi_xor(x, s->x), vi_xor(y, s->y)), parent);
    const vmask elsewhere = vm_andnot(moves, vi_eq(changed, vi_set(0)));
    const vfloat t = vf_select(moves, vf_max(s->t, out), s->t);
    const vmask through = vm_andnot(vm_and(moves, vf_gt(t, s->leave)), elsewhere), rises = vm_or(elsewhere, through);
    s->leave = vf_select(elsewhere, vf_set(INFINITY), vf_select(through, vf_set(-INFINITY), s->leave));
    const vint to = vi_select(rises, parent, vi_set(-1));
    s->x = vi_and(x, to);
    s->y = vi_and(y, to);
    s->level = vi_add(s->level, vi_where(rises, one));
    s->t = t;
}

/* One step of every living lane, except those that wait at a cell. Level 0 here is cells; level l + 1 is the pyramid's
 * level l. Unless no lane can move, the step before decides whether cells are tested, so the CPU knows it early.
 * Rejected: this step, which ends late (papers/walks.md). */
CW_INLINE void lane_step(lane_state *s, lane_rays *rays, const cw_field *f) {
    const vfloat side = vf_power_of_2(vi_add(s->level, s->level));
    const lane_axis axis[2] = {look_along(rays->f, s->x, side), look_along(rays->f + RAY_AXIS, s->y, side)};
    const vfloat out = vf_min(axis[0].out, axis[1].out);
    const vmask at_cell = vi_eq(s->level, vi_set(0)), waits = vm_and(s->alive, at_cell);
    vmask moves = vm_andnot(s->alive, at_cell);
    if (s->waited >= LEAF_AT || !vm_any(moves)) {
        const vmask found = lane_leaf(s, rays, f, axis, waits);
        s->alive = vm_andnot(s->alive, found);
        moves = vm_andnot(waits, found);
        s->waited = 0;
    } else {
        moves = vm_andnot(moves, lane_descend(s, rays, f, axis, side, out, moves));
        s->waited = __builtin_popcount(vm_bits(waits));
    }
    lane_advance(s, rays, axis, out, moves);
}

/* A ray that has kept its lane for 2^LATE_SHIFT steps is late; LOOK_AFTER: steps from one look for such rays to the
 * next. A step takes as long for FEW lanes as for all, so if at most FEW rays are left, these numbers are smaller. */
enum { LATE_SHIFT = 7, LOOK_AFTER = 128 };
enum { FEW = LANES / 4, LATE_SHIFT_OF_FEW = 5, LOOK_AFTER_OF_FEW = 32 };

/* Takes those rays out of their lanes that are late, and walks them to their ends. */
CW_INLINE void end_late(const cw_field *f, lane_set *l, bool few, lane_answers *answers) {
    if (l->clock < l->look_at && !few) return;
    l->look_at = l->clock + LOOK_AFTER;
    const vint age = vi_sub(vi_set(l->clock), vi_load(l->born));
    const vmask young = vi_eq(vi_shift_right(age, vi_set(few ? LATE_SHIFT_OF_FEW : LATE_SHIFT)), vi_set(0));
    unsigned late = ~vm_bits(young) & l->living;
    l->living &= ~late;
    for (; late != 0; late &= late - 1) {
        const size_t lane = (size_t)__builtin_ctz(late);
        strict_find at;
        const one_cell cell = CW_CODE(one_late)(f, &answers->rays[l->ray[lane]], l->t[lane], &at);
        if (cell != NO_CELL)
            one_found(answers, f, l->ray[lane], at.t0, at.t1, at.b, (int32_t)(uint32_t)cell, (int32_t)(cell >> 32));
    }
}

/* Walks the rays in the lanes and in the queue to their ends and writes their hits. If more are to follow, it
 * returns when the queue is empty and lanes would be refilled; rays stay in their lanes, and finds in answers, for the
 * next call. Two registers leave the last rays to one (walk_alone).
 *
 * Rejected: ending each batch, with ever fewer lanes alive. Rejected: two vectors of lanes that take turns, so that
 * one works while the other waits for its bounds or samples. Their state goes through memory, which costs more than
 * the waiting in all but the largest fields. */
CW_INLINE void lane_walk(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, lane_answers *answers) {
    if (l->living == 0 && queue->n > 0) memset(l, 0, sizeof *l); /* empty lanes take part in every operation */
    for (size_t next = 0;;) {
        for (unsigned empty = ~l->living & ~0u >> (32 - LANES); empty != 0 && next < queue->n; empty &= empty - 1) {
            const unsigned lane = (unsigned)__builtin_ctz(empty);
            refill_lane(l, lane, queue, &queue->rays[next++]);
            l->living |= 1u << lane;
        }
        const int refill_at = more || next < queue->n ? LANES - REFILL_AT : LANES_LEFT;
        if (__builtin_popcount(l->living) <= refill_at) break;
        const bool few = refill_at == 0 && __builtin_popcount(l->living) <= FEW;
        const int stop_at = refill_at == 0 && !few ? FEW : refill_at, most = few ? LOOK_AFTER_OF_FEW : LOOK_AFTER;
        lane_state s = load_lanes(l);
        unsigned living;
        int steps = most;
        do {
            lane_step(&s, &l->rays, f);
            living = vm_bits(s.alive);
        } while (__builtin_popcount(living) > stop_at && --steps > 0);
        l->clock += most - steps;
        store_lanes(l, &s);
        lanes_found(answers, f, l, s.found, s.in_b);
        end_late(f, l, few, answers);
    }
    if (!more && LANES_LEFT == 0 && answers->found > 0) CW_CODE(lane_write)(answers, f);
}

#endif
