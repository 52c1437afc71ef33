/* SPDX-License-Identifier: Apache-2.0 */
/* Coherent rays share their walk. A group of 16 rays goes through the pyramid as one *fat ray*, an interval for each of
 * its numbers, judged against 16 children at once (children.inc.h); so opening a node costs the group little more than it
 * would cost one ray. At a block each ray decides for itself whether it is concerned; then the rays take the block's cells
 * one after another with the cell broadcast and the rays in lanes. Where they no longer want the same, the group falls
 * apart: the rays concerned are queued for the lane walk, which begins at that node (lane_walk.inc.h).
 *
 * Invariant: interval arithmetic in the gate's own operations, in their order, each of which is monotone in each of its
 * arguments, also after rounding. So the fat ray's interval encloses, without padding, what each ray computes for itself,
 * and no child that one of them must visit is skipped. Visits are front to back for all rays of one direction quadrant.
 *
 * After Reshetov, Soupikov and Hurley 2005 (one traversal finds where many rays begin), Boulos, Wald and Shirley 2006 and
 * Wald et al. 2006 (interval and frustum traversal of grids by packets). Not done: testing every ray against every child,
 * which costs a level as much for each vector of rays as the fat ray costs once. */

/* Intervals over the rays of a group, each number in all lanes. In mirrored coordinates, in which x and y grow along the
 * rays: centers times the sign of the direction, inverses without sign. */
typedef struct fat_axis {
    vfloat center_low, center_high, inverse_low, inverse_high;
} fat_axis;

typedef struct fat_ray {
    fat_axis x, y;
    vfloat oz_low, oz_high, dz_low, dz_high;
    vfloat from, until;
    vorder order;
    bool up_x, up_y;
} fat_ray;

/* True if the rays are alike enough to share a walk: one direction quadrant, directions within 1/8 of their length from
 * the first one's, origins within a few cells; with the hint CW_COHERENCE_HIGH the quadrant alone. What is left out is a
 * matter of speed alone. */
static inline bool coherent(const packet packets[PACKETS], unsigned rays, const cw_field *f, cw_coherence hint) {
    const unsigned first = (unsigned)__builtin_ctz(rays);
    const vray *one = &packets[first / W].r;
    float all[W];
    vf_store(all, one->x.dir);
    const vfloat dx = vf_set(all[first % W]);
    vf_store(all, one->y.dir);
    const vfloat dy = vf_set(all[first % W]);
    vf_store(all, one->dz);
    const vfloat dz = vf_set(all[first % W]);
    vf_store(all, one->x.org);
    const vfloat ox = vf_set(all[first % W]);
    vf_store(all, one->y.org);
    const vfloat oy = vf_set(all[first % W]);
    const vfloat length = vf_max(vf_max(vf_abs(dx), vf_abs(dy)), vf_abs(dz)), zero = vf_set(0);
    const bool any = hint == CW_COHERENCE_HIGH;
    const vfloat angle = any ? vf_set(INFINITY) : vf_mul(length, vf_set(0.125f));
    const vfloat apart = vf_set(any ? INFINITY : 16 + (float)(f->nx + f->ny) * (1.0f / 64));
    for (size_t p = 0; p < PACKETS; p++) {
        const vray *r = &packets[p].r;
        vmask m = vm_and(vf_le(vf_abs(vf_sub(r->x.dir, dx)), angle), vf_le(vf_abs(vf_sub(r->y.dir, dy)), angle));
        m = vm_and(m, vf_le(vf_abs(vf_sub(r->dz, dz)), angle));
        m = vm_and(m, vm_and(vf_le(vf_abs(vf_sub(r->x.org, ox)), apart), vf_le(vf_abs(vf_sub(r->y.org, oy)), apart)));
        m = vm_andnot(m, vm_or(vm_xor(r->x.up, vf_ge(dx, zero)), vm_xor(r->y.up, vf_ge(dy, zero))));
        m = vm_and(m, vf_ge(r->from, zero)); /* products of t and dz keep their order */
        const unsigned here = (rays >> (p * W)) & ((1u << W) - 1);
        if ((vm_bits(m) & here) != here) return false;
    }
    return true;
}

/* Numbers that intervals are made of; the highest of each is the lowest of the same turned round. */
enum { HULL_X, HULL_X_INVERSE, HULL_Y, HULL_Y_INVERSE, HULL_OZ, HULL_DZ, HULL_UNTIL, HULL_NUMBERS, HULL_FROM = 15 };

/* False if an inverse is infinite, which intervals cannot be made of. */
static inline bool fat_init(fat_ray *a, const packet packets[PACKETS], unsigned rays) {
    const vfloat minus = vf_set(-0.0f), infinite = vf_set(INFINITY);
    vfloat hull[16];
    for (size_t p = 0; p < PACKETS; p++) {
        const vray *r = &packets[p].r;
        const vmask m = vm_from_bits(rays >> (p * W));
        const vfloat number[HULL_NUMBERS] = {r->x.center, r->x.inverse, r->y.center, r->y.inverse,
                                             r->oz,       r->dz,        r->until};
        for (int k = 0; k < HULL_NUMBERS; k++) {
            const vfloat low = vf_select(m, number[k], infinite);
            const vfloat high = vf_select(m, vf_flip(number[k], minus), infinite);
            hull[k] = p == 0 ? low : vf_min(hull[k], low);
            hull[HULL_NUMBERS + k] = p == 0 ? high : vf_min(hull[HULL_NUMBERS + k], high);
        }
        const vfloat from = vf_select(m, r->from, infinite);
        hull[HULL_FROM] = p == 0 ? from : vf_min(hull[HULL_FROM], from);
    }
    hull[2 * HULL_NUMBERS] = infinite;
    float low[16];
    vf_lowest_of_each(hull, low);
    const float *minus_high = low + HULL_NUMBERS;

    const unsigned first = (unsigned)__builtin_ctz(rays);
    a->up_x = vm_bits(packets[first / W].r.x.up) >> (first % W) & 1;
    a->up_y = vm_bits(packets[first / W].r.y.up) >> (first % W) & 1;
    a->order = vorder_make(a->up_x, a->up_y);
    a->oz_low = vf_set(low[HULL_OZ]);
    a->oz_high = vf_set(-minus_high[HULL_OZ]);
    a->dz_low = vf_set(low[HULL_DZ]);
    a->dz_high = vf_set(-minus_high[HULL_DZ]);
    a->from = vf_set(low[HULL_FROM]);
    a->until = vf_set(-minus_high[HULL_UNTIL]);
    fat_axis *const axis[2] = {&a->x, &a->y};
    for (int c = 0; c < 2; c++) { /* mirrored where rays go down */
        const bool up = c == 0 ? a->up_x : a->up_y;
        const float *l = up ? low + 2 * c : minus_high + 2 * c, *h = up ? minus_high + 2 * c : low + 2 * c;
        axis[c]->center_low = vf_set(l[0]);
        axis[c]->center_high = vf_set(-h[0]);
        axis[c]->inverse_low = vf_set(l[1]);
        axis[c]->inverse_high = vf_set(-h[1]);
    }
    const float steepest_x = fmaxf(-low[HULL_X_INVERSE], -minus_high[HULL_X_INVERSE]);
    const float steepest_y = fmaxf(-low[HULL_Y_INVERSE], -minus_high[HULL_Y_INVERSE]);
    return steepest_x <= FLT_MAX && steepest_y <= FLT_MAX;
}

/* Earliest entry into and latest exit from the place between two borders, in mirrored coordinates. */
static inline vfloat fat_in(const fat_axis *a, vfloat border) {
    const vfloat far = vf_sub(border, a->center_high);
    return vf_min(vf_mul(far, a->inverse_low), vf_mul(far, a->inverse_high));
}
static inline vfloat fat_out(const fat_axis *a, vfloat border) {
    const vfloat far = vf_sub(border, a->center_low);
    return vf_max(vf_mul(far, a->inverse_low), vf_mul(far, a->inverse_high));
}

/* Of the 16 places of the given side at packet k, those in which some ray may meet heights in [low, high]. start_x and
 * start_y are the mirrored borders at which walk order begins. */
static inline vmask fat_meets(const fat_ray *a, vfloat start_x, vfloat start_y, vfloat side, size_t k, vfloat low,
                              vfloat high) {
    const vfloat x = vf_add(start_x, vf_mul(vf_load(lane_x + k * W), side));
    const vfloat y = vf_add(start_y, vf_mul(vf_load(lane_y + k * W), side));
    const vfloat t0 = vf_max(vf_max(fat_in(&a->x, x), fat_in(&a->y, y)), a->from);
    const vfloat t1 = vf_min(vf_min(fat_out(&a->x, vf_add(x, side)), fat_out(&a->y, vf_add(y, side))), a->until);
    const vfloat bottom = vf_min(vf_mul(t0, a->dz_low), vf_mul(t1, a->dz_low));
    const vfloat top = vf_max(vf_mul(t0, a->dz_high), vf_mul(t1, a->dz_high));
    const vmask meets = vm_and(vf_ge(top, vf_sub(low, a->oz_high)), vf_le(bottom, vf_sub(high, a->oz_low)));
    return vm_and(vf_le(t0, t1), meets);
}

static inline vfloat mirrored_start(bool up, int32_t place, float side) {
    return vf_set(up ? (float)place * side : -((float)place + 4) * side);
}

static inline unsigned fat_open(const fat_ray *a, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    const vfloat start_x = mirrored_start(a->up_x, 4 * x, l->side), start_y = mirrored_start(a->up_y, 4 * y, l->side);
    const float *row = first_row(&a->order, brick, 4);
    const ptrdiff_t step = row_step(&a->order, 4);
    unsigned mask = 0;
    for (size_t k = 0; k < PACKETS; k++)
        mask |= vm_bits(fat_meets(a, start_x, start_y, vf_set(l->side), k, vf_load_block(row, step, &a->order, k),
                                  vf_load_block(row + 16, step, &a->order, k)))
                << (k * W);
    return mask;
}

/* The cells of a block that some ray may meet. */
static inline unsigned fat_cells(const fat_ray *a, const block_samples *s, int32_t x, int32_t y) {
    const vfloat start_x = mirrored_start(a->up_x, 4 * x, 1), start_y = mirrored_start(a->up_y, 4 * y, 1);
    const float *row = first_row(&a->order, s->z, s->stride);
    const ptrdiff_t step = row_step(&a->order, s->stride);
    unsigned mask = 0;
    for (size_t k = 0; k < PACKETS; k++) {
        vcell c;
        c.h00 = vf_load_block(row, step, &a->order, k);
        c.h10 = vf_load_block(row + 1, step, &a->order, k);
        c.h01 = vf_load_block(row + s->stride, step, &a->order, k);
        c.h11 = vf_load_block(row + s->stride + 1, step, &a->order, k);
        mask |= vm_bits(fat_meets(a, start_x, start_y, vf_set(1), k, cell_low(&c), cell_high(&c))) << (k * W);
    }
    return mask;
}

/* Crossings of the place with lowest corner (x, y), a ray a lane. */
static inline void place_crossings(const vray *r, bool up_x, bool up_y, float x, float y, float side, vcell *c) {
    c->x_in = crossing(&r->x, vf_set(up_x ? x : x + side));
    c->x_out = crossing(&r->x, vf_set(up_x ? x + side : x));
    c->y_in = crossing(&r->y, vf_set(up_y ? y : y + side));
    c->y_out = crossing(&r->y, vf_set(up_y ? y + side : y));
}

/* Those of the rays that may meet something in the block. */
static inline unsigned block_rays(const fat_ray *a, const packet packets[PACKETS], unsigned rays,
                                  const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *n =
        l->bricks + ((size_t)(y >> 2) * (size_t)l->across + (size_t)(x >> 2)) * BRICK_FLOATS + ((y & 3) << 2 | (x & 3));
    unsigned concerned = 0;
    for (size_t p = 0; p < PACKETS; p++) {
        if (!(rays >> (p * W) & ((1u << W) - 1))) continue;
        const vray *r = &packets[p].r;
        vcell c;
        place_crossings(r, a->up_x, a->up_y, (float)(4 * x), (float)(4 * y), 4, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        concerned |= vm_bits(vm_and(vf_le(t0, t1), meets(r, t0, t1, vf_set(n[0]), vf_set(n[16])))) << (p * W);
    }
    return concerned & rays;
}

/* One cell against the rays; the rays that hit. */
CW_INLINE unsigned shared_cell(const fat_ray *a, packet packets[PACKETS], unsigned rays, const block_samples *s,
                               int32_t i, int32_t j, cw_leaf leaf, bool any) {
    const float *z = s->z + (size_t)(j & 3) * s->stride + (i & 3);
    unsigned found = 0;
    count_step(COUNT_SHARED_CELL, rays);
    for (size_t p = 0; p < PACKETS; p++) {
        const vmask among = vm_from_bits(rays >> (p * W));
        if (!vm_any(among)) continue;
        packet *l = &packets[p];
        const vray *r = &l->r;
        vcell c;
        place_crossings(r, a->up_x, a->up_y, (float)i, (float)j, 1, &c);
        c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->t0);
        c.t1 = vf_min(vf_min(c.x_out, c.y_out), r->t1);
        c.h00 = vf_set(z[0]);
        c.h10 = vf_set(z[1]);
        c.h01 = vf_set(z[s->stride]);
        c.h11 = vf_set(z[s->stride + 1]);
        const vmask gate = vm_and(among, cell_gate(r, &c));
        if (!vm_any(gate)) continue;
        c.i = vf_set((float)i);
        c.j = vf_set((float)j);
        vfind find;
        const vmask now = leaf_test(leaf, r, &c, gate, any, &find);
        if (!any && vm_any(now)) keep_hits(&l->hit, now, &find, &c);
        l->found = vm_or(l->found, now);
        found |= vm_bits(now) << (p * W);
    }
    return found;
}

/* A group falls apart at a block where going on together would test this many times more cells, counted once for each
 * vector of rays, than there are rays; and at a node of which more children than this have to be visited. Least
 * instructions for primary and shadow rays on 65² to 4097² samples among 2, 4, 8 and 4, 5, 6, 8, 16 (callgrind). Without
 * the second, shadow rays on 4097² take 2.5 times as many. */
enum { FALL_APART = 2, CHILDREN_AT_MOST = 5 };

/* Queues those of the rays that cross the node of the given level of the pyramid and place; the rest of their walk is
 * theirs alone. Returns them. */
static inline unsigned fall_apart(const fat_ray *a, const packet packets[PACKETS], unsigned rays, const cw_field *f,
                                  int level, int32_t x, int32_t y, cw_leaf leaf, lane_queue *queue,
                                  size_t first_packet) {
    unsigned apart = 0;
    const cw_pyramid_level *l = &f->pyramid->level[level];
    for (size_t p = 0; p < PACKETS; p++) {
        const unsigned among = rays >> (p * W) & ((1u << W) - 1);
        if (among == 0) continue;
        const vray *r = &packets[p].r;
        vcell c;
        place_crossings(r, a->up_x, a->up_y, (float)x * l->side, (float)y * l->side, l->side, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const unsigned now = vm_bits(vf_le(t0, t1)) & among;
        if (now == 0) continue;
        mirror_packet(queue, first_packet, p, r, f, leaf);
        enqueue(queue, first_packet + p, now, t0, level + 1);
        apart |= now << (p * W);
    }
    count_step(COUNT_APART, apart);
    return apart;
}

/* First hits of the rays in block (x, y); the rays that are done with, by a hit or by being queued. */
CW_INLINE unsigned shared_block(const fat_ray *a, packet packets[PACKETS], unsigned rays, const cw_field *f, int32_t x,
                                int32_t y, cw_leaf leaf, bool any, lane_queue *queue, size_t first_packet) {
    count_step(COUNT_SHARED_BLOCK, rays);
    block_samples s;
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    unsigned cells = fat_cells(a, &s, x, y), done = 0;
    if (FALL_APART * __builtin_popcount(rays) <= __builtin_popcount(cells) * (int)PACKETS)
        return fall_apart(a, packets, rays, f, 0, x, y, leaf, queue, first_packet);
    for (; cells != 0 && rays != 0; cells &= cells - 1) {
        const int32_t place = __builtin_ctz(cells);
        const unsigned now = shared_cell(a, packets, rays, &s, 4 * x + ((place & 3) ^ a->order.flip_x),
                                         4 * y + ((place >> 2) ^ a->order.flip_y), leaf, any);
        rays &= ~now;
        done |= now;
    }
    return done;
}

/* Walks the rays together, to their ends or until they fall apart. */
CW_INLINE void shared_walk(const fat_ray *a, packet packets[PACKETS], unsigned rays, const cw_field *f, cw_leaf leaf,
                           bool any, lane_queue *queue, size_t first_packet) {
    const struct cw_pyramid *p = f->pyramid;
    struct {
        unsigned mask;
        int32_t x, y;
    } todo[PYRAMID_LEVELS_MAX];
    const int top = p->levels - 1;
    int level = top;
    int32_t x = 0, y = 0;
    count_step(COUNT_SHARED, rays);
    count_step(COUNT_SHARED_NODE, rays);
    unsigned mask = fat_open(a, &p->level[top], 0, 0);
    for (;;) {
        while (mask == 0) {
            if (level == top) return;
            level++;
            mask = todo[level].mask;
            x = todo[level].x;
            y = todo[level].y;
        }
        const int32_t place = __builtin_ctz(mask);
        mask &= mask - 1;
        const int32_t cx = 4 * x + ((place & 3) ^ a->order.flip_x), cy = 4 * y + ((place >> 2) ^ a->order.flip_y);
        if (level == 0) {
            const unsigned concerned = block_rays(a, packets, rays, &p->level[0], cx, cy);
            if (concerned == 0) continue;
            rays &= ~shared_block(a, packets, concerned, f, cx, cy, leaf, any, queue, first_packet);
            if (rays == 0) return;
            continue;
        }
        count_step(COUNT_SHARED_NODE, rays);
        const unsigned children = fat_open(a, &p->level[level - 1], cx, cy);
        if (__builtin_popcount(children) > CHILDREN_AT_MOST) {
            rays &= ~fall_apart(a, packets, rays, f, level, cx, cy, leaf, queue, first_packet);
            if (rays == 0) return;
            continue;
        }
        todo[level].mask = mask;
        todo[level].x = x;
        todo[level].y = y;
        level--;
        x = cx;
        y = cy;
        mask = children;
    }
}
