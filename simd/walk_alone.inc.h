/* SPDX-License-Identifier: Apache-2.0 */
/* The lane walk of the queued rays, in the vectors of their tiles. If CELLWALK_LANE_VECTORS is 2, it uses pairs of
 * these (lane_pairs.c) until one vector can hold the rest. Rejected: pairs to the end, which slow calls of few rays
 * down (papers/walks.md). */

static inline void move_lane(lane_set *l, size_t to, size_t from) {
    for (int c = 0; c < RAY_FLOATS; c++) l->rays.f[c][to] = l->rays.f[c][from];
    for (int c = 0; c < RAY_INTS; c++) l->rays.i[c][to] = l->rays.i[c][from];
    l->t[to] = l->t[from];
    l->leave[to] = l->leave[from];
    l->x[to] = l->x[from];
    l->y[to] = l->y[from];
    l->level[to] = l->level[from];
    l->ray[to] = l->ray[from];
    l->born[to] = l->born[from];
}

/* Moves the rays of the second vector into the first. They must fit. */
static inline void close_up(lane_set *l) {
    for (unsigned second = l->living >> W; second != 0; second &= second - 1) {
        const size_t from = W + (size_t)__builtin_ctz(second), to = (size_t)__builtin_ctz(~l->living);
        move_lane(l, to, from);
        l->living ^= 1u << from | 1u << to;
    }
}

/* See lane_walk. Empties the queue. */
CW_INLINE void walk_alone(const cw_field *f, lane_queue *queue, lane_set *l, bool more, lane_answers *answers) {
    if (LANES > (int)W) {
        const size_t rays = (size_t)__builtin_popcount(l->living) + queue->n;
        if (more ? queue->n > 0 : rays > W) {
            CW_CODE(lane_pairs_)(f, queue, l, more, answers);
            queue->n = 0;
        }
        if (more) return;
        close_up(l);
    }
    lane_walk(f, queue, l, more, answers);
    queue->n = 0;
}
