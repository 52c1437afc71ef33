/* SPDX-License-Identifier: Apache-2.0 */
/* The shared walk of coherent rays. A tile of 64 rays goes through the pyramid as one *fat ray*, an interval for
 * each of their numbers, tested against 16 children at once (children.inc.h). So opening a node costs 64 rays little
 * more than one. At a block each ray is tested against the block's bounds. Then each packet takes the block's cells
 * one after another, with the cell broadcast and the rays in lanes. Where the rays diverge, the tile falls apart
 * into groups of 16, which go on from that node with a fat ray each. Where a group falls apart, its rays that cross
 * the node are queued for the lane walk, which begins at that node (lane_walk.inc.h).
 *
 * Invariant: the fat ray uses interval arithmetic in the gate's own operations, in their order. Each of them is
 * monotone in each of its arguments, also after rounding. So its intervals enclose the numbers of each ray without
 * padding, and no child that one of the rays must visit is skipped. Visits are front to back for all rays of one
 * direction quadrant.
 *
 * After Reshetov, Soupikov and Hurley 2005 (one traversal finds where smaller beams begin), Boulos, Wald and Shirley
 * 2006 and Wald et al. 2006 (interval and frustum traversal of grids by packets). Rejected: testing every ray
 * against every child. At each level that costs as much for each vector of rays as the fat ray costs once. */

/* Rays of a tile, a bit each; the lanes of packet p are bits p W and on. */
typedef uint64_t ray_set;
/* Its packets. */
typedef uint64_t packet_set;
enum { TILE = 64, PACKETS = TILE / W, GROUP = 16, GROUPS = TILE / GROUP };

/* For fewer rays than this, making a fat ray takes longer than it saves. */
enum { SHARE_AT_LEAST = 4 };

/* Greatest distance in cells between origins of a tile that shares a walk, along each axis. With more, shadow rays lose
 * time, as the tile falls apart at once (papers/walks.md). */
enum { TILE_CELLS = 4 };

static inline unsigned packet_bits(ray_set rays, size_t p) {
    return (unsigned)(rays >> (p * W)) & (unsigned)(((ray_set)1 << W) - 1);
}
static inline ray_set group_bits(ray_set rays, size_t g) { return rays & (ray_set)0xffff << (g * GROUP); }

/* Returns the first packet with some of the rays, and removes its rays from them. */
static inline size_t next_packet(ray_set *rays) {
    const size_t p = (size_t)__builtin_ctzll(*rays) / W;
    *rays &= ~((((ray_set)1 << W) - 1) << (p * W));
    return p;
}
static inline int packets_of(ray_set rays) {
    int n = 0;
    for (; rays != 0; n++) (void)next_packet(&rays);
    return n;
}

/* Intervals over some rays, each number in all lanes, in mirrored coordinates, in which x and y grow along the rays:
 * centers times the sign of the direction, inverses without sign. */
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

/* One lane of a vector, in all lanes. Read from memory, where the rays of a tile are. */
static inline vfloat lane_of(const vfloat *v, unsigned lane) {
    float a;
    memcpy(&a, (const char *)v + lane * sizeof a, sizeof a);
    return vf_set(a);
}

/* True if the rays are coherent: in one direction quadrant, directions within 1/8 of the first one's length from it,
 * origins within this many cells of its origin. Right answers require only one quadrant and no negative from; the other
 * conditions are for speed. */
static inline bool coherent(const packet *packets, ray_set rays, float cells) {
    const unsigned first = (unsigned)__builtin_ctzll(rays);
    const vray *one = &packets[first / W].r;
    const unsigned lane = first % W;
    const vfloat dx = lane_of(&one->x.dir, lane), dy = lane_of(&one->y.dir, lane), dz = lane_of(&one->dz, lane);
    const vfloat ox = lane_of(&one->x.org, lane), oy = lane_of(&one->y.org, lane);
    const vfloat length = vf_max(vf_max(vf_abs(dx), vf_abs(dy)), vf_abs(dz)), zero = vf_set(0);
    const vfloat angle = vf_mul(length, vf_set(0.125f)), apart = vf_set(cells);
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const unsigned here = packet_bits(rays, p);
        const vray *r = &packets[p].r;
        vmask m = vm_and(vf_le(vf_abs(vf_sub(r->x.dir, dx)), angle), vf_le(vf_abs(vf_sub(r->y.dir, dy)), angle));
        m = vm_and(m, vf_le(vf_abs(vf_sub(r->dz, dz)), angle));
        m = vm_and(m, vm_and(vf_le(vf_abs(vf_sub(r->x.org, ox)), apart), vf_le(vf_abs(vf_sub(r->y.org, oy)), apart)));
        m = vm_andnot(m, vm_or(vm_xor(r->x.up, vf_ge(dx, zero)), vm_xor(r->y.up, vf_ge(dy, zero))));
        m = vm_and(m, vf_ge(r->from, zero)); /* products of t and dz keep their order */
        if ((vm_bits(m) & here) != here) return false;
    }
    return true;
}

/* Numbers of the intervals. The highest of each is found as the lowest of its negative. */
enum { HULL_X, HULL_X_INVERSE, HULL_Y, HULL_Y_INVERSE, HULL_OZ, HULL_DZ, HULL_UNTIL, HULL_NUMBERS, HULL_FROM = 15 };

/* False if on some axis the direction is zero for some rays and not for others: infinity, the inverse of zero, times a
 * distance of zero is NaN. If it is zero for all, that cannot happen, as their centers lie between borders. */
static inline bool fat_init(fat_ray *a, const packet *packets, ray_set rays) {
    const vfloat minus = vf_set(-0.0f), infinite = vf_set(INFINITY);
    const unsigned first = (unsigned)__builtin_ctzll(rays);
    vfloat hull[16];
    for (int k = 0; k < 16; k++) hull[k] = infinite;
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const vray *r = &packets[p].r;
        const vmask m = vm_from_bits(packet_bits(rays, p));
        const vfloat number[HULL_NUMBERS] = {r->x.center, r->x.inverse, r->y.center, r->y.inverse,
                                             r->oz,       r->dz,        r->until};
        for (int k = 0; k < HULL_NUMBERS; k++) {
            const vfloat low = vf_select(m, number[k], infinite);
            const vfloat high = vf_select(m, vf_flip(number[k], minus), infinite);
            hull[k] = vf_min(hull[k], low);
            hull[HULL_NUMBERS + k] = vf_min(hull[HULL_NUMBERS + k], high);
        }
        const vfloat from = vf_select(m, r->from, infinite);
        hull[HULL_FROM] = vf_min(hull[HULL_FROM], from);
    }
    float low[16];
    vf_lowest_of_each(hull, low);
    const float *minus_high = low + HULL_NUMBERS;

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
    /* Only rays that go up have infinite ones. */
    const bool mixed_x = a->up_x && -minus_high[HULL_X_INVERSE] > FLT_MAX && low[HULL_X_INVERSE] <= FLT_MAX;
    const bool mixed_y = a->up_y && -minus_high[HULL_Y_INVERSE] > FLT_MAX && low[HULL_Y_INVERSE] <= FLT_MAX;
    return !mixed_x && !mixed_y;
}

/* The earliest t at which one of the rays crosses an entry border, and the latest for an exit border, in mirrored
 * coordinates. */
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
    for (size_t k = 0; k < CHILD_VECTORS; k++)
        mask |= vm_bits(fat_meets(a, start_x, start_y, vf_set(l->side), k, vf_load_block(row, step, &a->order, k),
                                  vf_load_block(row + 16, step, &a->order, k)))
                << (k * W);
    return mask;
}

/* The cells of a block that some ray may meet. Also sets the cells' lowest and highest samples. */
static inline unsigned fat_cells(const fat_ray *a, block_samples *s, int32_t x, int32_t y) {
    const vfloat start_x = mirrored_start(a->up_x, 4 * x, 1), start_y = mirrored_start(a->up_y, 4 * y, 1);
    const float *row = first_row(&a->order, s->z, s->stride);
    const ptrdiff_t step = row_step(&a->order, s->stride);
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++) {
        vcell c;
        c.h00 = vf_load_block(row, step, &a->order, k);
        c.h10 = vf_load_block(row + 1, step, &a->order, k);
        c.h01 = vf_load_block(row + s->stride, step, &a->order, k);
        c.h11 = vf_load_block(row + s->stride + 1, step, &a->order, k);
        const vfloat low = cell_low(&c), high = cell_high(&c);
        vf_store(s->low + k * W, low);
        vf_store(s->high + k * W, high);
        mask |= vm_bits(fat_meets(a, start_x, start_y, vf_set(1), k, low, high)) << (k * W);
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

/* The rays whose heights over the block meet its bounds. */
static inline ray_set block_rays(const fat_ray *a, const packet *packets, ray_set rays, const cw_pyramid_level *l,
                                 int32_t x, int32_t y) {
    const float *n =
        l->bricks + ((size_t)(y >> 2) * (size_t)l->across + (size_t)(x >> 2)) * BRICK_FLOATS + ((y & 3) << 2 | (x & 3));
    ray_set concerned = 0;
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const vray *r = &packets[p].r;
        vcell c;
        place_crossings(r, a->up_x, a->up_y, (float)(4 * x), (float)(4 * y), 4, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        concerned |= (ray_set)vm_bits(vm_and(vf_le(t0, t1), meets(r, t0, t1, vf_set(n[0]), vf_set(n[16])))) << (p * W);
    }
    return concerned & rays;
}

/* Cells of the block with low corner (i, j), in the order of a walk in this quadrant. */
typedef struct block_cells {
    const block_samples *s;
    int32_t i, j;
    unsigned cells;
} block_cells;

/* Returns a packet's rays that have their first hits in these cells. Rejected: all packets in one cell after another,
 * since a ray then leaves the registers from cell to cell (papers/walks.md). */
CW_INLINE vmask shared_cells(int quadrant, packet *l, vmask among, const block_cells *b, bool any) {
    const bool up_x = quadrant & QUADRANT_UP_X, up_y = quadrant & QUADRANT_UP_Y;
    const int flip_x = up_x ? 0 : 3, flip_y = up_y ? 0 : 3;
    const block_samples *s = b->s;
    const vray *r = &l->r;
    vmask found = vm_set(false);
    for (unsigned cells = b->cells; cells != 0; cells &= cells - 1) {
        const int32_t place = __builtin_ctz(cells);
        const int32_t x = (place & 3) ^ flip_x, y = (place >> 2) ^ flip_y;
        const float *z = s->z + (size_t)y * s->stride + x;
        vcell c;
        c.i = vf_set((float)(b->i + x));
        c.j = vf_set((float)(b->j + y));
        place_crossings(r, up_x, up_y, (float)(b->i + x), (float)(b->j + y), 1, &c);
        c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->t0);
        c.t1 = vf_min(vf_min(c.x_out, c.y_out), r->t1);
        const vmask gate = vm_and(among, cell_gate_of(r, &c, vf_set(s->low[place]), vf_set(s->high[place])));
        if (!vm_any(gate)) continue;
        c.h00 = vf_set(z[0]);
        c.h10 = vf_set(z[1]);
        c.h01 = vf_set(z[s->stride]);
        c.h11 = vf_set(z[s->stride + 1]);
        vfind find = {c.t0, c.t1, gate}; /* any-hit queries do not set it; avoids a warning */
        const vmask now = wt_cell_in(quadrant, r, &c, gate, &find);
        if (!vm_any(now)) continue;
        if (!any) keep_hits(&l->hit, !vm_any(vm_or(l->found, found)), now, &find, &c);
        found = vm_or(found, now);
        among = vm_andnot(among, now);
        if (!vm_any(among)) break;
    }
    return found;
}

/* A tile or group falls apart at a block in which cells to be tested times packets are at least FALL_APART times its
 * rays, and at a node of which more than CHILDREN_AT_MOST children must be visited. 6 was the fastest of 5, 6 and 8
 * (papers/walks.md). */
enum { FALL_APART = 2, CHILDREN_AT_MOST = 6 };

/* Queues the rays that cross the given node of the pyramid for the lane walk, and returns them. */
static inline ray_set fall_apart(const fat_ray *a, const packet *packets, ray_set rays, const cw_field *f, int level,
                                 int32_t x, int32_t y, lane_queue *queue, size_t first_packet) {
    ray_set apart = 0;
    const cw_pyramid_level *l = &f->pyramid->level[level];
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const unsigned among = packet_bits(rays, p);
        const vray *r = &packets[p].r;
        vcell c;
        place_crossings(r, a->up_x, a->up_y, (float)x * l->side, (float)y * l->side, l->side, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const unsigned now = vm_bits(vf_le(t0, t1)) & among;
        if (now == 0) continue;
        mirror_packet(queue, first_packet, p, r, f);
        enqueue(queue, first_packet + p, now, t0, level + 1);
        apart |= (ray_set)now << (p * W);
    }
    return apart;
}

/* A tile that shares a walk: its fat ray, and those of its groups, made on first use. */
typedef struct tile_walk {
    const cw_field *f;
    packet *packets;
    lane_queue *queue;
    size_t first_packet;
    ray_set rays; /* still walking together */
    bool several; /* from more than one group */
    unsigned made;
    fat_ray tile, group[GROUPS];
} tile_walk;

/* The fat ray of a group's rays that still walk together; NULL if they are too few. */
static inline const fat_ray *group_ray(tile_walk *w, size_t g) {
    const ray_set rays = group_bits(w->rays, g);
    if (__builtin_popcountll(rays) < SHARE_AT_LEAST) return NULL;
    if (!(w->made >> g & 1)) {
        (void)fat_init(&w->group[g], w->packets, rays); /* true, as it was for the whole tile */
        w->made |= 1u << g;
    }
    return &w->group[g];
}

/* From this node on, the rays walk alone. */
static inline void leave(tile_walk *w, const fat_ray *a, ray_set rays, int level, int32_t x, int32_t y) {
    w->rays &= ~fall_apart(a, w->packets, rays, w->f, level, x, y, w->queue, w->first_packet);
}

/* Finds first hits of the rays in these cells. */
CW_INLINE void shared_packets(int quadrant, tile_walk *w, ray_set rays, const block_cells *b, bool any) {
    while (rays != 0) {
        const ray_set before = rays;
        const size_t p = next_packet(&rays);
        packet *l = &w->packets[p];
        const vmask found = shared_cells(quadrant, l, vm_from_bits(packet_bits(before, p)), b, any);
        l->found = vm_or(l->found, found);
        w->rays &= ~((ray_set)vm_bits(found) << (p * W));
    }
}

/* The same, a function for each quadrant. */
typedef void shared_packets_fn(tile_walk *w, ray_set rays, const block_cells *b, bool any);
static void packets_down_down(tile_walk *w, ray_set rays, const block_cells *b, bool any) {
    shared_packets(0, w, rays, b, any);
}
static void packets_up_down(tile_walk *w, ray_set rays, const block_cells *b, bool any) {
    shared_packets(QUADRANT_UP_X, w, rays, b, any);
}
static void packets_down_up(tile_walk *w, ray_set rays, const block_cells *b, bool any) {
    shared_packets(QUADRANT_UP_Y, w, rays, b, any);
}
static void packets_up_up(tile_walk *w, ray_set rays, const block_cells *b, bool any) {
    shared_packets(QUADRANT_UP_X + QUADRANT_UP_Y, w, rays, b, any);
}
static shared_packets_fn *const packets_of_quadrant[QUADRANTS] = {packets_down_down, packets_up_down, packets_down_up,
                                                                  packets_up_up};

/* Finds first hits of the rays in block (x, y). */
static void shared_block(tile_walk *w, const fat_ray *a, ray_set rays, int32_t x, int32_t y, bool any) {
    block_samples s;
    load_samples(&s, w->f, (size_t)(4 * x), (size_t)(4 * y));
    unsigned cells = fat_cells(a, &s, x, y);
    if (FALL_APART * __builtin_popcountll(rays) <= __builtin_popcount(cells) * packets_of(rays)) {
        if (a != &w->tile || !w->several) {
            leave(w, a, rays, 0, x, y);
            return;
        }
        while (rays != 0) {
            const size_t g = (size_t)__builtin_ctzll(rays) / GROUP;
            const fat_ray *b = group_ray(w, g);
            if (b == NULL)
                leave(w, a, group_bits(rays, g), 0, x, y);
            else
                shared_block(w, b, group_bits(rays, g), x, y, any);
            rays &= ~group_bits(rays, g);
        }
        return;
    }
    const block_cells b = {&s, 4 * x, 4 * y, cells};
    const int quadrant = (a->up_x ? QUADRANT_UP_X : 0) + (a->up_y ? QUADRANT_UP_Y : 0);
    packets_of_quadrant[quadrant](w, rays, &b, any);
}

/* Walks the rays of a through these children, of the given level, of node (x, y): to their ends or until they fall
 * apart. */
static void shared_walk(tile_walk *w, const fat_ray *a, ray_set mine, int top, int32_t x, int32_t y, unsigned children,
                        bool any);

/* The same for each group of a tile that falls apart at node (x, y) of the level. */
static inline void walk_groups(tile_walk *w, int level, int32_t x, int32_t y, bool any) {
    for (size_t g = 0; g < GROUPS; g++) {
        const ray_set rays = group_bits(w->rays, g);
        if (rays == 0) continue;
        const fat_ray *a = group_ray(w, g);
        if (a == NULL) {
            leave(w, &w->tile, rays, level, x, y);
            continue;
        }
        const unsigned children = fat_open(a, &w->f->pyramid->level[level - 1], x, y);
        if (__builtin_popcount(children) > CHILDREN_AT_MOST)
            leave(w, a, rays, level, x, y);
        else
            shared_walk(w, a, rays, level - 1, x, y, children, any);
    }
}

static void shared_walk(tile_walk *w, const fat_ray *a, ray_set mine, int top, int32_t x, int32_t y, unsigned children,
                        bool any) {
    const struct cw_pyramid *p = w->f->pyramid;
    const bool groups = a == &w->tile && w->several;
    struct {
        unsigned mask;
        int32_t x, y;
    } todo[PYRAMID_LEVELS_MAX];
    int level = top;
    unsigned mask = children;
    while ((w->rays & mine) != 0) {
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
            const ray_set concerned = block_rays(a, w->packets, w->rays & mine, &p->level[0], cx, cy);
            if (concerned != 0) shared_block(w, a, concerned, cx, cy, any);
            continue;
        }
        const unsigned inner = fat_open(a, &p->level[level - 1], cx, cy);
        if (__builtin_popcount(inner) > CHILDREN_AT_MOST) {
            if (groups)
                walk_groups(w, level, cx, cy, any);
            else
                leave(w, a, w->rays & mine, level, cx, cy);
            continue;
        }
        todo[level].mask = mask;
        todo[level].x = x;
        todo[level].y = y;
        level--;
        x = cx;
        y = cy;
        mask = inner;
    }
}
