/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test on W cells at once, a ray each; operation by operation as in src/scalar/watertight.h, which
 * says how it works and why. Lanes differ in the borders by which they enter and leave, so each choice is a select. */

static inline vfloat wt_edge(vfloat a, vfloat b, vfloat f) {
    const vfloat z = vf_add(a, vf_mul(f, vf_sub(b, a)));
    return vf_max(vf_min(a, b), vf_min(vf_max(a, b), z));
}

static inline vfloat wt_within(const vaxis *a, vfloat t, vfloat low) {
    const vfloat x = vf_sub(vf_add(a->org, vf_mul(t, a->dir)), low);
    return vf_max(vf_set(0), vf_min(vf_set(1), x));
}

/* Height difference on the x border (where x_border) or y border, on its high side (where high_side) or low one. */
static inline vfloat wt_border(const vray *r, const vcell *c, vfloat t, vmask x_border, vmask high_side) {
    const vfloat org = vf_select(x_border, r->y.org, r->x.org), dir = vf_select(x_border, r->y.dir, r->x.dir);
    const vfloat x = vf_sub(vf_add(org, vf_mul(t, dir)), vf_select(x_border, c->j, c->i));
    const vfloat along = vf_max(vf_set(0), vf_min(vf_set(1), x));
    /* The edge's first sample lies at the low end of the axis along the border, the second at the high end. */
    const vfloat a = vf_select(high_side, vf_select(x_border, c->h10, c->h01), c->h00);
    const vfloat b = vf_select(high_side, c->h11, vf_select(x_border, c->h01, c->h10));
    return vf_sub(height(r, t), wt_edge(a, b, along));
}

static inline vfloat wt_inside(const vray *r, const vcell *c, vfloat t, vmask *in_b) {
    const vfloat x = wt_within(&r->x, t, c->i), y = wt_within(&r->y, t, c->j);
    *in_b = vf_gt(y, x);
    const vfloat corner = vf_select(*in_b, c->h01, c->h10);
    const vfloat longer = vf_max(x, y), shorter = vf_min(x, y);
    const vfloat z =
        vf_add(vf_add(c->h00, vf_mul(longer, vf_sub(corner, c->h00))), vf_mul(shorter, vf_sub(c->h11, corner)));
    const vfloat low = vf_min(c->h00, vf_min(corner, c->h11)), high = vf_max(c->h00, vf_max(corner, c->h11));
    return vf_sub(height(r, t), vf_max(low, vf_min(high, z)));
}

static inline vfloat wt_root(vfloat ta, vfloat da, vfloat tb, vfloat db) {
    const vfloat zero = vf_set(0);
    const vfloat s = vf_select(vf_eq(da, zero), zero, vf_div(da, vf_sub(da, db)));
    return vf_min(tb, vf_add(ta, vf_mul(vf_sub(tb, ta), s)));
}

static inline vmask wt_between(vfloat da, vfloat db) {
    const vfloat zero = vf_set(0);
    return vm_or(vm_and(vf_ge(da, zero), vf_le(db, zero)), vm_and(vf_le(da, zero), vf_ge(db, zero)));
}

/* Lanes among which the cell is hit; any says that no one wants to know where. */
static inline vmask wt_cell(const vray *r, const vcell *c, vmask among, bool any, vhit *hit) {
    const vmask enter_x = vf_gt(c->x_in, c->y_in), leave_x = vf_le(c->x_out, c->y_out);
    /* Low side: entered going up, left going down. Triangle B is at the low x and the high y border. */
    const vmask up_in = vm_or(vm_and(enter_x, r->x.up), vm_andnot(r->y.up, enter_x));
    const vmask up_out = vm_or(vm_and(leave_x, r->x.up), vm_andnot(r->y.up, leave_x));
    vmask in_b = vm_not(vm_xor(enter_x, up_in)), out_b = vm_xor(leave_x, up_out);
    const vfloat in = vf_max(c->x_in, c->y_in), out = vf_min(c->x_out, c->y_out);
    const vmask at_in = vf_ge(in, r->begin), at_out = vf_le(out, r->end);
    vfloat da = wt_border(r, c, c->t0, enter_x, vm_not(up_in));
    vfloat db = wt_border(r, c, c->t1, leave_x, up_out);
    if (vm_any(vm_andnot(among, vm_and(at_in, at_out)))) { /* ranges that start or end inside a cell are rare */
        vmask start_b, stop_b;
        const vfloat start = wt_inside(r, c, c->t0, &start_b), stop = wt_inside(r, c, c->t1, &stop_b);
        da = vf_select(at_in, da, start);
        db = vf_select(at_out, db, stop);
        in_b = vm_or(vm_and(at_in, in_b), vm_andnot(start_b, at_in));
        out_b = vm_or(vm_and(at_out, out_b), vm_andnot(stop_b, at_out));
    }
    const vmask crosses = vm_xor(in_b, out_b);
    const vfloat k = vf_sub(c->i, c->j);
    vfloat td = vf_div(vf_sub(k, vf_sub(r->x.org, r->y.org)), vf_sub(r->x.dir, r->y.dir));
    td = vf_max(c->t0, vf_min(td, c->t1));
    const vfloat dd = vf_sub(height(r, td), wt_edge(c->h00, c->h11, wt_within(&r->x, td, c->i)));
    /* Up to the diagonal, or beyond it; without a crossing the one stretch from border to border. */
    const vmask first = vm_and(crosses, wt_between(da, dd)), second = vm_andnot(crosses, first);
    const vfloat ta = vf_select(second, td, c->t0), d0 = vf_select(second, dd, da);
    const vfloat tb = vf_select(first, td, c->t1), d1 = vf_select(first, dd, db);
    const vmask found = vm_and(among, vm_or(first, wt_between(d0, d1)));
    if (any || !vm_any(found)) {
        const vfloat none = vf_set(0);
        *hit = (vhit){none, none, none, vm_set(false)};
        return found;
    }
    hit->b = vm_or(vm_andnot(in_b, second), vm_and(second, out_b));
    hit->t = wt_root(ta, d0, tb, d1);
    const vfloat x = wt_within(&r->x, hit->t, c->i), y = wt_within(&r->y, hit->t, c->j);
    const vfloat zero = vf_set(0), along = vf_select(hit->b, vf_sub(y, x), vf_sub(x, y));
    hit->u = vf_select(hit->b, x, vf_max(zero, along));
    hit->v = vf_select(hit->b, vf_max(zero, along), y);
    return found;
}
