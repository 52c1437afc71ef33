/* SPDX-License-Identifier: Apache-2.0 */
/* The eye looks along rows of samples in four quarters, two in which rows are rows of the field and two in which they are
 * columns. In a quarter, a sample at distance r rows and x samples to the side is seen in direction u = x / r, and its rise
 * is w = height / r. Any place on an edge between two samples has a w between theirs, since directions and rises are a
 * projection of space; so for a small range of directions, a bin, the highest w of the samples of a row that are near it
 * bounds what the row, and the strip of triangles before it, shows there, and the lowest w of those that enclose it is a
 * rise that nothing behind can look over.
 *
 * Going outward row by row, each bin keeps the greatest of either. Where bins have become wider than half a cell they are cut
 * in two. A sample below the lower bound of its bin is hidden. One above the upper bound is seen unless something close by
 * hides it, which is looked at exactly: the last rows are left out of the upper bound because next to a sample the bound,
 * which takes in its neighbours, is blunt, and so is the first cell before the eye, where edges end behind it. Between the
 * bounds, what may hide a sample is mostly one ridge or two. Rows are therefore taken in blocks, and the upper bound is kept
 * for all of them, and with the highest one, two and three left out: these are looked at exactly, one after the other, and
 * seldom more than that. The rest is decided by following the line. So the bounds save work and never change an answer. */

#include "sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SLICES = SWEEP_PARTS / 4, NEAR = 4, BLOCK = 4, FIRST_REACH = 8, COLUMNS_AT_ONCE = 16, BESIDE = 4, AROUND = 32 };

/* A row as its bins see it: for samples from the one at or below a place on. */
typedef struct shown {
    float low;  /* of that sample and the two after it; -infinity if one is missing */
    float high; /* from the sample before that one to the third after it */
} shown;

/* A small range of directions: bounds of the rises in it so far. Rows are taken together in blocks; what rises highest is
 * most often one ridge or two, and all but the few highest blocks have a lower bound of their own. */
typedef struct bin {
    float low;
    float rest; /* over all rows outside the blocks */
    struct block {
        float high;
        int32_t number;     /* row / BLOCK */
    } blocks[SIGHT_PIECES]; /* the highest first */
} bin;

typedef struct part {
    const sight *sight;
    bool swapped;       /* rows are columns of the field */
    int outward;        /* +1 or -1 */
    double eye, aside;  /* the eye's place across the rows and along them */
    long rows, length;  /* of the field, in this sense */
    double from, until; /* directions */
    long reach;         /* rows for which the bins are narrow enough */
    double width;       /* of a bin */
    size_t bins;
    struct bin *of;        /* bins of them */
    long left, right;      /* samples of a row that are needed: left to right, without right */
    float *w;              /* the row's rises; BESIDE more on both sides */
    shown *kept[NEAR + 1]; /* of the last rows */
    long kept_left[NEAR + 1], kept_right[NEAR + 1];
    double around[AROUND]; /* rises next to the eye, in so many ranges of directions */
    float *columns;        /* COLUMNS_AT_ONCE columns of the field, as rows */
    long columns_from, columns_left, columns_right;
} part;

static double distance(const part *p, long row) { return fabs((double)row - p->eye); }

/* Samples that bins of the row may need. */
static void row_range(const part *p, double r, long *left, long *right) {
    const double a = floor(p->aside + r * p->from) - 2, b = floor(p->aside + r * p->until) + BESIDE,
                 end = (double)p->length;
    *left = a > 0 ? a < end ? (long)a : p->length : 0;
    *right = b > (double)*left ? b < end ? (long)b : p->length : *left;
}

/* Heights of a row from left on. A row that is a column is fetched with those that follow it, since each line of memory
 * holds samples of sixteen. */
static const float *fetch(part *p, long row, long left, long right) {
    const terrain *t = p->sight->terrain;
    if (!p->swapped) return t->z + (size_t)row * t->nx + left;
    const long first = row - row % COLUMNS_AT_ONCE;
    if (p->columns_from != first || left < p->columns_left || right > p->columns_right) {
        long l, r;
        /* The farthest of these columns is the widest. */
        const long last = first + COLUMNS_AT_ONCE - 1 < p->rows ? first + COLUMNS_AT_ONCE - 1 : p->rows - 1;
        const double far = fmax(distance(p, first), distance(p, last));
        row_range(p, far, &l, &r);
        p->columns_from = first;
        p->columns_left = l < left ? l : left;
        p->columns_right = r > right ? r : right;
        const long count = last - first + 1;
        for (long j = p->columns_left; j < p->columns_right; j++) {
            const float *z = t->z + (size_t)j * t->nx + first;
            for (long c = 0; c < count; c++) p->columns[(size_t)c * (size_t)p->length + (size_t)j] = z[c];
        }
    }
    return p->columns + (size_t)(row - first) * (size_t)p->length + left;
}

static double height_over_eye(const part *p, long row, long i, float z) {
    const sight *s = p->sight;
    return (double)z - s->eye[2] -
           (p->swapped ? sight_fall(s, (double)row, (double)i) : sight_fall(s, (double)i, (double)row));
}

/* The rises of a row, NaN where there is a hole or no field. w[0] is that of sample left - BESIDE. */
static void rises(part *p, long row, long left, long right) {
    const float *z = fetch(p, row, left, right);
    const double r = distance(p, row), per = 1 / r;
    for (int k = 0; k < BESIDE; k++) p->w[k] = p->w[BESIDE + (right - left) + k] = NAN;
    for (long i = left; i < right; i++) {
        const float w = (float)(height_over_eye(p, row, i, z[i - left]) * per);
        p->w[BESIDE + (i - left)] = w < INFINITY && w > -INFINITY ? w : NAN;
    }
}

static float least(float a, float b) { return a < b ? a : b; }
static float most(float a, float b) { return a > b ? a : b; } /* b if a is NaN */

/* What bins see of the row; entry 0 is for the sample left - 2. */
static void keep(part *p, long row, long left, long right) {
    const size_t slot = (size_t)row % (NEAR + 1);
    shown *to = p->kept[slot];
    p->kept_left[slot] = left - 2;
    p->kept_right[slot] = right;
    for (long i = left - 2; i < right; i++) {
        const float *w = p->w + BESIDE + (i - left);
        const float low = least(w[0], least(w[1], w[2]));
        float high = -INFINITY;
        for (int k = -1; k <= 3; k++) high = most(w[k], high); /* there are BESIDE more on both sides */
        to[i - (left - 2)] = (shown){isnan(w[0] + w[1] + w[2]) ? -INFINITY : low, high};
    }
}

static inline void raise(bin *b, float high, int32_t number) {
    if (high <= b->rest) return; /* which no block is below */
    struct block *last = &b->blocks[SIGHT_PIECES - 1];
    int k = 0;
    while (k < SIGHT_PIECES && b->blocks[k].number != number) k++;
    if (k < SIGHT_PIECES) {
        b->blocks[k].high = most(high, b->blocks[k].high);
    } else if (high > last->high) {
        b->rest = most(last->high, b->rest);
        *last = (struct block){high, number};
        k = SIGHT_PIECES - 1;
    } else {
        b->rest = most(high, b->rest);
        return;
    }
    for (; k > 0 && b->blocks[k].high > b->blocks[k - 1].high; k--) {
        const struct block up = b->blocks[k];
        b->blocks[k] = b->blocks[k - 1];
        b->blocks[k - 1] = up;
    }
}

/* Two bins as one. */
static void unite(bin *b, const bin *other) {
    b->low = least(b->low, other->low);
    b->rest = most(b->rest, other->rest);
    for (int k = 0; k < SIGHT_PIECES; k++) raise(b, other->blocks[k].high, other->blocks[k].number);
}

/* Bins take in a row, its lower bounds or its upper ones. */
static void take_in(part *p, long row, bool lower) {
    const size_t slot = (size_t)row % (NEAR + 1);
    const double r = distance(p, row), step = r * p->width, start = p->aside + r * p->from;
    const shown *from = p->kept[slot];
    const double first = (double)p->kept_left[slot], last = (double)p->kept_right[slot];
    /* Bins whose sample is there. */
    double b0 = ceil((first - start) / step), b1 = floor((last - start) / step);
    b0 = b0 > 0 ? b0 : 0;
    b1 = b1 < (double)p->bins - 1 ? b1 : (double)p->bins - 1;
    for (double b = b0; b <= b1; b++) {
        const double place = start + b * step - first; /* a cast is an instruction where floor may be a call */
        if (!(place >= 0 && place < last - first)) continue;
        const size_t n = (size_t)b, k = (size_t)place;
        if (lower)
            p->of[n].low = most(from[k].low, p->of[n].low);
        else
            raise(&p->of[n], from[k].high, (int32_t)(row / BLOCK));
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
    p->reach *= 2;
    return true;
}

/* Rises in the bins are rounded to float, as are products with them: 2^-22 of each is more than that. */
static double set_down(float w) { return (double)w - 0x1p-22 * fabs((double)w); }
static double set_up(float w) { return w == -INFINITY ? -INFINITY : (double)w + 0x1p-22 * fabs((double)w); }

/* The last rows were not taken into the upper bounds. So many cells from the sample something in them may rise by as much. */
void sweep_close(sweep_bounds *bounds, double height) {
    const part *p = bounds->part;
    const long row = (long)bounds->row;
    const double r = distance(p, row), u = bounds->direction;
    const float rise = (float)set_down((float)(height / r));
    bounds->high.close = NEAR;
    for (long m = NEAR; m > 0 && (double)m < r; m--) {
        const long at = row - m * p->outward;
        if (at < 0 || at >= p->rows) return;
        const size_t slot = (size_t)at % (NEAR + 1);
        /* A hair to the left, where what is kept of a sample has one more on that side than is needed. */
        const long i = (long)(p->aside + u * (r - (double)m) + 1 - 1e-6) - 1;
        if (i < p->kept_left[slot] || i >= p->kept_right[slot]) return;
        if (!(p->kept[slot][i - p->kept_left[slot]].high < rise)) return;
        bounds->high.close = (double)m;
    }
}

/* All triangles with a sample in the block, from the row before it to the row behind it. */
static sight_piece piece_of(const part *p, const struct block *b, double r) {
    const double one = (double)(b->number * BLOCK - 1) - p->eye, other = (double)((b->number + 1) * BLOCK) - p->eye;
    const double high = set_up(b->high) * r;
    return p->outward > 0 ? (sight_piece){one, other, high} : (sight_piece){-other, -one, high};
}

/* A direction at a border of two ranges, as far as rounding can tell, has the steeper rise. */
static double around(const part *p, double u) {
    const double place = (u - p->from) / (p->until - p->from) * AROUND;
    const int low = (int)(place - 1e-6), high = (int)(place + 1e-6);
    const double one = p->around[low < AROUND ? low : AROUND - 1], other = p->around[high < AROUND ? high : AROUND - 1];
    return one > other ? one : other;
}

static void look_around(part *p) {
    for (int k = 0; k < AROUND; k++) {
        double direction[2][2];
        for (int end = 0; end < 2; end++) {
            direction[end][p->swapped ? 0 : 1] = p->outward;
            direction[end][p->swapped ? 1 : 0] = p->from + (k + end) * ((p->until - p->from) / AROUND);
        }
        p->around[k] = sight_around(p->sight, direction[0], direction[1]);
    }
}

/* The samples of the row in these directions: the last part of a quarter has both ends. Directions of exactly 45 degrees
 * belong to the quarters whose rows are rows. */
static void visit_row(part *p, long row, double target, sweep_visit *visit, void *context) {
    const double r = distance(p, row);
    /* One more on both sides, which rounding may have left out: whose a sample is is told below, by the same numbers for all. */
    double a = floor(p->aside + r * p->from), b = ceil(p->aside + r * p->until);
    a = a > 0 ? a : 0;
    b = b < (double)(p->length - 1) ? b : (double)(p->length - 1);
    if (b < a) return;
    const float *z = fetch(p, row, (long)a, (long)b + 1);
    const double per_row = 1 / r, per_width = 1 / p->width;
    for (long i = (long)a; i <= (long)b; i++) {
        const float h = z[i - (long)a];
        const double x = (double)i - p->aside, u = x * per_row;
        const bool after = u >= p->from || p->from == -1, before = u < p->until || p->until == 1;
        const bool inside = p->swapped ? fabs(x) < r : fabs(x) <= r;
        if (!isfinite(h) || !(after && before && inside)) continue;
        const double place = (u - p->from) * per_width;
        const size_t whole = (size_t)place, n = whole < p->bins ? whole : p->bins - 1;
        /* A direction at a border of two bins, as far as rounding can tell, is seen by both. */
        bin here = p->of[n];
        if (n > 0 && place - (double)n < 1e-6) unite(&here, &p->of[n - 1]);
        if (n + 1 < p->bins && (double)(n + 1) - place < 1e-6) unite(&here, &p->of[n + 1]);
        const double height = height_over_eye(p, row, i, h), low = set_down(here.low) * r;
        if (low >= height + target) continue;
        sweep_bounds bounds = {.low = low, .part = p, .row = (double)row, .direction = u};
        bounds.high.close = bounds.high.near = NEAR;
        bounds.high.rest = set_up(here.rest) * r;
        bounds.high.eye = around(p, u) * r;
        for (int k = 0; k < SIGHT_PIECES; k++) bounds.high.pieces[k] = piece_of(p, &here.blocks[k], r);
        if (p->swapped)
            visit(context, (size_t)row, (size_t)i, height, &bounds);
        else
            visit(context, (size_t)i, (size_t)row, height, &bounds);
    }
}

static bool sweep(part *p, double far, double target, sweep_visit *visit, sweep_tick *tick, void *context) {
    /* The first row that is not the eye's own. */
    long row = p->outward > 0 ? (long)floor(p->eye) + 1 : (long)ceil(p->eye) - 1;
    if (p->outward > 0 ? row < 0 : row >= p->rows) row = p->outward > 0 ? 0 : p->rows - 1;
    long taken = row; /* into the upper bounds: up to this one, without it */
    for (; row >= 0 && row < p->rows && distance(p, row) <= far; row += p->outward) {
        if (!tick(context)) return true;
        const double r = distance(p, row);
        while (r > (double)p->reach)
            if (!refine(p)) return false;
        for (; (row - taken) * p->outward >= NEAR; taken += p->outward) take_in(p, taken, false);
        visit_row(p, row, target, visit, context);
        long left, right;
        row_range(p, r, &left, &right);
        rises(p, row, left, right);
        keep(p, row, left, right);
        take_in(p, row, true);
    }
    return true;
}

bool sweep_part(const sight *s, unsigned number, double far, double target, sweep_visit *visit, sweep_tick *tick,
                void *context) {
    const terrain *t = s->terrain;
    const unsigned quarter = number / SLICES, slice = number % SLICES;
    part p = {.sight = s, .swapped = quarter >= 2, .outward = quarter % 2 ? -1 : 1};
    p.eye = s->eye[p.swapped ? 0 : 1];
    p.aside = s->eye[p.swapped ? 1 : 0];
    p.rows = (long)(p.swapped ? t->nx : t->ny);
    p.length = (long)(p.swapped ? t->ny : t->nx);
    p.from = 2.0 * slice / SLICES - 1;
    p.until = 2.0 * (slice + 1) / SLICES - 1;
    p.reach = FIRST_REACH;
    p.bins = 2 * FIRST_REACH * 2 / SLICES;
    p.width = (p.until - p.from) / (double)p.bins;
    p.columns_from = -1;
    const size_t length = (size_t)p.length + 2 * BESIDE;
    p.of = malloc(p.bins * sizeof *p.of);
    p.w = malloc(length * sizeof *p.w);
    shown *kept = malloc((NEAR + 1) * length * sizeof *kept);
    if (p.swapped) p.columns = malloc(COLUMNS_AT_ONCE * (size_t)p.length * sizeof *p.columns);
    bool good = p.of && p.w && kept && (p.columns || !p.swapped);
    if (good) {
        for (size_t b = 0; b < p.bins; b++) {
            p.of[b] = (bin){.low = -INFINITY, .rest = -INFINITY};
            for (int k = 0; k < SIGHT_PIECES; k++) p.of[b].blocks[k] = (struct block){-INFINITY, -1 - k};
        }
        for (size_t k = 0; k <= NEAR; k++) p.kept[k] = kept + k * length;
        look_around(&p);
        good = sweep(&p, far, target, visit, tick, context);
    }
    free(p.of);
    free(p.w);
    free(kept);
    free(p.columns);
    return good;
}
