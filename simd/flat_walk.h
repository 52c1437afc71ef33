/* SPDX-License-Identifier: Apache-2.0 */
/* The flat walk, a ray a lane: W rays, each in its own cell, step together. After Amanatides and Woo 1987, in two
 * dimensions as in Musgrave 1988, with crossings computed from border coordinates as in src/scalar/cell.c.
 *
 * Invariant: a lane's cell is on its walk, and x_in … y_out are its four crossings. Lanes share instructions, not
 * cells. The values of a lane depend on its ray alone, so packets of any width agree in every bit.
 *
 * Rejected: carrying the two samples that the new cell shares with the old one. A lane steps in x or in y, so two
 * selects a sample would replace two loads from lines that are in the first-level cache already. */
#ifndef CELLWALK_SIMD_FLAT_WALK_H
#define CELLWALK_SIMD_FLAT_WALK_H

#include "vector_moller_trumbore.h"
#include "vector_refine.h"
#include "vector_watertight.h"

typedef struct packet {
    vray r;
    vcell c;
    vint sample; /* number of sample (i, j) */
    vmask alive; /* still walking */
    vmask found;
    found_hits hit; /* of the lanes in found; undefined if there are none, and for any-hit queries */
    /* Constants of the ray: exit borders as offsets from a cell's low corner; steps in cells and in samples. */
    vfloat x_out, y_out, x_step, y_step;
    vint samples_x, samples_y;
} packet;

/* The first cell along an axis that is left at t or later: the place at t is a guess, which the crossings correct. The
 * loops end after one turn unless the origin is so far away that neighbouring floats are cells apart. */
static inline vfloat first_cell(const vaxis *a, vfloat t, size_t samples, vmask alive) {
    const vfloat zero = vf_set(0), one = vf_set(1), last = vf_set((float)(samples - 1) - 1);
    const vfloat out = vf_select(a->up, one, zero), in = vf_sub(one, out), step = vf_sub(out, in);
    const vfloat begin = vf_select(a->up, zero, last), end = vf_sub(last, begin);
    vfloat place = vf_floor(vf_add(a->org, vf_mul(t, a->dir)));
    place = vf_max(vf_min(last, place), zero); /* in this order -0 becomes 0, as if it had been an integer */
    const vmask stays = vf_eq(a->dir, zero);
    place = vf_select(stays, vf_sub(a->center, vf_set(0.5f)), place);
    const vmask moves = vm_andnot(alive, stays);
    for (;;) {
        const vmask early = vm_andnot(vf_lt(crossing(a, vf_add(place, out)), t), vf_eq(place, end));
        if (!vm_any(vm_and(early, moves))) break;
        place = vf_select(vm_and(early, moves), vf_add(place, step), place);
    }
    for (;;) {
        const vmask late = vm_andnot(vf_ge(crossing(a, vf_add(place, in)), t), vf_eq(place, begin));
        if (!vm_any(vm_and(late, moves))) break;
        place = vf_select(vm_and(late, moves), vf_sub(place, step), place);
    }
    return place;
}

/* Puts each living lane into the first cell of its walk. l->r and l->alive are inputs. */
static inline void flat_start(packet *l, const cw_field *f) {
    const vray *r = &l->r;
    const vfloat zero = vf_set(0), one = vf_set(1);
    vcell *c = &l->c;
    c->i = first_cell(&r->x, r->from, f->nx, l->alive);
    c->j = first_cell(&r->y, r->from, f->ny, l->alive);
    l->x_out = vf_select(r->x.up, one, zero);
    l->y_out = vf_select(r->y.up, one, zero);
    const vfloat x_in = vf_sub(one, l->x_out), y_in = vf_sub(one, l->y_out);
    l->x_step = vf_sub(l->x_out, x_in);
    l->y_step = vf_sub(l->y_out, y_in);
    c->x_in = crossing(&r->x, vf_add(c->i, x_in));
    c->x_out = crossing(&r->x, vf_add(c->i, l->x_out));
    c->y_in = crossing(&r->y, vf_add(c->j, y_in));
    c->y_out = crossing(&r->y, vf_add(c->j, l->y_out));
    const vint row = vi_set((int32_t)f->stride), minus_row = vi_set(-(int32_t)f->stride);
    l->samples_x = vi_select(r->x.up, vi_set(1), vi_set(-1));
    l->samples_y = vi_select(r->y.up, row, minus_row);
    l->sample =
        vi_add(vi_mul(vi_from_vf(vf_select(l->alive, c->j, zero)), row), vi_from_vf(vf_select(l->alive, c->i, zero)));
}

/* Stores the finds of the lanes in now, in cell c. If first is set, no lane has had one yet, and h may be undefined. */
static inline void keep_hits(found_hits *h, bool first, vmask now, const vfind *find, const vcell *c) {
    const vfloat corner = vf_select(find->b, c->h01, c->h10);
    if (first) {
        *h = (found_hits){*find, c->i, c->j, c->h00, corner, c->h11};
        return;
    }
    h->find.t0 = vf_select(now, find->t0, h->find.t0);
    h->find.t1 = vf_select(now, find->t1, h->find.t1);
    h->find.b = vm_or(vm_and(now, find->b), vm_andnot(h->find.b, now));
    h->i = vf_select(now, c->i, h->i);
    h->j = vf_select(now, c->j, h->j);
    h->h00 = vf_select(now, c->h00, h->h00);
    h->corner = vf_select(now, corner, h->corner);
    h->h11 = vf_select(now, c->h11, h->h11);
}

/* Sets t0, t1 and samples of the cells; returns the living lanes whose cells pass the gate. */
CW_INLINE vmask flat_gate(packet *l, const cw_field *f) {
    const vray *r = &l->r;
    vcell *c = &l->c;
    clip_cell(c, r);
    vf_gather_pairs(f->z, l->sample, l->alive, &c->h00, &c->h10);
    vf_gather_pairs(f->z + f->stride, l->sample, l->alive, &c->h01, &c->h11);
    return vm_and(l->alive, cell_gate(r, c));
}

/* Tests the cells of some lanes. cleared: l->hit is defined before the first hit. */
CW_INLINE void flat_leaf(packet *l, vmask candidates, cw_leaf leaf, bool any, bool cleared) {
    vfind find;
    const vmask now = leaf == CW_LEAF_WATERTIGHT ? wt_cell(&l->r, &l->c, candidates, &find)
                                                 : mt_cell(&l->r, &l->c, candidates, &find);
    if (!any && vm_any(now)) keep_hits(&l->hit, !cleared && !vm_any(l->found), now, &find, &l->c);
    l->found = vm_or(l->found, now);
    l->alive = vm_andnot(l->alive, now);
}

/* Steps to the next cells. x_out is 1 going up, else 0, so x_out times the last column is the last border. */
CW_INLINE void flat_next(packet *l, const cw_field *f) {
    const vray *r = &l->r;
    vcell *c = &l->c;
    const vfloat end_x = vf_set((float)(f->nx - 1)), end_y = vf_set((float)(f->ny - 1));
    const vmask in_x = vf_le(c->x_out, c->y_out);
    const vmask leaves = vm_or(vm_and(in_x, vf_eq(vf_add(c->i, l->x_out), vf_mul(l->x_out, end_x))),
                               vm_andnot(vf_eq(vf_add(c->j, l->y_out), vf_mul(l->y_out, end_y)), in_x));
    const vmask ends = vf_gt(vf_min(c->x_out, c->y_out), r->until);
    l->alive = vm_andnot(l->alive, vm_or(leaves, ends));
    c->i = vf_select(in_x, vf_add(c->i, l->x_step), c->i);
    c->j = vf_select(in_x, c->j, vf_add(c->j, l->y_step));
    c->x_in = vf_select(in_x, c->x_out, c->x_in);
    c->y_in = vf_select(in_x, c->y_in, c->y_out);
    c->x_out = crossing(&r->x, vf_add(c->i, l->x_out));
    c->y_out = crossing(&r->y, vf_add(c->j, l->y_out));
    l->sample = vi_add(l->sample, vi_select(in_x, l->samples_x, l->samples_y));
}

/* Writes the answers of all W lanes: hits where found, else misses. start: of make_rays. */
static inline void packet_hits(const packet *l, const vstart *start, cw_hit *hits) {
    const vfloat infinite = vf_set(INFINITY), zero = vf_set(0), none = vf_set(-1);
    if (!vm_any(l->found)) {
        vf_store_hits(hits, infinite, zero, zero, none, none, vm_set(false));
        return;
    }
    const vray *r = &l->r;
    vhit h;
    if (r->moved) {
        h = refine_hits(start, &l->hit);
    } else {
        const vstart here = {.org = {r->x.org, r->y.org, r->oz}, .dir = {r->x.dir, r->y.dir, r->dz}};
        h = refine_hits(&here, &l->hit);
    }
    vf_store_hits(hits, vf_select(l->found, h.t, infinite), vf_select(l->found, h.u, zero),
                  vf_select(l->found, h.v, zero), vf_select(l->found, l->hit.i, none),
                  vf_select(l->found, l->hit.j, none), vm_and(l->found, l->hit.find.b));
}

#endif
