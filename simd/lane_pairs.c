/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk in pairs of vectors, for pyramid8x2 and pyramid16x2: all their other walks are in pyramid.c, with single vectors.
 * simd/CMakeLists.txt compiles this twice for each of them, the second time for tolerant queries (CELLWALK_TOLERANT). */

#ifdef CELLWALK_TOLERANT
#define CELLWALK_UNFUSED /* as in pyramid.c */
#endif

#define CELLWALK_LANE_PAIRS
#define CELLWALK_LOADED_PAIRS /* see vec_avx512.h */

#include "vocabulary.h"

#include "ray.inc.h"

#include "moller_trumbore.inc.h"
#include "watertight.inc.h"

#include "refine.inc.h"

#include "flat_walk.inc.h"

#include "pyramid.h"

#include "lane_queue.inc.h"

#include "lane_walk.inc.h"

/* See lane_walk. Copies of the lanes spare a register for where they are, of which AVX2 has too few: random and grazing rays 3
 * to 5 % faster with 2 × 8 lanes. With 2 × 16 lanes the copying costs rays on 65² samples 1 to 3 %, for nothing. */
CW_INLINE void walk_pairs(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, cw_leaf leaf,
                          const cw_query *tolerant, bool any, lane_answers *answers) {
    if ((int)QUEUE_W < 16) {
        lane_set here = *l;
        lane_walk(f, queue, &here, more, leaf, tolerant, any, answers);
        *l = here;
    } else {
        lane_walk(f, queue, l, more, leaf, tolerant, any, answers);
    }
}

#ifdef CELLWALK_TOLERANT

static void closest_tolerant(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                             lane_answers *answers) {
    walk_pairs(f, queue, l, more, CW_LEAF_WATERTIGHT, query, false, answers);
}
static void any_tolerant(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                         lane_answers *answers) {
    walk_pairs(f, queue, l, more, CW_LEAF_WATERTIGHT, query, true, answers);
}

const lane_pairs_walk LANE_PAIRS = {
    .closest = {[CW_LEAF_WATERTIGHT] = closest_tolerant},
    .any = {[CW_LEAF_WATERTIGHT] = any_tolerant},
};

#else

static void closest_mt(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                       lane_answers *answers) {
    (void)query;
    walk_pairs(f, queue, l, more, CW_LEAF_MOLLER_TRUMBORE, NULL, false, answers);
}
static void any_mt(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                   lane_answers *answers) {
    (void)query;
    walk_pairs(f, queue, l, more, CW_LEAF_MOLLER_TRUMBORE, NULL, true, answers);
}
static void closest_wt(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                       lane_answers *answers) {
    (void)query;
    walk_pairs(f, queue, l, more, CW_LEAF_WATERTIGHT, NULL, false, answers);
}
static void any_wt(const cw_field *f, const lane_queue *queue, lane_set *l, bool more, const cw_query *query,
                   lane_answers *answers) {
    (void)query;
    walk_pairs(f, queue, l, more, CW_LEAF_WATERTIGHT, NULL, true, answers);
}

const lane_pairs_walk LANE_PAIRS = {
    .closest = {[CW_LEAF_MOLLER_TRUMBORE] = closest_mt, [CW_LEAF_WATERTIGHT] = closest_wt},
    .any = {[CW_LEAF_MOLLER_TRUMBORE] = any_mt, [CW_LEAF_WATERTIGHT] = any_wt},
};

#endif
