/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels: the choice of a walk for each ray. Tiles of 64 rays are made ready W at a time. A coherent
 * tile shares its walk (shared_walk.h). The walks of other rays end where they climb out of the terrain (climb.h). A
 * few steps of the flat walk finish the short ones (flat_walk.h), and the rest is queued for the lane walk
 * (lane_walk.h). Invariant: the choice of a walk never changes a hit, since every walk visits each cell that passes the
 * gate. Paper: Tevs, Ihrke and Seidel 2008, with four children a node; here there are sixteen. */

#include "climb.h"
#include "kernels.h"
#include "lane_walk.h"
#include "shared_walk.h"

#include <stddef.h>
#include <string.h>

/* Steps of the flat walk that a packet takes before its rays are queued. By then most rays that start at the surface
 * and climb have left it, and most lanes are still in use. */
enum { FLAT_STEPS = 4 };

/* Climb and flat steps for the rays of w in these packets, which share no walk; queues those that go on. The packets
 * climb together and step together, and all pass their gates before the first leaf test, since each alone is one chain
 * of dependent operations. Rejected, as slower: one packet after another. */
CW_INLINE void walk_apart(tile_walk *w, climber *climbers, packet_set apart, bool any) {
    const cw_field *f = w->f;
    climb(w->packets, climbers, apart, f);
    packet_set flat = 0;
    for (packet_set left = apart; left != 0; left &= left - 1) {
        const int p = __builtin_ctzll(left);
        packet *l = &w->packets[p];
        l->alive = vm_and(l->alive, vf_le(l->r.from, l->r.until));
        if (!vm_any(short_way(&l->r, l->alive))) continue;
        flat |= (packet_set)1 << p;
        flat_start(l, f);
    }
    vmask gates[PACKETS];
    for (int k = 0; k < FLAT_STEPS; k++) {
        packet_set tests = 0;
        for (packet_set left = flat; left != 0; left &= left - 1) {
            const int p = __builtin_ctzll(left);
            gates[p] = flat_gate(&w->packets[p], f);
            tests |= (packet_set)vm_any(gates[p]) << p;
        }
        for (; tests != 0; tests &= tests - 1) {
            const int p = __builtin_ctzll(tests);
            flat_leaf(&w->packets[p], gates[p], CW_LEAF_WATERTIGHT, any, false);
        }
        for (packet_set left = flat; left != 0; left &= left - 1) {
            const int p = __builtin_ctzll(left);
            flat_next(&w->packets[p], f);
            flat &= ~((packet_set)!vm_any(w->packets[p].alive) << p);
        }
    }
    for (packet_set left = apart; left != 0; left &= left - 1) {
        const size_t p = (size_t)__builtin_ctzll(left);
        packet *l = &w->packets[p];
        if (!vm_any(l->alive)) continue;
        const bool stepped = flat >> p & 1;
        if (stepped) l->r.from = vf_max(l->r.from, vf_max(l->c.x_in, l->c.y_in));
        mirror_packet(w->queue, w->first_packet, p, &l->r, f);
        /* After flat steps the lane walk begins at the ray's block; from there it goes up only as far as it must. */
        enqueue(w->queue, w->first_packet + p, vm_bits(l->alive), l->r.from, stepped ? 1 : f->pyramid->levels);
    }
}

/* Walks the rays of w together if they are coherent; else returns false. */
CW_INLINE bool walk_together(tile_walk *w, bool any) {
    if (__builtin_popcountll(w->rays) < SHARE_AT_LEAST || !may_cohere(w->packets, w->rays)) return false;
    if (!fat_init(&w->fat, w->packets, w->rays)) return false;
    shared_walk(w, any);
    return true;
}

/* Memory of a call: for a tile's packets, and in queue for a batch's. */
typedef struct tile_room {
    packet *packets;
    vstart *start;
    climber *climbers;
    lane_queue *queue;
} tile_room;

/* Traces the first n rays of a tile, whose packets are numbers first_packet and on of the queue. Writes their hits,
 * and misses for rays without a hit so far. Returns the rays that hit if any is set, else 0. Rays that go on alone
 * are queued. */
static __attribute__((noinline)) ray_set pyramid_tile(const cw_field *f, const cw_ray *rays, size_t n, bool any,
                                                      cw_hit *hits, const tile_room *room, size_t first_packet) {
    packet *const packets = room->packets;
    vstart *const start = room->start;
    cw_ray tail[W];
    tile_walk w;
    w.f = f;
    w.packets = packets;
    w.queue = room->queue;
    w.first_packet = first_packet;
    w.queue->mirrored = 0;
    const size_t count = (n + W - 1) / W;
    ray_set alive = 0;
    for (size_t p = 0; p < count; p++) {
        packet *l = &packets[p];
        const cw_ray *mine = fill_up(rays + p * W, n - p * W, W, tail);
        l->alive = vm_and(vm_first(n - p * W), make_rays(&l->r, f, mine, CW_LEAF_WATERTIGHT, false, &start[p]));
        l->found = vm_set(false);
        alive |= (ray_set)vm_bits(l->alive) << (p * W);
    }
    w.rays = alive;
    if (!walk_together(&w, any)) {
        packet_set apart = 0;
        for (size_t p = 0; p < count; p++) apart |= (packet_set)vm_any(packets[p].alive) << p;
        walk_apart(&w, room->climbers, apart, any);
    }
    if (any) {
        ray_set found = 0;
        for (size_t p = 0; p < count; p++) found |= (ray_set)vm_bits(packets[p].found) << (p * W);
        return found;
    }
    cw_hit answers[W];
    for (size_t p = 0; p < count; p++) {
        const bool part = n - p * W < W;
        packet_hits(&packets[p], &start[p], part ? answers : hits + p * W);
        if (part) memcpy(hits + p * W, answers, (n - p * W) * sizeof *hits);
    }
    return 0;
}

/* All members up to the clock have SLOTS words each. */
static inline void move_lane(lane_set *l, size_t to, size_t from) {
    enum { WORD = sizeof l->t[0], ROWS = offsetof(lane_set, clock) / sizeof l->t };
    char *row = (char *)l;
    for (int k = 0; k < ROWS; k++, row += sizeof l->t) memcpy(row + to * WORD, row + from * WORD, WORD);
}

/* Moves the rays of the second register into the first. They must fit. */
static inline void close_up(lane_set *l) {
    for (unsigned second = l->living >> W; second != 0; second &= second - 1) {
        const size_t from = W + (size_t)__builtin_ctz(second), to = (size_t)__builtin_ctz(~l->living);
        move_lane(l, to, from);
        l->living ^= 1u << from | 1u << to;
    }
}

/* lane_walk in vectors of two registers until one can hold the rest, and empties the queue. Rejected: two to the end,
 * which slow calls of few rays down (papers/walks.md). */
CW_INLINE void walk_alone(const cw_field *f, lane_queue *queue, lane_set *l, bool more, lane_answers *answers) {
    if (SLOTS > W) {
        const size_t rays = (size_t)__builtin_popcount(l->living) + queue->n;
        if (more ? queue->n > 0 : rays > W) {
            CW_CODE(lane_pairs)(f, queue, l, more, answers);
            queue->n = 0;
        }
        if (more) return;
        close_up(l);
    }
    lane_walk(f, queue, l, more, answers);
    queue->n = 0;
}

/* Closest hits, or any hits; the other array is NULL. Rays are numbered from the beginning of their run. One function
 * for both: a copy for each is twice the text and no faster. */
CW_ONE_COPY static void pyramid_rays(const tile_room *room, const cw_field *f, const cw_ray *rays, size_t n, bool any,
                                     cw_hit *hits, uint8_t *occluded) {
    lane_queue *const queue = room->queue;
    lane_set alone;
    lane_answers answers;
    alone.living = 0;
    alone.clock = alone.look_at = 0;
    answers.found = 0;
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH, run = b / LANE_RUN * LANE_RUN;
        queue->n = 0;
        queue->first = (uint32_t)(b - run);
        answers.rays = rays + run;
        answers.hits = any ? NULL : hits + run;
        answers.occluded = any ? occluded + run : NULL;
        for (size_t k = b; k < end; k += TILE) {
            const size_t count = end - k < TILE ? end - k : TILE;
            const ray_set found = pyramid_tile(f, rays + k, count, any, any ? NULL : hits + k, room, (k - b) / W);
            if (any)
                for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        }
        walk_alone(f, queue, &alone, end < n && end % LANE_RUN != 0, &answers);
    }
}

/* Calls of few rays take little of the stack. */
static __attribute__((noinline)) void pyramid_few(const cw_field *f, const cw_ray *rays, size_t n, bool any,
                                                  cw_hit *hits, uint8_t *occluded) {
    enum { SOME = (CW_FEW_RAYS + W - 1) / W };
    packet packets[SOME];
    vstart start[SOME];
    climber climbers[SOME];
    ready_rays ready[SOME];
    queued waiting[CW_FEW_RAYS];
    lane_queue queue = {.ready = ready, .rays = waiting};
    pyramid_rays(&(tile_room){packets, start, climbers, &queue}, f, rays, n, any, hits, occluded);
}

static __attribute__((noinline)) void pyramid_many(const cw_field *f, const cw_ray *rays, size_t n, bool any,
                                                   cw_hit *hits, uint8_t *occluded) {
    packet packets[PACKETS];
    vstart start[PACKETS];
    climber climbers[PACKETS];
    ready_rays ready[BATCH / W];
    queued waiting[BATCH];
    lane_queue queue = {.ready = ready, .rays = waiting};
    pyramid_rays(&(tile_room){packets, start, climbers, &queue}, f, rays, n, any, hits, occluded);
}

static void CW_CODE(pyramid_wt_)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    (n <= CW_FEW_RAYS ? pyramid_few : pyramid_many)(f, rays, n, hits == NULL, hits, occluded);
}

const cw_kernel_code CW_CODE(pyramid) = {.trace = {[CW_LEAF_WATERTIGHT] = CW_CODE(pyramid_wt_)}};
