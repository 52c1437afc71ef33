/* SPDX-License-Identifier: Apache-2.0 */
/* The shared walk of coherent rays. A tile of 64 rays goes through the pyramid as one fat ray (fat_ray.h). At a block
 * each ray is tested against the block's bounds. Then each packet takes the block's cells, broadcast, with the rays in
 * lanes: first all gates, then the leaf tests. Where the rays diverge, the tile falls apart: those that cross the node
 * are queued for the lane walk, which begins at that node (lane_walk.h).
 *
 * After Reshetov, Soupikov and Hurley 2005 (one traversal finds where smaller beams begin), Boulos, Wald and Shirley
 * 2006 and Wald et al. 2006 (interval and frustum traversal of grids by packets). Rejected: testing every ray against
 * every child. At each level that costs as much for each vector of rays as the fat ray costs once. */
#ifndef CELLWALK_SIMD_SHARED_WALK_H
#define CELLWALK_SIMD_SHARED_WALK_H

#include "fat_ray.h"
#include "lane_rays.h"

/* The cells of the block with low corner (i, j), in walk order. */
typedef struct block_cells {
    const block_samples *s;
    int32_t i, j;
    unsigned cells;                    /* those that some ray may meet */
    unsigned meet[PACKETS];            /* by packet: cells whose gates some of its rays pass */
    uint16_t gates[PACKETS][CHILDREN]; /* and these rays, a bit each */
} block_cells;

/* Finds which rays of packet p pass the gate of which cell. All gates of a block precede its first leaf test: they need
 * no branch, and the cells to test are then known early. Rejected: each gate before its test (papers/walks.md). */
CW_INLINE void packet_gates(block_cells *b, quadrant q, const vray *r, size_t p, unsigned among) {
    vfloat bx[5], by[5]; /* rejected: those of each gate anew (papers/walks.md) */
    for (int k = 0; k < 5; k++) {
        bx[k] = crossing(&r->x, vf_set((float)(b->i + k)));
        by[k] = crossing(&r->y, vf_set((float)(b->j + k)));
    }
    unsigned meet = 0;
    for (unsigned left = b->cells; left != 0; left &= left - 1) {
        const int32_t place = __builtin_ctz(left), lane = place ^ turn(q), x = lane & 3, y = lane >> 2;
        vcell c;
        c.x_in = bx[x + !q.up_x], c.x_out = bx[x + q.up_x];
        c.y_in = by[y + !q.up_y], c.y_out = by[y + q.up_y];
        clip_cell(&c, r);
        const unsigned gate = vm_bits(cell_gate_of(r, &c, vf_set(b->s->low[lane]), vf_set(b->s->high[lane]))) & among;
        b->gates[p][place] = (uint16_t)gate;
        meet |= (unsigned)(gate != 0) << place;
    }
    b->meet[p] = meet;
}

/* Returns packet p's rays that have their first hits in the block. Rejected: all packets in one cell after another,
 * since a ray then leaves the registers from cell to cell. */
CW_INLINE unsigned packet_finds(const block_cells *b, quadrant q, packet *l, size_t p, bool any) {
    const vray *r = &l->r;
    unsigned found = 0;
    for (unsigned cells = b->meet[p]; cells != 0;) {
        const int32_t place = nearest(cells, q), lane = place ^ turn(q), x = lane & 3, y = lane >> 2;
        cells ^= 1u << place;
        const unsigned left = b->gates[p][place] & ~found;
        if (left == 0) continue;
        const vmask gate = vm_from_bits(left);
        const float *low = b->s->z + (size_t)y * b->s->stride + x, *high = low + b->s->stride;
        vcell c;
        c.i = vf_set((float)(b->i + x));
        c.j = vf_set((float)(b->j + y));
        place_crossings(r, q, (float)(b->i + x), (float)(b->j + y), 1, &c);
        clip_cell(&c, r);
        c.h00 = vf_set(low[0]);
        c.h10 = vf_set(low[1]);
        c.h01 = vf_set(high[0]);
        c.h11 = vf_set(high[1]);
        vfind find;
        const vmask now = wt_cell_in(r, &c, gate, NULL, &find);
        const unsigned hits = vm_bits(now);
        if (hits == 0) continue;
        if (!any) keep_hits(&l->hit, found == 0 && !vm_any(l->found), now, &find, &c);
        found |= hits;
    }
    return found;
}

/* A tile that shares a walk. */
typedef struct tile_walk {
    const cw_field *f;
    packet *packets;
    lane_queue *queue;
    size_t first_packet;
    ray_set rays; /* still walking together */
    fat_ray fat;  /* of them */
} tile_walk;

/* A tile falls apart at a block in which cells to be tested times packets are at least FALL_APART times its rays, and
 * at a node of which more than CHILDREN_AT_MOST children must be visited. Rejected: groups of 16, which go on together
 * from there (papers/walks.md). */
enum { FALL_APART = 5, CHILDREN_AT_MOST = 8 };

/* Queues those of the rays that cross the given node of the pyramid for the lane walk. */
static inline void fall_apart(tile_walk *w, ray_set rays, int level, int32_t x, int32_t y) {
    const fat_ray *a = &w->fat;
    const cw_pyramid_level *l = &w->f->pyramid->level[level];
    while (rays != 0) {
        const ray_set before = rays;
        const size_t p = next_packet(&rays);
        vray *r = &w->packets[p].r;
        if (!(w->queue->mirrored >> p & 1)) (void)make_slab(r, w->f, CW_LEAF_WATERTIGHT); /* for lanes */
        vcell c;
        place_crossings(r, a->q, (float)x * l->side, (float)y * l->side, l->side, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const unsigned now = vm_bits(vf_le(t0, t1)) & packet_bits(before, p);
        if (now == 0) continue;
        mirror_packet(w->queue, w->first_packet, p, r, w->f);
        enqueue(w->queue, w->first_packet + p, now, t0, level + 1);
        w->rays &= ~((ray_set)now << (p * W));
    }
}

/* Finds first hits of the rays in block (x, y). False if they fall apart there. */
static __attribute__((noinline)) bool block_hits(tile_walk *w, ray_set rays, int32_t x, int32_t y, bool any) {
    const fat_ray *a = &w->fat;
    block_samples s;
    load_samples(&s, w->f, (size_t)(4 * x), (size_t)(4 * y));
    const unsigned cells = fat_cells(a, &s, x, y);
    if (FALL_APART * __builtin_popcountll(rays) <= __builtin_popcount(cells) * packets_of(rays)) return false;
    block_cells b; /* no initialiser: it would clear all gates */
    b.s = &s, b.i = 4 * x, b.j = 4 * y, b.cells = cells;
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        packet_gates(&b, a->q, &w->packets[p].r, p, packet_bits(rays, p));
    }
    while (rays != 0) {
        const size_t p = next_packet(&rays);
        packet *l = &w->packets[p];
        const unsigned found = packet_finds(&b, a->q, l, p, any);
        l->found = vm_or(l->found, vm_from_bits(found));
        w->rays &= ~((ray_set)found << (p * W));
    }
    return true;
}

/* Walks the rays of w from the top to their ends or until they fall apart. */
static inline void shared_walk(tile_walk *w, bool any) {
    const struct cw_pyramid *p = w->f->pyramid;
    const fat_ray *a = &w->fat;
    const int top = p->levels - 1;
    int level = top;
    int32_t x = 0, y = 0;
    unsigned mask = fat_open(a, &p->level[top], 0, 0), todo[PYRAMID_LEVELS_MAX];
    while (w->rays != 0) {
        while (mask == 0) {
            if (level == top) return;
            mask = todo[++level];
            x >>= 2;
            y >>= 2;
        }
        const int32_t place = nearest(mask, a->q), child = place ^ turn(a->q);
        mask ^= 1u << place;
        const int32_t cx = 4 * x + (child & 3), cy = 4 * y + (child >> 2);
        if (level == 0) {
            const ray_set concerned = block_rays(a, w->packets, w->rays, &p->level[0], cx, cy);
            if (concerned != 0 && !block_hits(w, concerned, cx, cy, any)) fall_apart(w, concerned, 0, cx, cy);
            continue;
        }
        const unsigned inner = fat_open(a, &p->level[level - 1], cx, cy);
        if (__builtin_popcount(inner) > CHILDREN_AT_MOST) {
            fall_apart(w, w->rays, level, cx, cy);
            continue;
        }
        todo[level--] = mask;
        x = cx;
        y = cy;
        mask = inner;
    }
}

#endif
