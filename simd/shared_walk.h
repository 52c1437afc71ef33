/* SPDX-License-Identifier: Apache-2.0 */
/* The shared walk of coherent rays. A tile of 64 rays goes through the pyramid as one fat ray (fat_ray.h). At a block each ray
 * is tested against the block's bounds. Then each packet takes the block's cells one after another, with the cell broadcast and
 * the rays in lanes. Where the rays diverge, the tile falls apart into groups of 16, which go on from that node with a fat ray
 * each. Where a group falls apart, its rays that cross the node are queued for the lane walk, which begins at that node
 * (lane_walk.h).
 *
 * After Reshetov, Soupikov and Hurley 2005 (one traversal finds where smaller beams begin), Boulos, Wald and Shirley 2006 and
 * Wald et al. 2006 (interval and frustum traversal of grids by packets). Rejected: testing every ray against every child. At
 * each level that costs as much for each vector of rays as the fat ray costs once. */
#ifndef CELLWALK_SIMD_SHARED_WALK_H
#define CELLWALK_SIMD_SHARED_WALK_H

#include "fat_ray.h"
#include "lane_rays.h"

/* Cells of the block with low corner (i, j), in the order of a walk in this quadrant. */
typedef struct block_cells {
    const block_samples *s;
    int32_t i, j;
    unsigned cells;
} block_cells;

/* Returns a packet's rays that have their first hits in these cells. Rejected: all packets in one cell after another,
 * since a ray then leaves the registers from cell to cell. */
CW_INLINE vmask shared_cells(int quadrant, packet *l, vmask among, const block_cells *b, bool any) {
    const bool up_x = quadrant & QUADRANT_UP_X, up_y = quadrant & QUADRANT_UP_Y;
    const block_samples *s = b->s;
    const vray *r = &l->r;
    vmask found = vm_set(false);
    for (unsigned cells = b->cells; cells != 0; cells &= cells - 1) {
        const int32_t place = __builtin_ctz(cells);
        const int32_t lane = place ^ flip(up_x), x = lane & 3, y = (place >> 2) ^ flip(up_y);
        const float *z = s->z + (size_t)y * s->stride + x;
        vcell c;
        c.i = vf_set((float)(b->i + x));
        c.j = vf_set((float)(b->j + y));
        place_crossings(r, up_x, up_y, (float)(b->i + x), (float)(b->j + y), 1, &c);
        c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->t0);
        c.t1 = vf_min(vf_min(c.x_out, c.y_out), r->t1);
        const vmask gate = vm_and(among, cell_gate_of(r, &c, vf_set(s->low[lane]), vf_set(s->high[lane])));
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
 * rays, and at a node of which more than CHILDREN_AT_MOST children must be visited. 6 was the fastest of 5, 6 and 8. */
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

/* A tile that shares a walk: its fat ray, and those of its groups, made on first use, if there are several. */
typedef struct tile_walk {
    const cw_field *f;
    packet *packets;
    lane_queue *queue;
    size_t first_packet;
    ray_set rays; /* still walking together */
    bool several; /* from more than one group */
    unsigned made;
    fat_ray tile, *group;
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

/* Finds first hits of the rays in block (x, y). False if they fall apart there. */
static __attribute__((noinline)) bool block_hits(tile_walk *w, const fat_ray *a, ray_set rays, int32_t x, int32_t y,
                                                 bool any) {
    block_samples s;
    load_samples(&s, w->f, (size_t)(4 * x), (size_t)(4 * y));
    const unsigned cells = fat_cells(a, &s, x, y);
    if (FALL_APART * __builtin_popcountll(rays) <= __builtin_popcount(cells) * packets_of(rays)) return false;
    const block_cells b = {&s, 4 * x, 4 * y, cells};
    const int quadrant = (a->up_x ? QUADRANT_UP_X : 0) + (a->up_y ? QUADRANT_UP_Y : 0);
    packets_of_quadrant[quadrant](w, rays, &b, any);
    return true;
}

/* The same, group by group if they fall apart. */
static inline void shared_block(tile_walk *w, const fat_ray *a, ray_set rays, int32_t x, int32_t y, bool any) {
    if (block_hits(w, a, rays, x, y, any)) return;
    if (a != &w->tile || !w->several) {
        leave(w, a, rays, 0, x, y);
        return;
    }
    for (size_t g = 0; g < GROUPS; g++) {
        const ray_set mine = group_bits(rays, g);
        const fat_ray *b = mine != 0 ? group_ray(w, g) : NULL;
        if (mine != 0 && (b == NULL || !block_hits(w, b, mine, x, y, any))) leave(w, a, mine, 0, x, y);
    }
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
        const int32_t cx = 4 * x + ((place & 3) ^ flip(a->up_x)), cy = 4 * y + ((place >> 2) ^ flip(a->up_y));
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

#endif
