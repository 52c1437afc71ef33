/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels: which walk a ray takes. Groups of 16 rays are made ready W at a time; rays that climb out of the
 * terrain are cut short (climb.inc.h); a few steps of the flat walk finish what is near (lanes.inc.h); what is left of a
 * group shares its walk as long as it is coherent (shared.inc.h), and then is queued for the lane walk (stream.inc.h).
 * Which way a ray takes never changes its hit, but for tolerant queries: the lane walk alone makes use of a tolerance.
 * A stub includes a vocabulary and then this body. */

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "lanes.inc.h"

#include "kernels.h"
#include "pyramid.h"

#include "climb.inc.h"
#include "places.inc.h"

#include "stream_rays.inc.h"

#include "shared.inc.h"

#include "stream.inc.h"

/* Steps of the flat walk, all lanes together, that a packet takes before its rays go on one by one: by then rays that
 * start at the surface and climb have left it, mostly, and the lanes are still nearly full. */
enum { FLAT_STEPS = 4 };

/* Fewer rays than this do not pay for making a fat ray of them. */
enum { SHARE_AT_LEAST = 4 };

/* The first n rays of a group, whose parts are numbers first_part and on of the queue. Returns the rays that hit, with
 * their hits written unless any; rays that are to go on alone are put into the queue. near: the query if it is tolerant,
 * else NULL. */
CW_INLINE unsigned pyramid_group(const cw_field *f, const cw_ray *rays, size_t n, cw_coherence hint, cw_leaf leaf,
                                 bool any, cw_hit *hits, stream_queue *queue, size_t first_part, const cw_query *near) {
    lanes part[PARTS];
    unsigned found = 0, rest = 0, flat = 0; /* flat: bits of parts that have walked from cell to cell */
    queue->mirrored = 0;
    for (size_t p = 0; p < PARTS; p++) {
        cw_ray tail[W];
        lanes *l = &part[p];
        const size_t begin = p * W, count = n <= begin ? 0 : n - begin < W ? n - begin : W;
        const cw_ray *from = rays + begin;
        if (count < W) { /* lanes beyond the array get a ray of the group to read */
            for (size_t k = 0; k < W; k++) tail[k] = rays[k < count ? begin + k : 0];
            from = tail;
        }
        l->alive = vm_and(vm_first(count), make_rays(&l->r, f, from));
        lanes_clear(l);
        if (!vm_any(l->alive)) continue;
        const vmask short_way = climb(&l->r, f->pyramid, l->alive);
        l->alive = vm_and(l->alive, vf_le(l->r.from, l->r.until));
        if (vm_any(vm_and(l->alive, short_way))) {
            flat |= ((1u << W) - 1) << begin;
            lanes_start(l, f);
            for (int k = 0; k < FLAT_STEPS && vm_any(l->alive); k++) lanes_step(l, f, leaf, any);
            l->r.from = vf_max(l->r.from, vf_max(l->c.x_in, l->c.y_in));
        }
        rest |= vm_bits(l->alive) << begin;
        if (!vm_any(l->alive)) continue;
        if (near) set_cones(&queue->cone[(first_part + p) * W], from, near);
    }
    fat_ray a;
    if (hint != CW_COHERENCE_LOW && __builtin_popcount(rest) >= SHARE_AT_LEAST && coherent(part, rest, f, hint) &&
        fat_init(&a, part, rest)) {
        shared_walk(&a, part, rest, f, leaf, any, queue, first_part);
    } else if (rest != 0) {
        for (size_t p = 0; p < PARTS; p++) {
            const unsigned alone = rest >> (p * W) & ((1u << W) - 1);
            if (alone == 0) continue;
            mirror_part(queue, first_part, p, &part[p].r, f, leaf);
            /* A ray that has just left the surface begins at its block, and so rises no further than it must. */
            const int level = flat >> (p * W) & 1 ? 1 : f->pyramid->levels;
            enqueue(queue, first_part + p, alone, part[p].r.from, level);
        }
    }
    for (size_t p = 0; p < PARTS; p++)
        found |= (any ? vm_bits(part[p].found) : lanes_hits(&part[p], hits + p * W)) << (p * W);
    return found;
}

/* Four at a time, for which compilers use whole registers: 3 % fewer instructions for primary rays than one by one. */
static inline void write_misses(cw_hit *hits, size_t n) {
    const cw_hit miss = {.t = INFINITY, .i = -1, .j = -1}, misses[4] = {miss, miss, miss, miss};
    size_t k = 0;
    for (; k + 4 <= n; k += 4) memcpy(hits + k, misses, sizeof misses);
    for (; k < n; k++) hits[k] = miss;
}

CW_INLINE void pyramid_closest(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits,
                               cw_leaf leaf, const cw_query *near) {
    stream_lanes alone;
    alone.living = 0;
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH, run = b / STREAM_RUN * STREAM_RUN;
        stream_queue queue;
        queue.n = 0;
        queue.first = (uint32_t)(b - run);
        write_misses(hits + b, end - b);
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            (void)pyramid_group(f, rays + k, count, query->coherence, leaf, false, hits + k, &queue, (k - b) / W, near);
        }
        stream_walk(f, &queue, &alone, end < n && end % STREAM_RUN != 0, leaf, near, false, hits + run, NULL);
    }
}

CW_INLINE void pyramid_any(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded,
                           cw_leaf leaf, const cw_query *near) {
    stream_lanes alone;
    alone.living = 0;
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH, run = b / STREAM_RUN * STREAM_RUN;
        stream_queue queue;
        queue.n = 0;
        queue.first = (uint32_t)(b - run);
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            const unsigned found =
                pyramid_group(f, rays + k, count, query->coherence, leaf, true, NULL, &queue, (k - b) / W, near);
            for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        }
        stream_walk(f, &queue, &alone, end < n && end % STREAM_RUN != 0, leaf, near, true, NULL, occluded + run);
    }
}
