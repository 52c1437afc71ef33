/* SPDX-License-Identifier: Apache-2.0 */
#include "skyline.h"

#include <stdlib.h>

/* Narrow edges are widened to whole parts, by half of one at least on each side: other edges end where they stand, and
 * rounding leaves a gap between these. */
#define PART (SKYLINE_BLUR / 8)

bool cw_skyline_init(skyline *s, double from, double until) {
    *s = (skyline){.room = 64, .cuts_room = 64, .count = 2, .from = from, .until = until};
    s->pieces = malloc(s->room * sizeof *s->pieces);
    s->next = calloc(s->room, sizeof *s->next);
    s->cuts = malloc(s->cuts_room * sizeof *s->cuts);
    if (s->pieces == NULL || s->next == NULL || s->cuts == NULL) return false;
    s->pieces[0] = (skyline_piece){.from = INFINITY};
    s->pieces[SKYLINE_FIRST] = (skyline_piece){.from = from - 1, .a = -INFINITY};
    return true;
}

void cw_skyline_free(skyline *s) {
    free(s->pieces);
    free(s->next);
    free(s->cuts);
}

static uint32_t take_piece(skyline *s) {
    const uint32_t old = s->unused;
    if (old) {
        s->unused = s->next[old];
        return old;
    }
    if (s->count == s->room) {
        skyline_piece *more = realloc(s->pieces, 2 * (size_t)s->room * sizeof *more);
        if (more) s->pieces = more;
        uint32_t *next = realloc(s->next, 2 * (size_t)s->room * sizeof *next);
        if (next) s->next = next;
        if (more == NULL || next == NULL) return 0;
        s->room *= 2;
    }
    return s->count++;
}

static bool make_room(skyline *s, size_t cuts) {
    if (cuts <= s->cuts_room) return true;
    skyline_piece *more = realloc(s->cuts, 2 * cuts * sizeof *more);
    if (more == NULL) return false;
    s->cuts = more;
    s->cuts_room = 2 * cuts;
    return true;
}

static float rounded_up(double x) { return x > 0 ? (float)(x * (1 + 0x1p-22)) : 0; }

/* Two narrow edges in one part become one piece: a look that sees one sees the other, but at the ends of its reach.
 * Kept apart, all that were ever seen beside a strip would stay. */
static void join(skyline_piece *to, const skyline_piece *p) {
    const double one = to->a - (double)to->below, other = p->a - (double)p->below;
    to->a = skyline_larger(to->a, p->a);
    to->below = fmaxf(rounded_up(to->a - (one < other ? one : other)), fmaxf(to->below, p->below)); /* never 0 */
    to->above = fmaxf(to->above, p->above);
}

/* One more cut, unless it goes on with the last one's line; a cut of no width gives way. */
static inline size_t put(skyline_piece *cuts, size_t n, double from, const skyline_piece *p) {
    if (n > 0 && !(from > cuts[n - 1].from)) n--;
    if (n > 0 && p->below > 0 && cuts[n - 1].below > 0 && floor(from / PART) == floor(cuts[n - 1].from / PART)) {
        join(&cuts[n - 1], p);
        return n;
    }
    if (n > 0 && cuts[n - 1].a == p->a && cuts[n - 1].b == p->b && cuts[n - 1].below >= p->below) {
        if (p->above > cuts[n - 1].above) cuts[n - 1].above = p->above;
        return n;
    }
    cuts[n] = (skyline_piece){from, p->a, p->b, p->below, p->above};
    return n + 1;
}

/* Gives back the pieces behind at, up to behind. They begin nowhere, which tells who has kept one. */
static void leave_out(skyline *s, uint32_t at, uint32_t behind) {
    for (uint32_t gone = s->next[at]; gone != behind;) {
        const uint32_t next = s->next[gone];
        s->next[gone] = s->unused;
        s->pieces[gone].from = INFINITY;
        s->unused = gone;
        gone = next;
    }
    s->next[at] = behind;
}

static uint32_t put_between(skyline *s, uint32_t at) {
    const uint32_t fresh = take_piece(s);
    if (fresh == 0) return 0;
    s->next[fresh] = s->next[at];
    s->next[at] = fresh;
    return fresh;
}

/* The cuts take the place of the pieces from first to last. The first cut and the last stay in these two, if there are
 * as many: others point to pieces before and behind an edge. */
static void put_in_place(skyline *s, uint32_t first, uint32_t last, size_t n) {
    const uint32_t behind = s->next[last];
    uint32_t at = first;
    for (size_t k = 0; k < n; k++) {
        if (k > 0) {
            const bool end = k + 1 == n && first != last;
            if (end) leave_out(s, at, last);
            at = end || (s->next[at] != last && s->next[at] != behind) ? s->next[at] : put_between(s, at);
            if (at == 0) {
                s->failed = true;
                return;
            }
        }
        s->pieces[at] = s->cuts[k];
    }
    leave_out(s, at, behind);
}

/* An edge that is left out may be higher than a piece by that. Looks allow for the greatest slope of such edges too. */
static void leave_room(skyline *s, uint32_t piece, double above, double slope) {
    const float most = rounded_up(above);
    if (most > s->pieces[piece].above) s->pieces[piece].above = most;
    if (most > 0 && fabs(slope) > s->steepest) s->steepest = fabs(slope);
}

void cw_skyline_add(skyline *s, uint32_t start, const double one[2], const double other[2]) {
    const bool turned = one[0] > other[0];
    double from = turned ? other[0] : one[0], until = turned ? one[0] : other[0];
    if (!(until > s->from && from < s->until)) return;
    const double from_w = turned ? other[1] : one[1], until_w = turned ? one[1] : other[1];
    skyline_piece edge = {.from = from};
    const bool narrow = until - from < SKYLINE_BLUR / 2;
    if (narrow) { /* in whole parts: in each of them the highest stays, not a bit of each */
        edge.a = from_w > until_w ? from_w : until_w;
        from = floor(from / PART - 0.5) * PART;
        until = floor(until / PART + 1.5) * PART;
    } else {
        edge.b = (until_w - from_w) / (until - from);
        edge.a = from_w - edge.b * from;
    }
    from = from > s->from ? from : s->from;
    until = until < s->until ? until : s->until;

    uint32_t first = skyline_find(s, start, from), last = first, before = first;
    size_t n = 0;
    bool higher = false;
    const skyline_piece *p = s->pieces;
    for (double left = from;; before = last, last = s->next[last]) {
        const double end = p[s->next[last]].from, right = end < until ? end : until;
        const double left_w = p[last].a + p[last].b * left, right_w = p[last].a + p[last].b * right;
        const double left_e = edge.a + edge.b * left, right_e = edge.a + edge.b * right;
        const double over_left = left_e - left_w, over_right = right_e - right_w;
        /* The lower of the two lines may be higher by that. */
        const double rounding =
            skyline_rounding(skyline_larger(fabs(left_e), fabs(right_e)), fabs(edge.b) + fabs(p[last].b));
        if (!make_room(s, n + 4)) {
            s->failed = true;
            return;
        }
        if (narrow && (over_left > 0 || over_right > 0)) {
            const double low = (left_w < right_w ? left_w : right_w) - (double)p[last].below, below = edge.a - low;
            if (below > (double)edge.below) edge.below = below < 1e30 ? nextafterf((float)below, INFINITY) : INFINITY;
        }
        if (!(over_left > 0 || over_right > 0)) {
            leave_room(s, last, rounding + skyline_larger(over_left, over_right), edge.b);
            if (higher) n = put(s->cuts, n, left, &p[last]);
            if (end >= until) break;
            left = right;
            continue;
        }
        if (!higher) { /* nothing changes but from the piece before here on, as the edge may go on with its line */
            first = before;
            if (p[first].from < left) n = put(s->cuts, n, p[first].from, &p[first]);
            higher = true;
        }
        if (over_left > 0 && over_right > 0) {
            edge.above = rounded_up((double)p[last].above + rounding + skyline_larger(-over_left, -over_right));
            n = put(s->cuts, n, left, &edge);
        } else {
            edge.above = rounded_up((double)p[last].above + rounding);
            leave_room(s, last, rounding, edge.b);
            double middle = left + (right - left) * (over_left / (over_left - over_right));
            middle = middle < left ? left : middle > right ? right : middle;
            n = put(s->cuts, n, left, over_left > 0 ? &edge : &p[last]);
            n = put(s->cuts, n, middle, over_left > 0 ? &p[last] : &edge);
        }
        if (end >= until) {
            if (end > until) n = put(s->cuts, n, until, &p[last]);
            break;
        }
        left = right;
    }
    if (!higher) return;
    if (fabs(edge.b) > s->steepest) s->steepest = fabs(edge.b);
    put_in_place(s, first, last, n);
}

double cw_skyline_least(const skyline *s, uint32_t start, double from, double until) {
    const skyline_piece *p = s->pieces;
    double least = INFINITY;
    for (uint32_t k = skyline_find(s, start, from); p[k].from < until || k == start; k = s->next[k]) {
        const double end = p[s->next[k]].from;
        const double left = p[k].from > from ? p[k].from : from, right = end < until ? end : until;
        const double one = p[k].a + p[k].b * left, other = p[k].a + p[k].b * right;
        const double w = (one < other ? one : other) - (double)p[k].below;
        least = w < least ? w : least;
        if (!(end < until)) break;
    }
    return least;
}
