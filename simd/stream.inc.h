/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk, for rays that have nothing in common: each lane has a ray, a node and a level of its own and reads its own
 * bounds; lanes share instructions alone. A lane whose ray has ended is refilled from the queue, so the vector stays
 * full.
 *
 * A lane at a node that its ray may hit something in goes down to the first child; otherwise it steps to the next node of
 * the same size, and up where that has another parent. Levels are four apart, so that going down and up is rare. Lanes
 * that have come down to a cell wait until half of the vector does: the leaf test costs as much as three steps.
 *
 * Invariant: t is at most the t at which the ray enters any cell that it still has to visit. A node is skipped only if
 * the ray misses its heights over all of [t, t at which it leaves the node], in the gate's own monotone arithmetic
 * (src/scalar/strict.h). Going down picks a child by the ray's place at t, set back by more than its rounding error: if
 * that is a child too early, its interval is empty and the walk steps on.
 *
 * Rejected for this job: 16 children of one ray's node at once (wide.inc.h). On AVX2 it takes as many instructions a ray
 * (1590 and 1570 for random rays in 1025² samples, callgrind), since a ray crosses 4 of the 16 children; it mispredicts
 * more branches, and gains less from wider vectors. */

/* A ray waiting for a lane. */
typedef struct queued {
    float x_org, x_dir, x_center, x_inverse;
    float y_org, y_dir, y_center, y_inverse;
    float oz, dz, tmin, tmax, begin, end, from, until;
    uint32_t ray; /* where its hit goes */
    bool low;     /* starts near the surface: best at the block it is in */
} queued;

/* What each lane works on, as arrays, so that single lanes can be refilled. */
typedef struct stream_lanes {
    ray_store r;
    float t[W], pad_x[W], pad_y[W];
    int32_t i[W], j[W], level[W], side[W]; /* side = 4^level */
    uint32_t ray[W];
} stream_lanes;

/* The same in registers, as far as a step needs it, between two refills. */
typedef struct stream_state {
    vray r;
    vfloat t, pad_x, pad_y;
    vint i, j, level, side;
    vmask alive;
} stream_state;

static inline void enqueue(queued *q, const ray_store *s, size_t k, uint32_t ray, bool low) {
    *q = (queued){s->x_org[k],    s->x_dir[k],     s->x_center[k], s->x_inverse[k], s->y_org[k], s->y_dir[k],
                  s->y_center[k], s->y_inverse[k], s->oz[k],       s->dz[k],        s->tmin[k],  s->tmax[k],
                  s->begin[k],    s->end[k],       s->from[k],     s->until[k],     ray,         low};
}

/* Low corner of the block that the place is in, or of the nearest one in the field. */
static inline int32_t block_corner(float place, size_t samples) {
    const float last = (float)(samples - 1) - 0.5f;
    const float inside = place < last ? place : last;
    return inside > 0 ? (int32_t)inside & ~3 : 0;
}

/* Puts a ray into lane k, at the root of the pyramid or, if it is low, at its block: a ray that has just left the surface
 * then rises no further than it must. */
static inline void refill_lane(stream_lanes *l, size_t k, const queued *q, const cw_field *f) {
    count_step(COUNT_REFILL, 1);
    l->r.x_org[k] = q->x_org;
    l->r.x_dir[k] = q->x_dir;
    l->r.x_center[k] = q->x_center;
    l->r.x_inverse[k] = q->x_inverse;
    l->r.y_org[k] = q->y_org;
    l->r.y_dir[k] = q->y_dir;
    l->r.y_center[k] = q->y_center;
    l->r.y_inverse[k] = q->y_inverse;
    l->r.oz[k] = q->oz;
    l->r.dz[k] = q->dz;
    l->r.tmin[k] = q->tmin;
    l->r.tmax[k] = q->tmax;
    l->r.begin[k] = q->begin;
    l->r.end[k] = q->end;
    l->r.until[k] = q->until;
    l->t[k] = q->from;
    /* Rounding of org + t · dir within the field: less than 4 ulp of the larger of the origin and the field's side. */
    const float pad_x = 0x1p-21f * (fabsf(q->x_org) + (float)f->nx),
                pad_y = 0x1p-21f * (fabsf(q->y_org) + (float)f->ny);
    l->pad_x[k] = q->x_inverse >= 0 ? -pad_x : pad_x;
    l->pad_y[k] = q->y_inverse >= 0 ? -pad_y : pad_y;
    l->ray[k] = q->ray;
    l->i[k] = l->j[k] = 0;
    l->level[k] = f->pyramid->levels + 1;
    if (q->low) {
        l->level[k] = 1;
        l->i[k] = block_corner(q->x_org + q->from * q->x_dir + l->pad_x[k], f->nx);
        l->j[k] = block_corner(q->y_org + q->from * q->y_dir + l->pad_y[k], f->ny);
    }
    l->side[k] = 1 << (2 * l->level[k]);
}

/* The rays of the lanes, and only what a walk needs of them. */
CW_INLINE void load_rays(vray *r, const ray_store *s) {
    const vfloat zero = vf_set(0);
    r->x.org = vf_load(s->x_org);
    r->x.dir = vf_load(s->x_dir);
    r->x.center = vf_load(s->x_center);
    r->x.inverse = vf_load(s->x_inverse);
    r->x.up = vf_ge(r->x.dir, zero);
    r->y.org = vf_load(s->y_org);
    r->y.dir = vf_load(s->y_dir);
    r->y.center = vf_load(s->y_center);
    r->y.inverse = vf_load(s->y_inverse);
    r->y.up = vf_ge(r->y.dir, zero);
    r->oz = vf_load(s->oz);
    r->dz = vf_load(s->dz);
    r->tmin = vf_load(s->tmin);
    r->tmax = vf_load(s->tmax);
    r->begin = vf_load(s->begin);
    r->end = vf_load(s->end);
    r->until = vf_load(s->until);
}

/* The low corner of the child of the given side in which the ray is at t, or an earlier one, of the node that begins at
 * low and is four times as long. It is no child outside the field: inside is the middle of the field's last cell. */
CW_INLINE vint child_corner(const vaxis *a, vfloat t, vfloat pad, vfloat inside, vfloat low, vfloat side,
                            vfloat inverse_side) {
    const vfloat place = vf_min(vf_add(vf_add(a->org, vf_mul(t, a->dir)), pad), inside);
    const vfloat corner = vf_mul(vf_floor(vf_mul(place, inverse_side)), side);
    return vi_from_vf(vf_max(low, vf_min(vf_add(low, vf_mul(side, vf_set(3))), corner)));
}

/* Lanes whose border, by which they leave a node, is the field's or beyond it. */
static inline vmask outermost(const vaxis *a, vfloat border, vfloat last) {
    return vm_or(vm_and(a->up, vf_ge(border, last)), vm_andnot(vf_le(border, vf_set(0)), a->up));
}

/* Writes what the leaf test found in the lanes of a mask. */
CW_INLINE void stream_hits(const uint32_t ray[W], unsigned found, const vhit *h, vint i, vint j, bool any, cw_hit *hits,
                           uint8_t *occluded) {
    if (any) {
        for (; found != 0; found &= found - 1) occluded[ray[__builtin_ctz(found)]] = 1;
        return;
    }
    float t[W], u[W], v[W];
    vf_store(t, h->t);
    vf_store(u, h->u);
    vf_store(v, h->v);
    int32_t cell_i[W], cell_j[W];
    vi_store(cell_i, i);
    vi_store(cell_j, j);
    const unsigned in_b = vm_bits(h->b);
    for (; found != 0; found &= found - 1) {
        const int k = __builtin_ctz(found);
        hits[ray[k]] = (cw_hit){t[k], u[k], v[k], cell_i[k], cell_j[k], in_b >> k & 1};
    }
}

/* Refill when this many lanes are empty; test cells when this many lanes wait at one. */
enum { REFILL_AT = W / 4 > 0 ? W / 4 : 1, LEAF_AT = W / 2 > 0 ? W / 2 : 1 };

/* Tests the cells that lanes wait at; the lanes that hit. */
CW_INLINE vmask stream_leaf(const uint32_t ray[W], const vray *r, const cw_field *f, vmask waits, vint i, vint j,
                            vfloat x_out, vfloat y_out, cw_leaf leaf, bool any, cw_hit *hits, uint8_t *occluded) {
    const vfloat unit = vf_set(1), low_x = vf_from_vi(i), low_y = vf_from_vi(j);
    vcell c; /* no initialiser: it would clear all of it first */
    c.i = low_x;
    c.j = low_y;
    c.x_in = crossing(&r->x, vf_select(r->x.up, low_x, vf_add(low_x, unit)));
    c.y_in = crossing(&r->y, vf_select(r->y.up, low_y, vf_add(low_y, unit)));
    c.x_out = x_out;
    c.y_out = y_out;
    c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->begin);
    c.t1 = vf_min(vf_min(x_out, y_out), r->end);
    const vint sample = vi_add(vi_mul(j, vi_set((int32_t)f->stride)), i);
    vf_gather_pairs(f->z, sample, waits, &c.h00, &c.h10);
    vf_gather_pairs(f->z + f->stride, sample, waits, &c.h01, &c.h11);
    const vmask gate = vm_and(waits, cell_gate(r, &c));
    if (!vm_any(gate)) return gate;
    count_lanes(COUNT_LEAF, gate);
    vhit h;
    const vmask found = leaf == CW_LEAF_WATERTIGHT ? wt_cell(r, &c, gate, any, &h) : mt_cell(r, &c, gate, &h);
    if (vm_any(found)) stream_hits(ray, vm_bits(found), &h, i, j, any, hits, occluded);
    return found;
}

/* One step of every living lane, but for those that wait at a cell. */
CW_INLINE void stream_step(stream_state *s, const uint32_t ray[W], const cw_field *f, const int32_t first[16],
                           cw_leaf leaf, bool any, cw_hit *hits, uint8_t *occluded) {
    const struct cw_pyramid *p = f->pyramid;
    const vint zero = vi_set(0), one = vi_set(1);
    const vray *r = &s->r;
    vint i = s->i, j = s->j, level = s->level, side = s->side;
    const vfloat t = s->t, length = vf_from_vi(side), low_x = vf_from_vi(i), low_y = vf_from_vi(j);
    const vfloat border_x = vf_select(r->x.up, vf_add(low_x, length), low_x);
    const vfloat border_y = vf_select(r->y.up, vf_add(low_y, length), low_y);
    const vfloat x_out = crossing(&r->x, border_x), y_out = crossing(&r->y, border_y), out = vf_min(x_out, y_out);
    const vmask at_cell = vi_eq(level, zero), waits = vm_and(s->alive, at_cell);
    vmask moves = vm_andnot(s->alive, at_cell);
    count_lanes(COUNT_STREAM, s->alive);
    if (__builtin_popcount(vm_bits(waits)) >= LEAF_AT || !vm_any(moves)) {
        count_lanes(COUNT_ROUND, waits);
        const vmask found = stream_leaf(ray, r, f, waits, i, j, x_out, y_out, leaf, any, hits, occluded);
        s->alive = vm_andnot(s->alive, found);
        moves = vm_andnot(waits, found);
    } else {
        count_lanes(COUNT_NODE, moves);
        const vint shift = vi_add(level, level), across = vi_set(p->across);
        const vint row = vi_mul(vi_shift_right(j, shift), across);
        const vint node = vi_add(vi_add(row, vi_shift_right(i, shift)), vi_lookup(first, level));
        vfloat low, high;
        vf_gather_pairs(p->pairs, vi_add(node, node), moves, &low, &high);
        const vfloat t1 = vf_min(out, r->until);
        const vmask root = vi_eq(level, vi_set(p->levels + 1));
        const vmask enters = vm_and(moves, vm_or(root, vm_and(vf_le(t, t1), meets(r, t, t1, low, high))));
        if (vm_any(enters)) {
            const vfloat child = vf_mul(length, vf_set(0.25f)), inverse = vf_div(vf_set(1), child);
            const vfloat inside_x = vf_set((float)(f->nx - 1) - 0.5f), inside_y = vf_set((float)(f->ny - 1) - 0.5f);
            i = vi_select(enters, child_corner(&r->x, t, s->pad_x, inside_x, low_x, child, inverse), i);
            j = vi_select(enters, child_corner(&r->y, t, s->pad_y, inside_y, low_y, child, inverse), j);
            level = vi_select(enters, vi_add(level, vi_set(-1)), level);
            side = vi_select(enters, vi_shift_right(side, vi_set(2)), side);
        }
        moves = vm_andnot(moves, enters);
    }
    /* On to the next node of the same size, and to its parent where that is another one. */
    const vmask in_x = vf_le(x_out, y_out);
    const vmask leaves = vm_or(vm_and(in_x, outermost(&r->x, border_x, vf_set((float)(f->nx - 1)))),
                               vm_andnot(outermost(&r->y, border_y, vf_set((float)(f->ny - 1))), in_x));
    s->alive = vm_andnot(s->alive, vm_and(moves, vm_or(leaves, vf_gt(out, r->until))));
    const vint back = vi_neg(side);
    const vint to_x = vi_add(i, vi_select(r->x.up, side, back)), to_y = vi_add(j, vi_select(r->y.up, side, back));
    const vint new_i = vi_select(vm_and(moves, in_x), to_x, i), new_j = vi_select(vm_andnot(moves, in_x), to_y, j);
    const vint above = vi_add(vi_add(side, side), vi_add(side, side)), parent = vi_neg(above);
    const vint changed = vi_and(vi_or(vi_xor(new_i, i), vi_xor(new_j, j)), parent);
    const vmask rises = vm_andnot(moves, vi_eq(changed, zero));
    s->i = vi_select(rises, vi_and(new_i, parent), new_i);
    s->j = vi_select(rises, vi_and(new_j, parent), new_j);
    s->level = vi_select(rises, vi_add(level, one), level);
    s->side = vi_select(rises, above, side);
    s->t = vf_select(moves, vf_max(t, out), t);
}

/* Walks the queued rays to their ends. A hit is written to hits[ray], or for any hit 1 to occluded[ray].
 *
 * Rejected: two vectors of lanes that take turns, so that one works while the other waits for its bounds or samples. It
 * runs more instructions at once, but needs 5 to 20 % more of them for state that no longer fits into registers, and is
 * 7 % slower on Zen 3 (cellwalk-bench micro, field 1025, random, ao and grazing rays). */
CW_INLINE void stream_walk(const cw_field *f, const queued *queue, size_t n, cw_leaf leaf, bool any, cw_hit *hits,
                           uint8_t *occluded) {
    /* Levels here: cells 0, nodes of pyramid level l l + 1, the whole field one above; sides 4^level. */
    int32_t first[16] = {0};
    memcpy(first + 1, f->pyramid->first, sizeof f->pyramid->first);
    stream_lanes store;
    memset(&store, 0, sizeof store);
    stream_state s;
    unsigned living = 0;
    for (size_t next = 0;;) {
        for (unsigned empty = ~living & ((1u << W) - 1); empty != 0 && next < n; empty &= empty - 1) {
            const unsigned lane = (unsigned)__builtin_ctz(empty);
            refill_lane(&store, lane, &queue[next++], f);
            living |= 1u << lane;
        }
        if (living == 0) return;
        count_step(COUNT_RELOAD, living);
        load_rays(&s.r, &store.r);
        s.t = vf_load(store.t);
        s.pad_x = vf_load(store.pad_x);
        s.pad_y = vf_load(store.pad_y);
        s.i = vi_load(store.i);
        s.j = vi_load(store.j);
        s.level = vi_load(store.level);
        s.side = vi_load(store.side);
        s.alive = vm_from_bits(living);
        const int refill_at = next < n ? (int)W - REFILL_AT : 0;
        do {
            stream_step(&s, store.ray, f, first, leaf, any, hits, occluded);
            living = vm_bits(s.alive);
        } while (__builtin_popcount(living) > refill_at);
        vf_store(store.t, s.t);
        vi_store(store.i, s.i);
        vi_store(store.j, s.j);
        vi_store(store.level, s.level);
        vi_store(store.side, s.side);
    }
}
