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
#include "sweep.h"

#include "skyline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SLICES = SWEEP_PARTS / 4, BIN_CELLS = 8, COLUMNS_AT_ONCE = 16, AROUND = 32, BESIDE = 3, PAD = 12 };

/* Up to here all samples are looked at exactly, as edges may be so near to the eye that they do not count, and all
 * edges are added. */
static const double close_rows = 3;

/* The skyline begins there: a cell from the eye, less a hair. Nearer terrain is left to cw_sight_around. */
static const double first_distance = 1 - 0x1p-10;

/* A small range of directions. */
typedef struct bin {
    double low;     /* the skyline is nowhere lower */
    double high[3]; /* nothing in this row and the two before it rises by more, here or next to here */
    uint32_t start; /* the skyline's last piece that begins before it */
} bin;

typedef struct part {
    const sight *sight;
    bool swapped;       /* rows are columns of the field */
    int outward;        /* +1 or -1 */
    double eye, aside;  /* the eye's place across the rows and along them */
    long rows, length;  /* of the field, in this sense */
    double from, until; /* directions */
    double target;
    sweep_visit *visit;
    sweep_visit_span *visit_span;
    void *context;

    skyline line;
    size_t bins;
    double width; /* of a bin */
    bin *of;

    const float *near;                /* the last row, or NULL */
    double *near_height, *far_height; /* of it and the present row, over the eye */
    /* How far the planes of triangles pass over the eye: those at the near row, those at the far one, and those at
     * the far row of the rows before. 0 where that is not known, NaN where there is no triangle. */
    double *front, *back, *back_before;
    bool holes; /* there have been some */

    /* The greatest so far: steps between neighbours, and the numbers whose rounding matters, per distance. */
    double step, snap, size, rise;
    double margin; /* planes that pass the eye this near may face it or not */
    double ahead;  /* the steepest rise to a sample exactly ahead or on the diagonal, of which a part has one */

    double around[AROUND]; /* rises next to the eye, in so many ranges of directions */
    double around_most;    /* the greatest of them */
    float *columns;        /* COLUMNS_AT_ONCE columns of the field, as rows, and the last before them */
    long columns_from, columns_left, columns_right;
} part;

static double distance(const part *p, long row) { return fabs((double)row - p->eye); }

static long clipped(const part *p, double i) { return i > 0 ? i < (double)p->length ? (long)i : p->length : 0; }

/* Heights of a row's samples in these directions and next to them. A row that is a column is fetched with those that
 * follow it, since each line of memory holds samples of sixteen. */
static const float *fetch(part *p, long row) {
    const terrain *t = p->sight->terrain;
    if (!p->swapped) return terrain_row(t, (size_t)row);
    const long first = row - row % COLUMNS_AT_ONCE;
    const size_t length = (size_t)p->length;
    if (p->columns_from != first) {
        const long last = first + COLUMNS_AT_ONCE - 1 < p->rows ? first + COLUMNS_AT_ONCE - 1 : p->rows - 1;
        const double a = (double)first - p->eye, b = p->eye - (double)last;
        const double near = fmax(fmax(a, b), 0), far = fmax(-a, -b);
        const long left = clipped(p, floor(p->aside + fmin(near * p->from, far * p->from)) - PAD),
                   right = clipped(p, ceil(p->aside + fmax(near * p->until, far * p->until)) + PAD);
        if (p->near) {
            float *kept = p->columns + COLUMNS_AT_ONCE * length;
            memcpy(kept + p->columns_left, p->near + p->columns_left,
                   (size_t)(p->columns_right - p->columns_left) * sizeof *kept);
            p->near = kept;
        }
        p->columns_from = first;
        p->columns_left = left;
        p->columns_right = right > left ? right : left;
        const size_t count = (size_t)(last - first + 1);
        for (long j = left; j < right; j++) {
            const float *z = terrain_row(t, (size_t)j) + first;
            for (size_t c = 0; c < count; c++) p->columns[c * length + (size_t)j] = z[c];
        }
    }
    return p->columns + (size_t)(row - first) * length;
}

/* The lowering along a row is one + two x + three x², x samples to the side of the eye. */
typedef struct lowering {
    double one, two, three;
} lowering;

static lowering lowering_of(const part *p, long row) {
    const double *f = p->sight->fall, y = (double)row - p->eye;
    return p->swapped ? (lowering){f[0] * y * y, f[1] * y, f[2]} : (lowering){f[2] * y * y, f[1] * y, f[0]};
}

/* Heights over the eye from sample begin up to end, NaN at holes. */
static void heights(const part *p, const float *z, long row, long begin, long end, double *h) {
    const lowering q = lowering_of(p, row);
    const double eye = p->sight->eye[2], aside = p->aside;
    for (int k = 0; k < (int)(end - begin); k++) {
        const double x = (double)begin + (double)k - aside;
        const double height = (double)z[begin + k] - eye - (q.one + x * (q.two + x * q.three));
        h[begin + k] = height + (height - height);
    }
}

static inline double larger(double a, double b) { return a > b ? a : b; } /* b if a is NaN */

/* How the triangles between the two rows lean. */
static void lean(part *p, double r, long begin, long end) {
    const double *n = p->near_height, *f = p->far_height;
    const long a = p->outward > 0 ? 1 : 0, b = 1 - a; /* diagonals go from sample b of a cell to sample a */
    double most_step = 0, most_height = 0;
    bool holes = false;
    for (long i = begin; i < end - 1; i++) {
        const double near = n[i + 1] - n[i], far = f[i + 1] - f[i];
        const double side_a = f[i + a] - n[i + a], side_b = f[i + b] - n[i + b];
        const double front = f[i + a] - near * ((double)(i + a) - p->aside) - side_a * r;
        const double back = f[i + b] - far * ((double)(i + b) - p->aside) - side_b * r;
        p->front[i] = front;
        p->back[i] = back;
        most_step = larger(fabs(near) + fabs(side_a), larger(fabs(far) + fabs(side_b), most_step));
        most_height = larger(fabs(n[i]), larger(fabs(f[i]), most_height));
        holes |= isnan(front + back);
    }
    const double *fall = p->sight->fall, wide = (r + 2) * (r + 2);
    const double lowered = (fabs(fall[0]) + fabs(fall[1]) + fabs(fall[2])) * wide;
    const double size = most_height + 2 * (fabs(p->sight->eye[2]) + lowered), near = fmax(r - 1, first_distance);
    p->holes |= holes;
    p->step = fmax(p->step, most_step);
    p->snap = fmax(p->snap, most_step / near);
    p->size = fmax(p->size, size / near);
    p->rise = fmax(p->rise, most_height / near);
    p->margin = 0x1p-24 * p->step * r + 0x1p-46 * size * (r + 16);
}

/* Bound on the difference of the skyline from the results of sight.c, for its edges and for those that were not
 * added. */
static double error_of(const part *p, double r) {
    return 0x1p-25 * p->snap + 0x1p-44 * p->size + 0x1p-45 * r * (p->line.steepest + p->rise);
}

/* Whether an edge may be the highest on a way from one triangle into another, which lean like that. */
static inline bool is_ridge(const part *p, double before, double behind) {
    return !(before > p->margin) && !(behind < -p->margin);
}

static inline void add(part *p, uint32_t start, double x0, double r0, double h0, double x1, double r1, double h1) {
    if (isnan(h0 + h1)) return;
    if (r0 < first_distance) { /* beyond it */
        const double share = (first_distance - r0) / (r1 - r0);
        x0 += share * (x1 - x0);
        h0 += share * (h1 - h0);
        r0 = first_distance;
    }
    cw_skyline_add(&p->line, start, (double[2]){x0 / r0, h0 / r0}, (double[2]){x1 / r1, h1 / r1});
}

/* Edges of the near row. */
static void add_row(part *p, double r, long begin, long end, uint32_t start) {
    const double near = r - 1, *h = p->near_height;
    const bool all = r <= close_rows + 1;
    if (near < first_distance) return;
    uint32_t at = start;
    for (long i = begin; i < end - 1; i++) {
        if (!(all || is_ridge(p, p->back_before[i], p->front[i]))) continue;
        const double x = (double)i - p->aside;
        if (!all) at = skyline_find(&p->line, at, (x - 3) / near);
        add(p, at, x, near, h[i], x + 1, near, h[i + 1]);
    }
    if (!p->holes) return;
    /* Beside a hole each sample counts alone. */
    for (long i = begin; i < end; i++) {
        const double x = (double)i - p->aside;
        const double planes =
            p->front[i - 1] + p->front[i] + p->back[i - 1] + p->back[i] + p->back_before[i - 1] + p->back_before[i];
        if (isnan(planes)) add(p, start, x, near, h[i], x, near, h[i]);
    }
}

/* Edges between the rows. */
static void add_between(part *p, double r, long begin, long end, uint32_t start) {
    const double *n = p->near_height, *f = p->far_height;
    const bool all = r <= close_rows + 1;
    const long a = p->outward > 0 ? 1 : 0, b = 1 - a;
    const double *left_of = a ? p->front : p->back, *right_of = a ? p->back : p->front;
    if (!(r > first_distance)) return;
    for (long i = begin; i < end; i++) {
        const double x = (double)i - p->aside, left = left_of[i - 1], right = right_of[i];
        const bool side = x != 0 && (all || is_ridge(p, x > 0 ? left : right, x > 0 ? right : left));
        const bool diagonal = i + 1 < end && (all || is_ridge(p, p->front[i], p->back[i]));
        if (!(side || diagonal)) continue;
        if (!all) start = skyline_find(&p->line, start, (x - 3) / r);
        if (side) add(p, start, x, r - 1, n[i], x, r, f[i]);
        if (diagonal) add(p, start, x + (double)b, r - 1, n[i + b], x + (double)a, r, f[i + a]);
    }
}

/* Whether something next to the eye may be that high at a distance. A direction at a border of two ranges, as far as rounding can
 * tell, has the steeper rise. */
static inline bool reaches_around(const part *p, double u, double r, double height) {
    if (!(p->around_most * r >= height)) return false;
    const double place = (u - p->from) / (p->until - p->from) * AROUND;
    const int low = (int)(place - 1e-6), high = (int)(place + 1e-6);
    const double one = p->around[low < AROUND ? low : AROUND - 1], other = p->around[high < AROUND ? high : AROUND - 1];
    return (one > other ? one : other) * r >= height;
}

static void look_around(part *p) {
    p->around_most = -INFINITY;
    for (int k = 0; k < AROUND; k++) {
        double direction[2][2];
        for (int end = 0; end < 2; end++) {
            direction[end][p->swapped ? 0 : 1] = p->outward;
            direction[end][p->swapped ? 1 : 0] = p->from + (k + end) * ((p->until - p->from) / AROUND);
        }
        p->around[k] = cw_sight_around(p->sight, direction[0], direction[1]);
        p->around_most = larger(p->around[k], p->around_most);
    }
}

/* Samples of a row about which nothing is open. */
typedef struct span {
    long first, count;
    const float *z;
    const double *rise, *error;
} span;

static uint64_t hand_on(const part *p, long row, const span *s) {
    if (s->count == 0) return 0;
    const sweep_span all = {.i = (size_t)(p->swapped ? row : s->first),
                            .j = (size_t)(p->swapped ? s->first : row),
                            .count = (size_t)s->count,
                            .down = p->swapped,
                            .z = s->z,
                            .rise = s->rise,
                            .error = s->error};
    return p->visit_span(p->context, &all);
}

/* The samples of the row in these directions; nothing in it and the two rows before it, here and next to here, rises by more than
 * reach. The last part of a quarter has both ends. Directions of exactly 45 degrees belong to the quarters whose rows are rows. */
static uint32_t visit_row(part *p, long row, long begin, long end, uint32_t start, double reach) {
    const double r = distance(p, row), per_row = 1 / r, error = error_of(p, r);
    const bool rising = p->outward > 0, all = r <= close_rows, every = p->target == INFINITY;
    const bool on_samples = p->aside == floor(p->aside) && p->eye == floor(p->eye);
    const double *left_of = rising ? p->front : p->back, *right_of = rising ? p->back : p->front;
    span seen = {0};
    for (long i = begin; i < end; i++) {
        const double h = p->far_height[i];
        const double x = (double)i - p->aside, u = x * per_row;
        const bool after = u >= p->from || p->from == -1, before = u < p->until || p->until == 1;
        const bool inside = p->swapped ? fabs(x) < r : fabs(x) <= r;
        if (!(h < INFINITY) || !(after && before && inside)) continue;
        /* On a diagonal but for rounding, the way may be in the triangle on either side, and one of them may be missing. */
        const bool between = fabs(fabs(x) - r) <= 0x1p-50 * (r + fabs(p->aside) + fabs(p->eye));
        const double leans = between ? 0 : x > 0 ? left_of[i - 1] : right_of[i];
        if (!all && p->target == 0 && leans > p->margin) continue;
        double low, high;
        skyline_at(&p->line, &start, u, &low, &high);
        const double top = (h + p->target) * per_row;
        if (!all && top < low - error) continue;
        sweep_way way = {.low = (low - error) * r, .unsure = {INFINITY, true}};
        /* On these ways all samples before count, and the skyline is unsure: beside holes, and where edges lead to the eye. Each way
         * would be followed to the eye. */
        if (every && r >= 1 && (x == 0 || (on_samples && fabs(x) == r))) {
            way.low = larger((p->ahead - error) * r, way.low);
            p->ahead = larger(h * per_row, p->ahead);
        }
        const double above = every ? 0 : p->target;
        if (!all && (h + above) * per_row > high + error && above >= 0 && leans < -p->margin &&
            !reaches_around(p, u, r, h + above)) {
            if (seen.first + seen.count != i) {
                hand_on(p, row, &seen);
                seen = (span){.first = i};
            }
            seen.count++;
            continue;
        }
        double least, most, doubt;
        if (every && !all && skyline_at_closely(&p->line, start, u, &least, &most, &doubt)) {
            way.known = true;
            way.rise = most * r;
            way.error = most == -INFINITY ? 0 : (most - least + doubt + 0x1p-48 * p->size) * r;
            way.unsure.close = reach < least - error ? 0 : 2;
            way.unsure.eye = reaches_around(p, u, r, larger(least * r, h) - error * r);
        }
        if (!(all || every) && top > high + error && p->target >= 0) {
            way.unsure.close = leans < -p->margin ? 0 : 2;
            way.unsure.eye = reaches_around(p, u, r, h + p->target);
        }
        const size_t at[2] = {p->swapped ? (size_t)row : (size_t)i, p->swapped ? (size_t)i : (size_t)row};
        p->visit(p->context, at[0], at[1], &way);
    }
    hand_on(p, row, &seen);
    return start;
}

/* The same if no edge in reach comes up to the skyline, off the range's ends: most samples have one piece of it before them, and
 * nothing else counts. */
static void visit_calm(part *p, long row, const float *far, long begin, long end, uint32_t start) {
    const double r = distance(p, row), per_row = 1 / r, error = error_of(p, r), wrong = 0x1p-48 * p->size;
    double rise[SWEEP_SPAN_MOST], wide[SWEEP_SPAN_MOST];
    bool ready = false;
    for (long i = begin, stop; i < end; i = stop) {
        start = skyline_find(&p->line, start, ((double)i - p->aside) * per_row - SKYLINE_BLUR);
        const skyline_piece *piece = p->line.pieces + start;
        const double next = p->line.pieces[piece->next].from, a = piece->a, b = piece->b, above = (double)piece->above;
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
            left = hand_on(p, row, &(span){i, count, far + i, rise, wide});
        else
            stop = count > 0 ? stop : i + 1;
        if (left == 0) continue;
        if (!ready) heights(p, far, row, begin, end, p->far_height);
        ready = true;
        for (long k = i; k < stop; k++)
            if (left >> (k - i) & 1) visit_row(p, row, k, k + 1, start, -INFINITY);
    }
}

/* What the bins from begin up to end know of the skyline, after edges were added up to direction reached. A bin behind them may have
 * had its start in a piece that is gone, since pieces on one line become one. */
static void look_again(part *p, size_t begin, size_t end, double reached) {
    uint32_t start = begin > 0 ? p->of[begin - 1].start : SKYLINE_FIRST;
    for (size_t b = begin; b < p->bins; b++) {
        const double left = p->from + (double)b * p->width - 2 * SKYLINE_BLUR;
        start = skyline_find(&p->line, start, left);
        if (b > end && p->line.pieces[start].from > reached) break;
        p->of[b].start = start;
        if (b < end) p->of[b].low = cw_skyline_least(&p->line, start, left, left + p->width + 4 * SKYLINE_BLUR);
    }
}

/* Cuts bins in two. */
static bool refine(part *p) {
    bin *of = realloc(p->of, 2 * p->bins * sizeof *of);
    if (of == NULL) return false;
    for (size_t b = p->bins; b-- > 0;) of[2 * b] = of[2 * b + 1] = of[b];
    p->of = of;
    p->bins *= 2;
    p->width /= 2;
    look_again(p, 0, p->bins, INFINITY);
    return true;
}

/* The sample at or behind a bin's left border. */
static long bin_begin(const part *p, double r, size_t b) {
    return clipped(p, ceil(p->aside + r * (p->from + (double)b * p->width)));
}

/* Goes on to the row in the bins from begin up to end: samples of it from left up to right. */
static void look_at(part *p, long row, const float *far, size_t begin, size_t end, long left, long right) {
    const double r = distance(p, row);
    const long from = left > BESIDE ? left - BESIDE : 0,
               until = right + BESIDE < p->length ? right + BESIDE : p->length;
    const uint32_t start = begin > 0 ? p->of[begin - 1].start : SKYLINE_FIRST;
    if (from >= until) return;
    heights(p, far, row, from, until, p->far_height);
    if (p->near) {
        heights(p, p->near, row - p->outward, from, until, p->near_height);
        lean(p, r, from, until);
        add_row(p, r, from, until, start);
    }
    uint32_t at = start;
    for (size_t b = begin; b < end; b++) {
        const long next = b + 1 < end ? bin_begin(p, r, b + 1) : right;
        const double *high = p->of[b].high;
        at = visit_row(p, row, left, next, at, larger(high[0], larger(high[1], high[2])));
        left = next;
    }
    if (p->near) add_between(p, r, from, until, start);
    look_again(p, begin, end, ((double)until - p->aside) / fmax(r - 1, first_distance));
}

/* No sample from left up to right, and next to them, is higher over the eye. */
static double highest(const part *p, const float *z, const lowering *q, long left, long right) {
    const long from = left > BESIDE ? left - BESIDE : 0,
               until = right + BESIDE < p->length ? right + BESIDE : p->length;
    if (from >= until) return -INFINITY;
    float high = -INFINITY;
    for (long i = from; i < until; i++) high = z[i] > high ? z[i] : high;
    /* Between two places the lowering is less than at the lower one by at most that. */
    const double a = (double)from - p->aside, b = (double)until - p->aside;
    const double fall_a = q->one + a * (q->two + a * q->three), fall_b = q->one + b * (q->two + b * q->three);
    const double fall = fmin(fall_a, fall_b) - 0.25 * fmax(q->three, 0) * (b - a) * (b - a), eye = p->sight->eye[2];
    return (double)high - eye - fall + 0x1p-46 * (fabs((double)high) + fabs(eye) + fabs(fall));
}

static size_t bin_at(const part *p, double u) {
    const double b = (u - p->from) / p->width;
    return b > 0 ? b < (double)p->bins ? (size_t)b : p->bins : 0;
}

static void go_on(part *p, long row, const float *far) {
    const double r = distance(p, row), per_row = 1 / r;
    const lowering q = lowering_of(p, row);
    const bool every = p->target == INFINITY; /* then edges alone say where the skyline may grow */
    const double target = every ? 0 : larger(p->target, 0), error = error_of(p, r);
    const long first = clipped(p, floor(p->aside + r * p->from) - 1),
               last = clipped(p, ceil(p->aside + r * p->until) + 2);
    const size_t cells = (size_t)(last - first) + 2 * PAD;
    memset(p->front + first - PAD, 0, cells * sizeof *p->front);
    memset(p->back + first - PAD, 0, cells * sizeof *p->back);
    /* Bins with samples of the field in them, or so near that their edges may reach into them. */
    const size_t from = bin_at(p, (-PAD - p->aside) * per_row);
    const size_t until = bin_at(p, ((double)p->length + PAD - p->aside) * per_row) + 1;
    size_t begin = 0;
    bool active = false;
    long left = from > 0 ? bin_begin(p, r, from) : first, run = left;
    for (size_t b = from; b < until && b < p->bins; b++) {
        const long right = b + 1 < p->bins ? bin_begin(p, r, b + 1) : last;
        bin *here = &p->of[b];
        const double top = highest(p, far, &q, left, right) * per_row, near = here->high[0];
        here->high[2] = here->high[1];
        here->high[1] = near;
        here->high[0] = top;
        const bool now = !(fmax(near, top + target * per_row) < here->low - error) || r <= close_rows + 1;
        if (!now && every && left < right) {
            if (b > 0 && b + 1 < p->bins) {
                visit_calm(p, row, far, left, right, p->of[b - 1].start);
            } else {
                heights(p, far, row, left, right, p->far_height);
                visit_row(p, row, left, right, b > 0 ? p->of[b - 1].start : SKYLINE_FIRST, -INFINITY);
            }
        }
        if (now && !active) begin = b, run = left;
        if (!now && active) look_at(p, row, far, begin, b, run, left);
        active = now;
        left = right;
    }
    if (active) look_at(p, row, far, begin, until < p->bins ? until : p->bins, run, left);
    double *swap = p->back;
    p->back = p->back_before;
    p->back_before = swap;
}

static bool sweep(part *p, double most, sweep_tick *tick) {
    /* The first row that is not the eye's own. */
    long row = p->outward > 0 ? (long)floor(p->eye) + 1 : (long)ceil(p->eye) - 1;
    if (p->outward > 0 ? row < 0 : row >= p->rows) row = p->outward > 0 ? 0 : p->rows - 1;
    for (; row >= 0 && row < p->rows && distance(p, row) <= most; row += p->outward) {
        if (!tick(p->context)) return true;
        while (distance(p, row) * p->width > 2 * BIN_CELLS)
            if (!refine(p)) return false;
        const float *far = fetch(p, row);
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
                   sweep_visit_span *visit_span, sweep_tick *tick, void *context) {
    const terrain *t = s->terrain;
    const unsigned quarter = number / SLICES, slice = number % SLICES;
    part p = {.sight = s, .swapped = quarter >= 2, .outward = quarter % 2 ? -1 : 1};
    p.eye = s->eye[p.swapped ? 0 : 1];
    p.aside = s->eye[p.swapped ? 1 : 0];
    p.rows = (long)(p.swapped ? t->nx : t->ny);
    p.length = (long)(p.swapped ? t->ny : t->nx);
    p.from = 2.0 * slice / SLICES - 1;
    p.until = 2.0 * (slice + 1) / SLICES - 1;
    p.target = target;
    p.visit = visit;
    p.visit_span = visit_span;
    p.context = context;
    p.bins = 1;
    p.width = p.until - p.from;
    p.columns_from = -1;
    p.ahead = -INFINITY;
    const size_t length = (size_t)p.length + 2 * PAD;
    p.of = malloc(sizeof *p.of);
    double *lines = calloc(5 * length, sizeof *lines);
    if (p.swapped) p.columns = malloc((COLUMNS_AT_ONCE + 1) * (size_t)p.length * sizeof *p.columns);
    bool good = cw_skyline_init(&p.line, p.from - 0x1p-10, p.until + 0x1p-10);
    good = good && p.of && lines && (p.columns || !p.swapped);
    if (good) {
        double **const line[5] = {&p.near_height, &p.far_height, &p.front, &p.back, &p.back_before};
        for (size_t k = 0; k < 5; k++) *line[k] = lines + k * length + PAD;
        *p.of = (bin){-INFINITY, {-INFINITY, -INFINITY, -INFINITY}, SKYLINE_FIRST};
        look_around(&p);
        good = sweep(&p, most, tick);
    }
    cw_skyline_free(&p.line);
    free(p.of);
    free(lines);
    free(p.columns);
    return good;
}
