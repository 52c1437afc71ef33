/* SPDX-License-Identifier: Apache-2.0 */
/* The flat walk in packets: W rays, each in its own cell, step together. Amanatides and Woo 1987 with crossings computed
 * from border coordinates (see src/scalar/cell.c, which this repeats lane by lane). A stub includes a vocabulary and then
 * this body.
 *
 * Invariant: a lane's cell is on its walk, and x_in … y_out are its four crossings. Lanes share instructions, not
 * cells, and what a lane computes depends on its ray alone; so packets of any width agree in every bit.
 *
 * Rejected: carrying the two samples that the new cell shares with the old one, to gather two instead of four. A lane
 * steps in x or in y, so two selects a sample replace two gathers whose lines are in L1 already. */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

/* The first cell along an axis that is left at t or later: the place at t gives a guess, the crossings decide. The loops
 * end after one turn unless the origin is so far off that neighbouring floats are cells apart. */
static inline vfloat first_cell(const vaxis *a, vfloat t, size_t samples, vmask alive) {
    const vfloat zero = vf_set(0), one = vf_set(1), last = vf_set((float)(samples - 1) - 1);
    const vfloat out = vf_select(a->up, one, zero), in = vf_sub(one, out);
    const vfloat begin = vf_select(a->up, zero, last), end = vf_sub(last, begin);
    vfloat place = vf_floor(vf_add(a->org, vf_mul(t, a->dir)));
    place = vf_max(vf_min(last, place), zero); /* in this order -0 becomes 0, as if it had been an integer */
    const vmask stays = vf_eq(a->dir, zero);
    place = vf_select(stays, vf_sub(a->center, vf_set(0.5f)), place);
    const vmask moves = vm_andnot(alive, stays);
    for (;;) {
        const vmask early = vm_andnot(vf_lt(crossing(a, vf_add(place, out)), t), vf_eq(place, end));
        if (!vm_any(vm_and(early, moves))) break;
        place = vf_select(vm_and(early, moves), vf_add(place, a->step), place);
    }
    for (;;) {
        const vmask late = vm_andnot(vf_ge(crossing(a, vf_add(place, in)), t), vf_eq(place, begin));
        if (!vm_any(vm_and(late, moves))) break;
        place = vf_select(vm_and(late, moves), vf_sub(place, a->step), place);
    }
    return place;
}

/* Lanes that pass the gate; gathers the samples of the living. */
static inline vmask gate(vcell *c, const vray *r, const cw_field *f, vint sample, vmask alive) {
    c->t0 = vf_max(vf_max(c->x_in, c->y_in), r->begin);
    c->t1 = vf_min(vf_min(c->x_out, c->y_out), r->end);
    c->h00 = vf_gather(f->z, sample, alive);
    c->h10 = vf_gather(f->z + 1, sample, alive);
    c->h01 = vf_gather(f->z + f->stride, sample, alive);
    c->h11 = vf_gather(f->z + f->stride + 1, sample, alive);
    return vm_and(alive, cell_gate(r, c));
}

/* Walks W rays to their ends; the lanes that hit, with where. */
static inline vmask walk(const cw_field *f, const cw_ray *rays, vmask lanes, cw_leaf leaf, bool any, vhit *hit,
                         vint *sample_hit) {
    vray r;
    vmask alive = vm_and(lanes, make_rays(&r, f, rays));
    vmask found = vm_andnot(lanes, lanes);
    if (!vm_any(alive)) return found;

    vcell c;
    c.i = first_cell(&r.x, r.begin, f->nx, alive);
    c.j = first_cell(&r.y, r.begin, f->ny, alive);
    const vfloat zero = vf_set(0), one = vf_set(1);
    const vfloat x_in = vf_select(r.x.up, zero, one), x_out = vf_sub(one, x_in);
    const vfloat y_in = vf_select(r.y.up, zero, one), y_out = vf_sub(one, y_in);
    c.x_in = crossing(&r.x, vf_add(c.i, x_in));
    c.x_out = crossing(&r.x, vf_add(c.i, x_out));
    c.y_in = crossing(&r.y, vf_add(c.j, y_in));
    c.y_out = crossing(&r.y, vf_add(c.j, y_out));

    const vint row = vi_set((int32_t)f->stride), minus_row = vi_set(-(int32_t)f->stride);
    const vint step_x = vi_select(r.x.up, vi_set(1), vi_set(-1)), step_y = vi_select(r.y.up, row, minus_row);
    vint sample = vi_add(vi_mul(vi_from_vf(vf_select(alive, c.j, zero)), row), vi_from_vf(vf_select(alive, c.i, zero)));
    while (vm_any(alive)) { /* at most nx + ny turns: a lane goes one way on each axis and leaves the field */
        const vmask candidates = gate(&c, &r, f, sample, alive);
        if (vm_any(candidates)) {
            vhit h;
            const vmask now =
                leaf == CW_LEAF_WATERTIGHT ? wt_cell(&r, &c, candidates, &h) : mt_cell(&r, &c, candidates, &h);
            if (!any) {
                hit->t = vf_select(now, h.t, hit->t);
                hit->u = vf_select(now, h.u, hit->u);
                hit->v = vf_select(now, h.v, hit->v);
                hit->b = vm_or(vm_and(now, h.b), vm_andnot(hit->b, now));
                *sample_hit = vi_select(now, sample, *sample_hit);
            }
            found = vm_or(found, now);
            alive = vm_andnot(alive, now);
        }
        const vmask in_x = vf_le(c.x_out, c.y_out);
        alive = vm_andnot(alive, vf_gt(vf_min(c.x_out, c.y_out), r.end));
        alive = vm_andnot(alive, vm_or(vm_and(in_x, vf_eq(vf_add(c.i, x_out), r.x.last)),
                                       vm_andnot(vf_eq(vf_add(c.j, y_out), r.y.last), in_x)));
        c.i = vf_select(in_x, vf_add(c.i, r.x.step), c.i);
        c.j = vf_select(in_x, c.j, vf_add(c.j, r.y.step));
        c.x_in = vf_select(in_x, c.x_out, c.x_in);
        c.y_in = vf_select(in_x, c.y_in, c.y_out);
        c.x_out = crossing(&r.x, vf_add(c.i, x_out));
        c.y_out = crossing(&r.y, vf_add(c.j, y_out));
        sample = vi_add(sample, vi_select(in_x, step_x, step_y));
    }
    return found;
}

static inline void packet_closest(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, cw_leaf leaf) {
    cw_ray tail[W];
    for (size_t k = 0; k < n; k += W) {
        const size_t lanes = n - k < W ? n - k : W;
        const cw_ray *from = rays + k;
        if (lanes < W) { /* lanes beyond the array get a ray of their own to read */
            for (size_t l = 0; l < W; l++) tail[l] = from[l < lanes ? l : 0];
            from = tail;
        }
        const vfloat zero = vf_set(0);
        vhit hit = {.t = zero, .u = zero, .v = zero, .b = vf_lt(zero, zero)};
        vint sample = vi_set(0);
        const unsigned found = vm_bits(walk(f, from, vm_first(lanes), leaf, false, &hit, &sample));
        const unsigned in_b = vm_bits(hit.b);
        float t[W], u[W], v[W];
        int32_t at[W];
        vf_store(t, hit.t);
        vf_store(u, hit.u);
        vf_store(v, hit.v);
        vi_store(at, sample);
        for (size_t l = 0; l < lanes; l++) {
            const int32_t stride = (int32_t)f->stride;
            if (found >> l & 1)
                hits[k + l] = (cw_hit){t[l], u[l], v[l], at[l] % stride, at[l] / stride, in_b >> l & 1};
            else
                hits[k + l] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
        }
    }
}

static inline void packet_any(const cw_field *f, const cw_ray *rays, size_t n, uint8_t *occluded, cw_leaf leaf) {
    cw_ray tail[W];
    for (size_t k = 0; k < n; k += W) {
        const size_t lanes = n - k < W ? n - k : W;
        const cw_ray *from = rays + k;
        if (lanes < W) {
            for (size_t l = 0; l < W; l++) tail[l] = from[l < lanes ? l : 0];
            from = tail;
        }
        vhit hit;
        vint sample;
        const unsigned found = vm_bits(walk(f, from, vm_first(lanes), leaf, true, &hit, &sample));
        for (size_t l = 0; l < lanes; l++) occluded[k + l] = found >> l & 1;
    }
}
