/* SPDX-License-Identifier: Apache-2.0 */
/* One ray against the 16 children of a node, or the 16 cells of a block, at once: lanes are places, the ray is broadcast.
 *
 * Lane 4 y + x is the child in column x and row y of walk order (vorder), so the lowest set bit of a mask of children is
 * always the nearest: a ray goes through the 4 × 4 children along a monotone staircase. Descending takes the lowest bit,
 * coming back up needs the rest of the mask, and that is all the state a level has.
 *
 * Invariant: a child is skipped only if every cell in it fails the gate of src/scalar/strict.h. The comparisons are the
 * gate's own, on wider intervals of the same monotone functions, so they need no padding and skip nothing by rounding. */

enum { CHILDREN = 16, PARTS = CHILDREN / W };

/* What the lanes of each part stand for: column and row in walk order. */
static const float lane_x[CHILDREN] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
static const float lane_y[CHILDREN] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};

/* One ray in all lanes, and what its direction quadrant decides. */
typedef struct wide_ray {
    vray r;
    vorder order;
    float step_x, step_y;     /* to the next column and row in walk order: 1 or -1 */
    int32_t first_x, first_y; /* where walk order begins in a row of 4: 0 or 4 */
} wide_ray;

/* First row, in walk order, of a block with rows stride floats apart; and the way to the next. */
static inline const float *first_row(const vorder *o, const float *block, size_t stride) {
    return block + (size_t)o->flip_y * stride;
}
static inline ptrdiff_t row_step(const vorder *o, size_t stride) {
    return o->flip_y == 0 ? (ptrdiff_t)stride : -(ptrdiff_t)stride;
}

/* The sides in walk order of 4 places along an axis, each side cells long, of which the first begins at start. */
static inline void places(const vaxis *a, vfloat start, vfloat step, vfloat lane, vfloat *border_in, vfloat *in,
                          vfloat *out) {
    *border_in = vf_add(start, vf_mul(lane, step));
    *in = crossing(a, *border_in);
    *out = crossing(a, vf_add(*border_in, step));
}

/* The children of brick (x, y) that the ray may hit something in. */
static inline unsigned wide_open(const wide_ray *w, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const vray *r = &w->r;
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    const vfloat start_x = vf_set((float)(4 * x + w->first_x) * l->side);
    const vfloat start_y = vf_set((float)(4 * y + w->first_y) * l->side);
    const float *row = first_row(&w->order, brick, 4);
    const ptrdiff_t step = row_step(&w->order, 4);
    const vfloat step_x = vf_set(w->step_x * l->side), step_y = vf_set(w->step_y * l->side);
    unsigned mask = 0;
    for (size_t k = 0; k < PARTS; k++) {
        vfloat border, x_in, x_out, y_in, y_out;
        places(&r->x, start_x, step_x, vf_load(lane_x + k * W), &border, &x_in, &x_out);
        places(&r->y, start_y, step_y, vf_load(lane_y + k * W), &border, &y_in, &y_out);
        const vfloat t0 = vf_max(vf_max(x_in, y_in), r->from), t1 = vf_min(vf_min(x_out, y_out), r->until);
        const vfloat low = vf_load_block(row, step, &w->order, k), high = vf_load_block(row + 16, step, &w->order, k);
        mask |= vm_bits(vm_and(vf_le(t0, t1), meets(r, t0, t1, low, high))) << (k * W);
    }
    return mask;
}

/* The block's 5 × 5 samples, in place or, where the block sticks out of the field, copied with holes outside. */
typedef struct block_samples {
    const float *z;
    size_t stride;
    float copy[5 * 5];
} block_samples;

static inline void load_samples(block_samples *s, const cw_field *f, size_t i, size_t j) {
    s->z = f->z + j * f->stride + i;
    s->stride = f->stride;
    if (i + 4 < f->nx && j + 4 < f->ny) return;
    for (size_t y = 0; y < 5; y++)
        for (size_t x = 0; x < 5; x++)
            s->copy[5 * y + x] = i + x < f->nx && j + y < f->ny ? s->z[y * s->stride + x] : NAN;
    s->z = s->copy;
    s->stride = 5;
}

/* First hit in the block of 4 × 4 cells with lowest cell (4 x, 4 y). */
CW_INLINE bool wide_block(const wide_ray *w, const cw_field *f, int32_t x, int32_t y, cw_leaf leaf, bool any,
                          cw_hit *hit) {
    const vray *r = &w->r;
    block_samples s;
    count_step(COUNT_WIDE, 1);
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    const float *row = first_row(&w->order, s.z, s.stride);
    const ptrdiff_t step = row_step(&w->order, s.stride);
    const vfloat start_x = vf_set((float)(4 * x + w->first_x)), start_y = vf_set((float)(4 * y + w->first_y));
    const vfloat step_x = vf_set(w->step_x), step_y = vf_set(w->step_y);
    const vfloat below_x = vf_set((float)w->first_x * 0.25f), below_y = vf_set((float)w->first_y * 0.25f);
    for (size_t k = 0; k < PARTS; k++) {
        vcell c;
        vfloat border_x, border_y;
        places(&r->x, start_x, step_x, vf_load(lane_x + k * W), &border_x, &c.x_in, &c.x_out);
        places(&r->y, start_y, step_y, vf_load(lane_y + k * W), &border_y, &c.y_in, &c.y_out);
        c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->begin);
        c.t1 = vf_min(vf_min(c.x_out, c.y_out), r->end);
        c.h00 = vf_load_block(row, step, &w->order, k);
        c.h10 = vf_load_block(row + 1, step, &w->order, k);
        c.h01 = vf_load_block(row + s.stride, step, &w->order, k);
        c.h11 = vf_load_block(row + s.stride + 1, step, &w->order, k);
        const vmask gate = cell_gate(r, &c);
        if (!vm_any(gate)) continue;
        count_lanes(COUNT_LEAF, gate);
        c.i = vf_sub(border_x, below_x);
        c.j = vf_sub(border_y, below_y);
        vhit h;
        const unsigned found =
            vm_bits(leaf == CW_LEAF_WATERTIGHT ? wt_cell(r, &c, gate, any, &h) : mt_cell(r, &c, gate, &h));
        if (found == 0) continue;
        if (any) return true;
        const unsigned lane = (unsigned)__builtin_ctz(found), place = (unsigned)(k * W) + lane;
        float t[W], u[W], v[W];
        vf_store(t, h.t);
        vf_store(u, h.u);
        vf_store(v, h.v);
        *hit = (cw_hit){
            .t = t[lane],
            .u = u[lane],
            .v = v[lane],
            .i = 4 * x + ((int32_t)(place & 3) ^ w->order.flip_x),
            .j = 4 * y + ((int32_t)(place >> 2) ^ w->order.flip_y),
            .triangle = vm_bits(h.b) >> lane & 1,
        };
        return true;
    }
    return false;
}
