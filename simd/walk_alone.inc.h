/* SPDX-License-Identifier: Apache-2.0 */
/* The rays that go on alone: in the vectors of their tiles or, with CELLWALK_PAIRED, in pairs of these (lane_pairs.c) until few
 * enough are left for a single one. Without that, calls of 1 to 64 rays are up to 1.8 times as slow with 2 × 16 lanes as with
 * 16, calls of 256 rays up to 1.14 times; with it up to 1.10 times, and 1.02 times (papers/walks.md). */

#ifdef CELLWALK_PAIRED

static inline void move_lane(lane_set *l, size_t to, size_t from) {
    for (int c = 0; c < RAY_FLOATS; c++) l->rays.f[c][to] = l->rays.f[c][from];
    for (int c = 0; c < RAY_INTS; c++) l->rays.i[c][to] = l->rays.i[c][from];
    l->t[to] = l->t[from];
    l->leave[to] = l->leave[from];
    l->x[to] = l->x[from];
    l->y[to] = l->y[from];
    l->level[to] = l->level[from];
    l->ray[to] = l->ray[from];
    l->allowed[to] = l->allowed[from];
    l->cone[to] = l->cone[from];
}

/* Moves rays of the second vector, no more than fit, into the first. */
static inline void close_up(lane_set *l) {
    for (unsigned second = l->living >> W; second != 0; second &= second - 1) {
        const size_t from = W + (size_t)__builtin_ctz(second), to = (size_t)__builtin_ctz(~l->living);
        move_lane(l, to, from);
        l->living ^= 1u << from | 1u << to;
    }
}

#endif

/* See lane_walk. Empties the queue. */
CW_INLINE void walk_alone(const cw_field *f, lane_queue *queue, lane_set *l, bool more, cw_leaf leaf,
                          const cw_query *tolerant, bool any, lane_answers *answers) {
#ifdef CELLWALK_PAIRED
    const size_t rays = (size_t)__builtin_popcount(l->living) + queue->n;
    if (more ? queue->n > 0 : rays > W) {
        lane_pairs_fn *const pairs = any ? LANE_PAIRS.any[leaf] : LANE_PAIRS.closest[leaf];
        pairs(f, queue, l, more, tolerant, answers);
        queue->n = 0;
    }
    if (more) return;
    close_up(l);
#endif
    lane_walk(f, queue, l, more, leaf, tolerant, any, answers);
    queue->n = 0;
}
