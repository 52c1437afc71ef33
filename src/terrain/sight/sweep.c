/* SPDX-License-Identifier: Apache-2.0 */
/* The eye looks along rows of samples in four quarters, two in which rows are rows of the field and two in which
 * they are columns. In a quarter, a sample at distance r rows and x samples to the side is seen in direction u = x /
 * r, and its rise is w = height / r. That is a projection of space, so edges between samples stay straight: a sample
 * is seen if it is above all edges that are nearer, which is above their skyline.
 *
 * Row by row outward, edges are added to the skyline and samples are held against it. Two things save most of the
 * work. The skyline has a lower bound in each of many bins of directions, 8 to 16 cells wide: where neither this row
 * nor the last one comes up to it, nothing is seen and no edge matters. And an edge matters only if the triangle
 * before it faces the eye, or is missing, and the one behind it does not. Any other edge is lower, along every line
 * that crosses it, than the next edge on the line or the one before; and so on, up to an edge that is added or the
 * sample itself. The way to a sample enters its last triangle by an edge of the row before or by a diagonal: if that
 * triangle faces the eye, neither matters.
 *
 * Decisions are those of sight.h. Where rounding might tell otherwise, the way is followed there: where a plane
 * passes the eye within the margin, or a sample is as near to the skyline as the error. papers/terrain.md derives
 * both, under How. */
#include "sweep_part.h"

#include <stdlib.h>
#include <string.h>

enum { SLICES = SWEEP_PARTS / 4, BIN_CELLS = 8, BESIDE = 3 };

/* Rows after which bins are looked at again, as the skyline only rises and old lows are bounds too. */
enum { LOWS_EVERY = 4 };

/* Whether something next to the eye may be that high at a distance. A direction at a border of two ranges, as far as
 * rounding can tell, has the steeper rise. */
static inline bool reaches_around(const sweep_part *p, double u, double r, double height) {
    if (!(p->around_most * r >= height)) return false;
    const double place = (u - p->from) / (p->until - p->from) * SWEEP_AROUND;
    const int low = (int)(place - 1e-6), high = (int)(place + 1e-6);
    const double one = p->around[low < SWEEP_AROUND ? low : SWEEP_AROUND - 1],
                 other = p->around[high < SWEEP_AROUND ? high : SWEEP_AROUND - 1];
    return (one > other ? one : other) * r >= height;
}

static void look_around(sweep_part *p) {
    p->around_most = -INFINITY;
    for (int k = 0; k < SWEEP_AROUND; k++) {
        double direction[2][2];
        for (int end = 0; end < 2; end++) {
            direction[end][p->swapped ? 0 : 1] = p->outward;
            direction[end][p->swapped ? 1 : 0] = p->from + (k + end) * ((p->until - p->from) / SWEEP_AROUND);
        }
        p->around[k] = cw_sight_around(p->sight, direction[0], direction[1]);
        p->around_most = skyline_larger(p->around[k], p->around_most);
    }
}

/* The sample at or behind a bin's left border. */
static long bin_begin(const sweep_part *p, double r, size_t b) {
    const double at = p->aside + r * (p->from + (double)b * p->width);
    const long before = sweep_clipped(p, at); /* ceil is a call into the library */
    return before + ((double)before < at && before < p->length);
}

/* Bits of samples of a row, from the first on, about which nothing is open. */
typedef struct span {
    long first;
    uint64_t which;
} span;

static uint64_t hand_on(const sweep_part *p, long row, span s, const float *z, const double *rise,
                        const double *error) {
    if (s.which == 0) return 0;
    const size_t i = (size_t)(p->swapped ? row : s.first), j = (size_t)(p->swapped ? s.first : row),
                 count = SWEEP_SPAN_MOST - (size_t)__builtin_clzll(s.which);
    return p->visit_span(p->context, &(sweep_span){i, j, count, s.which, p->swapped, z, rise, error});
}

/* Makes room in it for sample i. */
static inline void begin_at(const sweep_part *p, long row, span *seen, long i) {
    if (seen->which != 0 && i < seen->first + SWEEP_SPAN_MOST) return;
    hand_on(p, row, *seen, NULL, NULL, NULL);
    *seen = (span){i, 0};
}

/* Samples' starts: the piece of the skyline that begins between a sample and the one before it, or 0. Pieces are as
 * narrow as cells, so that a walk along both would end at random: this takes no branch a sample. */
static void find_starts(sweep_part *p, double r, long begin, long end, uint32_t start) {
    const skyline_piece *s = p->line.pieces;
    const double aside = p->aside + SKYLINE_BLUR * r, last = ((double)(end - 1) - aside) / r;
    if (begin >= end) return;
    memset(p->starts + begin, 0, (size_t)(end - begin) * sizeof *p->starts);
    p->starts[begin] = start = skyline_find(&p->line, start, ((double)begin - aside) / r);
    const uint32_t *next = p->line.next;
    for (uint32_t k = next[start]; s[k].from < last; k = next[k]) p->starts[(long)(s[k].from * r + aside) + 1] = k;
}

/* Passes samples of the row, off the range's ends, that one piece of the skyline shows to be seen or hidden. Returns
 * the first sample that needs more. */
static long pass_decided(const sweep_part *p, long row, long i, long end, uint32_t *start, span *seen) {
    const double r = sweep_distance(p, row), per_row = 1 / r, error = sweep_error(p, r), margin = p->margin;
    const bool right = p->from >= 0;
    const double faces = p->target == 0 ? margin : INFINITY, around = p->around_most * r;
    /* The triangle before sample i, seen from the eye: on its left if the range lies right of the eye. */
    const double *leans = right == (p->outward > 0) ? p->front : p->back;
    for (bool open = false; i < end && !open;) {
        begin_at(p, row, seen, i);
        const long first = seen->first, last = end < first + SWEEP_SPAN_MOST ? end : first + SWEEP_SPAN_MOST;
        for (; i < last; i++) {
            const double lean = leans[i - right], u = ((double)i - p->aside) * per_row,
                         h = p->far_height[i] + p->target, top = h * per_row;
            const uint32_t k = p->starts[i] ? p->starts[i] : *start;
            p->starts[i] = *start = k;
            const skyline_piece *piece = p->line.pieces + k;
            const double rise = piece->a + piece->b * u;
            /* No branches, which could not be foreseen. */
            const bool hidden = lean > faces, alone = p->line.pieces[p->line.next[k]].from >= u + SKYLINE_BLUR,
                       below = top < rise - (double)piece->below - error,
                       above = (top > rise + error) & (lean < -margin);
            open = !(hidden | (alone & (below | above))) || (above & (h <= around) && reaches_around(p, u, r, h));
            if (open) break;
            seen->which |= (uint64_t)above << (i - first);
        }
    }
    return i;
}

/* The row's samples in these directions; nothing in it and the two before it, here and next to here, rises by more than
 * reach. The last part of a quarter has both ends. Exactly 45 degrees belongs to the quarters whose rows are rows. */
static uint32_t visit_row(sweep_part *p, long row, long begin, long end, uint32_t start, double reach) {
    const double r = sweep_distance(p, row), per_row = 1 / r, error = sweep_error(p, r);
    const bool rising = p->outward > 0, all = r <= sweep_close_rows, every = p->target == INFINITY;
    const bool on_samples = p->aside == floor(p->aside) && p->eye == floor(p->eye);
    const double *left_of = rising ? p->front : p->back, *right_of = rising ? p->back : p->front;
    const long inner = bin_begin(p, r, 0) + 1,
               outer = !(all || every) && p->target >= 0 ? bin_begin(p, r, p->bins) - 2 : 0;
    find_starts(p, r, begin > inner ? begin : inner, end < outer ? end : outer, start);
    span seen = {.which = 0};
    for (long i = begin; i < end; i++) {
        if (i >= inner && i < outer) i = pass_decided(p, row, i, end < outer ? end : outer, &start, &seen);
        if (i == end) break;
        const double h = p->far_height[i];
        const double x = (double)i - p->aside, u = x * per_row;
        const bool after = u >= p->from || p->from == -1, before = u < p->until || p->until == 1;
        const bool inside = p->swapped ? fabs(x) < r : fabs(x) <= r;
        if (!(h < INFINITY) || !(after && before && inside)) continue;
        /* On a diagonal but for rounding, the way may be in the triangle on either side, and one may be missing. */
        const bool between = fabs(fabs(x) - r) <= 0x1p-50 * (r + fabs(p->aside) + fabs(p->eye));
        const double leans = between ? 0 : x > 0 ? left_of[i - 1] : right_of[i];
        if (!all && p->target == 0 && leans > p->margin) continue;
        double low, high;
        skyline_at(&p->line, &start, u, &low, &high);
        p->starts[i] = start;
        const double top = (h + p->target) * per_row;
        if (!all && top < low - error) continue;
        sweep_way way = {.low = (low - error) * r, .unsure = {INFINITY, true}};
        /* On these ways all samples before count, and the skyline is unsure: beside holes, and where edges lead to the
         * eye. Each way would be followed to the eye. */
        if (every && r >= 1 && (x == 0 || (on_samples && fabs(x) == r))) {
            way.low = skyline_larger((p->ahead - error) * r, way.low);
            p->ahead = skyline_larger(h * per_row, p->ahead);
        }
        if (every && !all && h * per_row > high + error && leans < -p->margin && !reaches_around(p, u, r, h)) {
            begin_at(p, row, &seen, i);
            seen.which |= (uint64_t)1 << (i - seen.first);
            continue;
        }
        double least, most, doubt;
        if (every && !all && skyline_at_closely(&p->line, start, u, &least, &most, &doubt)) {
            way.known = true;
            way.rise = most * r;
            way.error = most == -INFINITY ? 0 : (most - least + doubt + 0x1p-48 * p->size) * r;
            way.unsure.close = reach < least - error ? 0 : 2;
            way.unsure.eye = reaches_around(p, u, r, skyline_larger(least * r, h) - error * r);
        }
        if (!(all || every) && top > high + error && p->target >= 0) {
            way.unsure.close = leans < -p->margin ? 0 : 2;
            way.unsure.eye = reaches_around(p, u, r, h + p->target);
        }
        const size_t at[2] = {p->swapped ? (size_t)row : (size_t)i, p->swapped ? (size_t)i : (size_t)row};
        p->visit(p->context, at[0], at[1], &way);
    }
    hand_on(p, row, seen, NULL, NULL, NULL);
    return start;
}

/* The same if no edge in reach comes up to the skyline, off the range's ends: most samples have one piece of it before
 * them, and nothing else counts. */
static void visit_calm(sweep_part *p, long row, const float *far, long begin, long end, uint32_t start) {
    const double r = sweep_distance(p, row), per_row = 1 / r, error = sweep_error(p, r), wrong = 0x1p-48 * p->size;
    double rise[SWEEP_SPAN_MOST], wide[SWEEP_SPAN_MOST];
    bool ready = false;
    for (long i = begin, stop; i < end; i = stop) {
        start = skyline_find(&p->line, start, ((double)i - p->aside) * per_row - SKYLINE_BLUR);
        const skyline_piece *piece = p->line.pieces + start;
        const double next = p->line.pieces[p->line.next[start]].from, a = piece->a, b = piece->b;
        const double above = (double)piece->above;
        stop = end - i < SWEEP_SPAN_MOST ? end : i + SWEEP_SPAN_MOST;
        while (stop > i && next < ((double)(stop - 1) - p->aside) * per_row + SKYLINE_BLUR) stop--;
        const int count = (int)(stop - i);
        for (int k = 0; k < count; k++) {
            const double u = ((double)i + (double)k - p->aside) * per_row, w = a + b * u;
            rise[k] = w * r;
            wide[k] = (above + skyline_rounding(w, b) + wrong) * r;
        }
        const double least = count == 0 ? -INFINITY : rise[0] < rise[count - 1] ? rise[0] : rise[count - 1];
        uint64_t left = UINT64_MAX; /* to be visited one by one */
        if (piece->below == 0 && least > -INFINITY && p->around_most * r < least - error * r)
            left = hand_on(p, row, (span){i, UINT64_MAX >> (SWEEP_SPAN_MOST - count)}, far + i, rise, wide);
        else
            stop = count > 0 ? stop : i + 1;
        if (left == 0) continue;
        if (!ready) cw_sweep_heights(p, far, row, begin, end, p->far_height);
        ready = true;
        for (long k = i; k < stop; k++)
            if (left >> (k - i) & 1) visit_row(p, row, k, k + 1, start, -INFINITY);
    }
}

/* Where bin b begins, or what is looked at of it. */
static double bin_left(const sweep_part *p, size_t b) {
    return skyline_larger(p->from + (double)b * p->width - 2 * SKYLINE_BLUR, p->line.from);
}

/* A piece of the skyline that begins before the bin on the left of bin b; that bin's own may be gone. */
static uint32_t start_before(const sweep_part *p, size_t b) {
    while (b > 0 && !(p->line.pieces[p->of[b - 1].start].from <= bin_left(p, b - 1))) b--;
    return b > 0 ? p->of[b - 1].start : p->first;
}

/* The skyline's range is what this row and those behind it can need: the part's, and less where the rows' ends come
 * nearer the direction ahead. Else all that was seen beside a strip would stay, and be walked along for each row. */
static void narrow(sweep_part *p, double r) {
    static const double beside = 1.25 * SKYLINE_BLUR; /* looks reach one, and narrow edges gain 3/16 */
    const double one = -p->aside / r, other = ((double)p->length - 1 - p->aside) / r;
    p->line.from = (one <= 0 ? skyline_larger(one, p->from) : p->from) - beside;
    p->line.until = (other >= 0 && other < p->until ? other : p->until) + beside;
    const bool gone = !(p->line.pieces[p->first].from <= p->line.from);
    p->first = skyline_find(&p->line, gone ? SKYLINE_FIRST : p->first, p->line.from);
}

/* Finds where bins from begin up to end start in the skyline, and how low it is there. */
static void look_again(sweep_part *p, size_t begin, size_t end) {
    uint32_t start = start_before(p, begin);
    for (size_t b = begin; b < end; b++) {
        const double left = bin_left(p, b), until = p->from + (double)(b + 1) * p->width + 2 * SKYLINE_BLUR;
        p->of[b].start = start = skyline_find(&p->line, start, left);
        p->of[b].low = cw_skyline_least(&p->line, start, left, until < p->line.until ? until : p->line.until);
    }
}

/* Cuts bins in two. */
static bool refine(sweep_part *p) {
    sweep_bin *of = realloc(p->of, 2 * p->bins * sizeof *of);
    if (of == NULL) return false;
    for (size_t b = p->bins; b-- > 0;) of[2 * b] = of[2 * b + 1] = of[b];
    p->of = of;
    p->bins *= 2;
    p->width /= 2;
    look_again(p, 0, p->bins);
    return true;
}

/* Goes on to the row in the bins from begin up to end: samples of it from left up to right. */
static void look_at(sweep_part *p, long row, const float *far, size_t begin, size_t end, long left, long right) {
    const double r = sweep_distance(p, row);
    const long from = left > BESIDE ? left - BESIDE : 0,
               until = right + BESIDE < p->length ? right + BESIDE : p->length;
    /* Beyond the row's end there is nothing to see, and no edge comes there. The bin before may have been passed over:
     * edges from there would be added from the middle on. */
    if (left >= p->length) return;
    const uint32_t start = start_before(p, begin);
    cw_sweep_heights(p, far, row, from, until, p->far_height);
    if (p->near) {
        /* Before the known ones, and behind them. */
        const long known = p->known_from < until ? p->known_from : until;
        const long on = p->known_until > from ? p->known_until : from;
        cw_sweep_heights(p, p->near, row - p->outward, from, known, p->near_height);
        cw_sweep_heights(p, p->near, row - p->outward, on > known ? on : known, until, p->near_height);
        cw_sweep_lean(p, r, from, until);
        cw_sweep_add_row(p, r, from, until, start);
    }
    uint32_t at = start;
    /* Needed heights use reach, and their last digits may depend on the bounds. Else all bins are one. */
    const bool every = p->target == INFINITY;
    const size_t bins = every ? 1 : end - begin;
    for (size_t b = begin; b < end; b += bins) {
        const long next = b + bins < end ? bin_begin(p, r, b + bins) : right;
        const double *high = p->of[b].high;
        at = visit_row(p, row, left, next, at, skyline_larger(high[0], skyline_larger(high[1], high[2])));
        left = next;
    }
    if (p->near) cw_sweep_add_between(p, r, start);
    if (every || row % LOWS_EVERY == 0) look_again(p, begin, end);
    if (until - from > p->far_until - p->far_from) { /* of several, the longest */
        p->far_from = from;
        p->far_until = until;
    }
}

/* No sample from left up to right, and next to them, is higher over the eye. */
static double highest(const sweep_part *p, const float *z, const sweep_lowering *q, long left, long right) {
    const long from = left > BESIDE ? left - BESIDE : 0,
               until = right + BESIDE < p->length ? right + BESIDE : p->length;
    if (from >= until) return -INFINITY;
    float highs[4] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY};
    long i = from;
    for (; i + 4 <= until; i += 4)
        for (int k = 0; k < 4; k++) highs[k] = z[i + k] > highs[k] ? z[i + k] : highs[k];
    for (; i < until; i++) highs[0] = z[i] > highs[0] ? z[i] : highs[0];
    const float one = highs[0] > highs[1] ? highs[0] : highs[1], other = highs[2] > highs[3] ? highs[2] : highs[3],
                high = one > other ? one : other;
    /* Between two places the lowering is less than at the lower one by at most that. */
    const double a = (double)from - p->aside, b = (double)until - p->aside;
    const double fall_a = q->one + a * (q->two + a * q->three), fall_b = q->one + b * (q->two + b * q->three);
    const double fall = -skyline_larger(-fall_a, -fall_b) - 0.25 * skyline_larger(q->three, 0) * (b - a) * (b - a),
                 eye = p->sight->eye[2];
    return (double)high - eye - fall + 0x1p-46 * (fabs((double)high) + fabs(eye) + fabs(fall));
}

static size_t bin_at(const sweep_part *p, double u) {
    const double b = (u - p->from) / p->width;
    return b > 0 ? b < (double)p->bins ? (size_t)b : p->bins : 0;
}

static void exchange(double **a, double **b) {
    double *swap = *a;
    *a = *b;
    *b = swap;
}

static void go_on(sweep_part *p, long row, const float *far) {
    const double r = sweep_distance(p, row), per_row = 1 / r;
    narrow(p, r);
    const sweep_lowering q = sweep_lowering_of(p, row);
    const bool every = p->target == INFINITY; /* then edges alone say where the skyline may grow */
    const double target = every ? 0 : skyline_larger(p->target, 0), error = sweep_error(p, r);
    const long first = sweep_clipped(p, floor(p->aside + r * p->from) - 1),
               last = sweep_clipped(p, ceil(p->aside + r * p->until) + 2);
    const size_t cells = (size_t)(last - first) + 2 * SWEEP_PAD;
    const long next = p->swapped ? -1 : row + p->outward; /* far away in memory */
    for (long i = first; i < last && next >= 0 && next < p->rows; i += 16)
        __builtin_prefetch(terrain_row(p->sight->terrain, (size_t)next) + i);
    memset(p->front + first - SWEEP_PAD, 0, cells * sizeof *p->front);
    memset(p->back + first - SWEEP_PAD, 0, cells * sizeof *p->back);
    /* Bins with samples of the field in them, or so near that their edges may reach into them. */
    const size_t from = bin_at(p, (-SWEEP_PAD - p->aside) * per_row);
    const size_t until = bin_at(p, ((double)p->length + SWEEP_PAD - p->aside) * per_row) + 1;
    size_t begin = 0;
    bool active = false;
    long left = from > 0 ? bin_begin(p, r, from) : first, run = left;
    for (size_t b = from; b < until && b < p->bins; b++) {
        const long right = b + 1 < p->bins ? bin_begin(p, r, b + 1) : last;
        sweep_bin *here = &p->of[b];
        const double top = highest(p, far, &q, left, right) * per_row, near = here->high[0];
        here->high[2] = here->high[1];
        here->high[1] = near;
        here->high[0] = top;
        const bool now = !(fmax(near, top + target * per_row) < here->low - error) || r <= sweep_close_rows + 1;
        if (!now && every && left < right) {
            if (b > 0 && b + 1 < p->bins) {
                visit_calm(p, row, far, left, right, start_before(p, b));
            } else {
                cw_sweep_heights(p, far, row, left, right, p->far_height);
                visit_row(p, row, left, right, start_before(p, b), -INFINITY);
            }
        }
        if (now && !active) begin = b, run = left;
        if (!now && active) look_at(p, row, far, begin, b, run, left);
        active = now;
        left = right;
    }
    if (active) look_at(p, row, far, begin, until < p->bins ? until : p->bins, run, left);
    exchange(&p->back, &p->back_before);
    exchange(&p->near_height, &p->far_height);
    p->known_from = p->far_from;
    p->known_until = p->far_until;
    p->far_from = p->far_until = 0;
}

static bool sweep(sweep_part *p, double most) {
    /* The first row that is not the eye's own. */
    long row = p->outward > 0 ? (long)floor(p->eye) + 1 : (long)ceil(p->eye) - 1;
    if (p->outward > 0 ? row < 0 : row >= p->rows) row = p->outward > 0 ? 0 : p->rows - 1;
    for (; row >= 0 && row < p->rows && sweep_distance(p, row) <= most; row += p->outward) {
        while (sweep_distance(p, row) * p->width > 2 * BIN_CELLS)
            if (!refine(p)) return false;
        const float *far = cw_sweep_fetch(p, row);
        go_on(p, row, far);
        if (p->line.failed) return false;
        p->near = far;
    }
    return true;
}

void cw_sweep_directions(unsigned number, double directions[2][2]) {
    const unsigned quarter = number / SLICES, slice = number % SLICES, across = quarter >= 2 ? 0 : 1;
    for (unsigned k = 0; k < 2; k++) {
        directions[k][across] = quarter % 2 ? -1 : 1;
        directions[k][1 - across] = 2.0 * (slice + k) / SLICES - 1;
    }
}

bool cw_sweep_part(const sight *s, unsigned number, double most, double target, sweep_visit *visit,
                   sweep_visit_span *visit_span, void *context) {
    const terrain *t = s->terrain;
    const unsigned quarter = number / SLICES, slice = number % SLICES;
    const bool swapped = quarter >= 2;
    sweep_part p = {.sight = s,
                    .swapped = swapped,
                    .outward = quarter % 2 ? -1 : 1,
                    .eye = s->eye[swapped ? 0 : 1],
                    .aside = s->eye[swapped ? 1 : 0],
                    .rows = (long)(swapped ? t->nx : t->ny),
                    .length = (long)(swapped ? t->ny : t->nx),
                    .from = 2.0 * slice / SLICES - 1,
                    .until = 2.0 * (slice + 1) / SLICES - 1,
                    .target = target,
                    .visit = visit,
                    .visit_span = visit_span,
                    .context = context,
                    .first = SKYLINE_FIRST,
                    .bins = 1,
                    .ahead = -INFINITY,
                    .columns_from = -1};
    p.width = p.until - p.from;
    const size_t length = (size_t)p.length + 2 * SWEEP_PAD;
    p.of = malloc(sizeof *p.of);
    double *lines = calloc(8 * length, sizeof *lines);
    if (p.swapped) p.columns = malloc((SWEEP_COLUMNS + 1) * sweep_columns_stride(&p) * sizeof *p.columns);
    bool good = cw_skyline_init(&p.line, p.from, p.until);
    good = good && p.of && lines && (p.columns || !p.swapped);
    if (good) {
        double **const line[6] = {&p.near_height, &p.far_height, &p.front, &p.back, &p.back_before, &p.edges};
        for (size_t k = 0; k < 6; k++) *line[k] = lines + k * length + SWEEP_PAD;
        p.starts = (uint32_t *)(lines + 6 * length) + SWEEP_PAD; /* piece 0 begins nowhere */
        p.along = p.starts + length;
        p.between = p.along + length;
        *p.of = (sweep_bin){-INFINITY, {-INFINITY, -INFINITY, -INFINITY}, SKYLINE_FIRST};
        look_around(&p);
        good = sweep(&p, most);
    }
    cw_skyline_free(&p.line);
    free(p.of);
    free(lines);
    free(p.columns);
    return good;
}
