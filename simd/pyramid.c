/* SPDX-License-Identifier: Apache-2.0 */
/* The pyramid kernels: which walk a ray takes. Groups of 16 rays are made ready W at a time; rays that climb out of the
 * terrain are cut short (climb.inc.h); a few steps of the flat walk finish what is close by (flat_walk.inc.h); what is left of a
 * group shares its walk as long as it is coherent (shared_walk.inc.h), and then is queued for the lane walk (lane_walk.inc.h).
 * Which way a ray takes never changes its hit, but for tolerant queries: the lane walk alone makes use of a tolerance.
 * simd/CMakeLists.txt compiles this twice for each row of its table, the second time for tolerant queries
 * (CELLWALK_TOLERANT). */

#ifdef CELLWALK_TOLERANT
/* A tolerant hit lies where its ray enters a slab, so that is computed with the same bits at every width. */
#define CELLWALK_UNFUSED
#endif

#include "vocabulary.h"

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "refine.inc.h"

#include "flat_walk.inc.h"

#include "kernels.h"
#include "pyramid.h"

#include "children.inc.h"
#include "climb.inc.h"

#include "lane_rays.inc.h"

#include "shared_walk.inc.h"

#include "lane_walk.inc.h"

/* Steps of the flat walk, all lanes together, that a packet takes before its rays go on one by one: by then rays that
 * start at the surface and climb have left it, mostly, and the lanes are still nearly full. */
enum { FLAT_STEPS = 4 };

/* Fewer rays than this do not pay for making a fat ray of them. */
enum { SHARE_AT_LEAST = 4 };

/* The compiler is to choose whether this is inlined, unlike in packet.c: inlined by force it takes registers from what follows,
 * 1 to 4 % of the time of pyramid16. */
static inline void first_steps(packet *l, const cw_field *f, cw_leaf leaf, bool any) {
    for (int k = 0; k < FLAT_STEPS && vm_any(l->alive); k++) flat_step(l, f, leaf, any);
}

/* The first n rays of a group, whose packets are numbers first_packet and on of the queue. Writes their hits, misses for
 * those that have none or not yet; of any-hit queries returns the rays that hit. Rays that are to go on alone are put into
 * the queue. tolerant: the query if it is tolerant, else NULL. */
CW_INLINE unsigned pyramid_group(const cw_field *f, const cw_ray *rays, size_t n, cw_coherence hint, cw_leaf leaf,
                                 bool any, cw_hit *hits, lane_queue *queue, size_t first_packet,
                                 const cw_query *tolerant) {
    packet packets[PACKETS];
    cw_ray tail[CHILDREN];
    unsigned found = 0, rest = 0, flat = 0; /* flat: bits of packets that have walked from cell to cell */
    rays = fill_up(rays, n, CHILDREN, tail);
    queue->mirrored = 0;
    for (size_t p = 0; p < PACKETS; p++) {
        packet *l = &packets[p];
        const size_t begin = p * W;
        l->alive = vm_and(vm_first(n <= begin ? 0 : n - begin), make_rays(&l->r, f, rays + begin));
        packet_clear(l);
        if (!vm_any(l->alive)) continue;
        const vmask short_way = climb(&l->r, f->pyramid, l->alive);
        l->alive = vm_and(l->alive, vf_le(l->r.from, l->r.until));
        if (vm_any(vm_and(l->alive, short_way))) {
            flat |= ((1u << W) - 1) << begin;
            flat_start(l, f);
            first_steps(l, f, leaf, any);
            l->r.from = vf_max(l->r.from, vf_max(l->c.x_in, l->c.y_in));
        }
        rest |= vm_bits(l->alive) << begin;
        if (!vm_any(l->alive)) continue;
        if (tolerant) set_tolerances(&queue->allowed[(first_packet + p) * W], f, rays + begin, tolerant);
    }
    fat_ray a;
    if (hint != CW_COHERENCE_LOW && __builtin_popcount(rest) >= SHARE_AT_LEAST && coherent(packets, rest, f, hint) &&
        fat_init(&a, packets, rest)) {
        shared_walk(&a, packets, rest, f, leaf, any, queue, first_packet);
    } else if (rest != 0) {
        for (size_t p = 0; p < PACKETS; p++) {
            const unsigned alone = rest >> (p * W) & ((1u << W) - 1);
            if (alone == 0) continue;
            mirror_packet(queue, first_packet, p, &packets[p].r, f, leaf);
            /* A ray that has just left the surface begins at its block, and so rises no further than it must. */
            const int level = flat >> (p * W) & 1 ? 1 : f->pyramid->levels;
            enqueue(queue, first_packet + p, alone, packets[p].r.from, level);
        }
    }
    if (any) {
        for (size_t p = 0; p < PACKETS; p++) found |= vm_bits(packets[p].found) << (p * W);
        return found;
    }
    cw_hit answers[CHILDREN];
    cw_hit *to = n < CHILDREN ? answers : hits;
    for (size_t p = 0; p < PACKETS; p++) packet_hits(&packets[p], f, rays + p * W, to + p * W);
    if (n < CHILDREN) memcpy(hits, answers, n * sizeof *hits);
    return 0;
}

/* Numbers of rays count from the beginning of their run. */
CW_INLINE void pyramid_closest(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query, cw_hit *hits,
                               cw_leaf leaf, const cw_query *tolerant) {
    lane_set alone;
    lane_answers answers;
    alone.living = 0;
    answers.found = 0;
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH, run = b / LANE_RUN * LANE_RUN;
        lane_queue queue;
        queue.n = 0;
        queue.first = (uint32_t)(b - run);
        answers.rays = rays + run;
        answers.hits = hits + run;
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            (void)pyramid_group(f, rays + k, count, query->coherence, leaf, false, hits + k, &queue, (k - b) / W,
                                tolerant);
        }
        lane_walk(f, &queue, &alone, end < n && end % LANE_RUN != 0, leaf, tolerant, false, &answers);
    }
}

CW_INLINE void pyramid_any(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query, uint8_t *occluded,
                           cw_leaf leaf, const cw_query *tolerant) {
    lane_set alone;
    lane_answers answers;
    alone.living = 0;
    answers.found = 0;
    for (size_t b = 0; b < n; b += BATCH) {
        const size_t end = n - b < BATCH ? n : b + BATCH, run = b / LANE_RUN * LANE_RUN;
        lane_queue queue;
        queue.n = 0;
        queue.first = (uint32_t)(b - run);
        answers.rays = rays + run;
        answers.occluded = occluded + run;
        for (size_t k = b; k < end; k += CHILDREN) {
            const size_t count = end - k < CHILDREN ? end - k : CHILDREN;
            const unsigned found =
                pyramid_group(f, rays + k, count, query->coherence, leaf, true, NULL, &queue, (k - b) / W, tolerant);
            for (size_t m = 0; m < count; m++) occluded[k + m] = found >> m & 1;
        }
        lane_walk(f, &queue, &alone, end < n && end % LANE_RUN != 0, leaf, tolerant, true, &answers);
    }
}

#ifdef CELLWALK_TOLERANT

static void CW_CODE(closest_tolerant_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                       cw_hit *hits) {
    pyramid_closest(f, rays, n, query, hits, CW_LEAF_WATERTIGHT, query);
}
static void CW_CODE(any_tolerant_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                   uint8_t *occluded) {
    pyramid_any(f, rays, n, query, occluded, CW_LEAF_WATERTIGHT, query);
}

const cw_kernel_code CW_CODE(tolerant) = {
    .closest = {[CW_LEAF_WATERTIGHT] = CW_CODE(closest_tolerant_)},
    .any = {[CW_LEAF_WATERTIGHT] = CW_CODE(any_tolerant_)},
};

#else

static void CW_CODE(closest_pyramid_mt_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                         cw_hit *hits) {
    pyramid_closest(f, rays, n, query, hits, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
static void CW_CODE(any_pyramid_mt_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                     uint8_t *occluded) {
    pyramid_any(f, rays, n, query, occluded, CW_LEAF_MOLLER_TRUMBORE, NULL);
}
static void CW_CODE(closest_pyramid_wt_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                         cw_hit *hits) {
    pyramid_closest(f, rays, n, query, hits, CW_LEAF_WATERTIGHT, NULL);
}
static void CW_CODE(any_pyramid_wt_)(const cw_field *f, const cw_ray *rays, size_t n, const cw_query *query,
                                     uint8_t *occluded) {
    pyramid_any(f, rays, n, query, occluded, CW_LEAF_WATERTIGHT, NULL);
}

/* A function a leaf test: one function for both, with a branch at its top, takes up to 15 % more instructions, as compilers
 * then have too few registers. */
const cw_kernel_code CW_CODE(pyramid) = {
    .closest =
        {[CW_LEAF_MOLLER_TRUMBORE] = CW_CODE(closest_pyramid_mt_), [CW_LEAF_WATERTIGHT] = CW_CODE(closest_pyramid_wt_)},
    .any = {[CW_LEAF_MOLLER_TRUMBORE] = CW_CODE(any_pyramid_mt_), [CW_LEAF_WATERTIGHT] = CW_CODE(any_pyramid_wt_)},
};

#endif
