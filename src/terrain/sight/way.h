/* SPDX-License-Identifier: Apache-2.0 */
/* The straight way from a target back to the eye, and the edges of the surface that it crosses: on lines of samples
 * x = n and y = n, and on diagonals x - y = n.
 *
 * Places are computed in double, so each comes with a bound on its error. If the answer must be certain, touch.c
 * decides where the bound leaves it open. */
#ifndef CELLWALK_TERRAIN_WAY_H
#define CELLWALK_TERRAIN_WAY_H

#include "exact.h"
#include "sight.h"

#include <math.h>

/* The kinds of lines that edges lie on: each has its number x = n, y = n or x - y = n. */
enum { WAY_COLUMN, WAY_ROW, WAY_DIAGONAL, WAY_KINDS };

/* place[a] + share step[a] is where the way is, from the corner of the eye's cell; share is 0 at the target, 1 at the
 * eye. a is 0 for x, 1 for y, and 2, a WAY_DIAGONAL, for x - y. Lines are numbered from there, too. */
typedef struct way {
    const sight *sight;
    double target[2]; /* of the field, exact; place: rounded */
    double place[WAY_KINDS], step[WAY_KINDS];
    double place_low; /* the error of the rounded difference x - y at the target */
    double length;    /* cells along the longer axis */
    int longer;
    double z, above; /* the target's height is z + above, in the samples' numbers */
    double fall;     /* the lowering at the target */
    double top;      /* the target's height over the eye, lowered: z + above - eye - fall, rounded */
    double slack;    /* computed places are within so many cells of the true ones */
    double rough;    /* the bound on the error of a height over the line, without the part of the edge's own heights */
    bool gaps;       /* crossings where there is no surface are seen, too */
} way;

/* Computed shares of the way are within this of the true ones. */
static const double way_share_error = 0x1p-49;

typedef struct crossing {
    const way *way;
    int kind;
    double n;      /* of the line */
    double other;  /* the place on it: y, or x on a row or a diagonal */
    double share;  /* of the way, from the eye */
    double height; /* of the surface over the eye, lowered; NaN where there is no surface */
    /* The greatest difference of heights between neighbours on the edge; on two edges where the crossing is so near
     * to a sample that it may be on either. */
    double steps;
    bool at_sample;
} crossing;

/* A share is off by up to 3.5 2^-52 of it: on diagonals 1.5 for the step, 1 for n less the target's diagonal, and 0.5
 * each for the division and the product. A place is off by that part of the step and by three more roundings, which
 * is less than half of slack. A height over the line is off by 2^-49 of each of its parts and the line's; the
 * lowering enters by the square of a share. rough exceeds the sum of these, without the edge's own heights. */
static inline way way_to(const sight *s, double i, double j, double z, double above) {
    way w = {.sight = s, .target = {i, j}, .step = {s->eye[0] - i, s->eye[1] - j}, .z = z, .above = above};
    w.place[0] = i - s->corner[0];
    w.place[1] = j - s->corner[1];
    const double x = fabs(w.step[0]), y = fabs(w.step[1]);
    w.longer = y > x;
    w.length = w.longer ? y : x;
    w.fall = sight_fall(s, i, j);
    w.top = z + above - s->eye[2] - w.fall;
    double eye_low;
    const double eye_diagonal = exact_two_sum(s->near[0], -s->near[1], &eye_low);
    w.place[WAY_DIAGONAL] = exact_two_sum(w.place[0], -w.place[1], &w.place_low);
    w.step[WAY_DIAGONAL] = (eye_diagonal - w.place[WAY_DIAGONAL]) + (eye_low - w.place_low);
    w.slack = 0x1p-48 * (x + y) + 0x1p-51 * (fabs(w.place[0]) + fabs(w.place[1]));
    const double falls = fabs(s->fall[0]) + fabs(s->fall[1]) + fabs(s->fall[2]), far = x + y + 2;
    w.rough = 0x1p-48 * (fabs(z) + fabs(above) + fabs(s->eye[2]) + falls * far * far) + w.slack * falls;
    return w;
}

/* Sees a crossing. True ends the way. */
typedef bool way_look(void *context, const crossing *c);

static inline double way_at(double from, double step, double share) { return from + share * step; }

/* Places on the way are within 2^24 of the field. A cast is an instruction where floor may be a call. */
static inline double whole_below(double x) {
    const double n = (double)(long)x;
    return n > x ? n - 1 : n;
}
static inline double whole_above(double x) { return -whole_below(-x); }

/* The sample number m along a line, or NULL outside the field. */
static inline const float *way_sample(const sight *s, int kind, double n, double m) {
    const terrain *t = s->terrain;
    const double x = kind == WAY_COLUMN ? n : m, y = kind == WAY_COLUMN ? m : kind == WAY_ROW ? n : m - n;
    const size_t i = (size_t)((long)x + (long)s->corner[0]), j = (size_t)((long)y + (long)s->corner[1]); /* < 0 wraps */
    return i < t->nx && j < t->ny ? terrain_row(t, j) + i : NULL;
}

/* The surface at a crossing. The lowering is a quadratic form q around the eye: q(s v) = s² q(v), and a mean of its
 * values at two ends of an edge e, at f of it, is the value there plus f (1 - f) q(e). */
static inline void way_height(crossing *c) {
    const way *w = c->way;
    const sight *s = w->sight;
    double first = whole_below(c->other + 0.5);
    c->at_sample = fabs(c->other - first) <= w->slack;
    if (!c->at_sample) first = whole_below(c->other);
    const float *z = way_sample(s, c->kind, c->n, first), *next = way_sample(s, c->kind, c->n, first + 1);
    c->height = NAN;
    if (z == NULL || !(c->at_sample || next)) return;
    double height = (double)*z;
    if (c->at_sample) {
        const float *before = way_sample(s, c->kind, c->n, first - 1);
        c->steps = next ? fmax(fabs((double)*next - height), 0) : 0; /* holes do not count */
        if (before) c->steps = fmax(c->steps, fabs((double)*before - height));
    } else {
        const double along = c->other - first, step = (double)*next - height;
        const double edge = s->at_crossings         ? 0
                            : c->kind == WAY_COLUMN ? s->fall[2]
                            : c->kind == WAY_ROW    ? s->fall[0]
                                                    : s->fall[0] + s->fall[1] + s->fall[2];
        height += along * step - along * (1 - along) * edge;
        c->steps = fabs(step);
    }
    c->height = height - (s->eye[2] + c->share * c->share * w->fall);
}

/* The crossings between two shares, a <= b, both included, and some that are within rounding of them, so that none
 * is lost between two stretches. */
static inline bool look_between(const way *w, double a, double b, way_look *look, void *context) {
    const double *p = w->place, *d = w->step;
    for (int kind = WAY_COLUMN; kind < WAY_KINDS; kind++) {
        if (d[kind] == 0) continue; /* along the lines */
        const double from = way_at(p[kind], d[kind], a), to = way_at(p[kind], d[kind], b), per_step = 1 / d[kind];
        const double low = whole_above((from < to ? from : to) - w->slack),
                     high = whole_below((from < to ? to : from) + w->slack);
        const double place_low = kind == WAY_DIAGONAL ? w->place_low : 0;
        const int other = kind == WAY_COLUMN ? 1 : 0;
        for (double n = low; n <= high; n++) {
            const double share = (n - p[kind] - place_low) * per_step;
            /* A share of 0 is exact: the line goes through the target. */
            if (!(share > 0 && share < 1 + way_share_error)) continue;
            crossing c = {w, kind, n, .other = way_at(p[other], d[other], share), .share = 1 - share};
            way_height(&c);
            if ((isfinite(c.height) || w->gaps) && look(context, &c)) return true;
        }
    }
    return false;
}

/* ---- touches: whether the surface blocks a line at a crossing, decided exactly for the numbers that are given: the
 * samples, the eye, the target, and lowerings as sight_fall rounds them ---- */

/* How far the surface is above the line where the two cross, in exact arithmetic. */
typedef struct touch {
    bool crosses;  /* between eye and target, both left out */
    int side;      /* 1: the surface is above the line, 0: it touches, -1: below */
    double excess; /* the target would have to be that much higher to touch, rounded */
} touch;

/* c has its line, kind and n, and its place on that, which may be off by the way's slack. */
touch cw_touch_at(const crossing *c);

#endif
