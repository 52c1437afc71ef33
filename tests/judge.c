/* SPDX-License-Identifier: Apache-2.0 */
/* What rounding excuses: the bounds E and delta of papers/numerics.md, the clear pass, and verdicts. All in double, whose
 * error is 2^-29 of the bounds. */

#include "oracle_walk.h"

#include <float.h>
#include <math.h>

/* Relative rounding error of a float operation. The reciprocal of a direction above 2^126 is denormal and off by up to
 * 2^-150 absolutely. */
static double unit(const oracle *o) {
    const double fastest = fmax(fmax(fabs(o->dx), fabs(o->dy)), fabs(o->dx - o->dy));
    return 0x1p-24 + 0x1p-150 * fastest;
}

/* Size of the numbers that a place is computed from. */
static double place_size(const oracle *o, double t, int32_t i, int32_t j) {
    return fabs(o->ox) + fabs(o->oy) + fabs(t) * (fabs(o->dx) + fabs(o->dy)) + i + j + 2;
}

static double delta(const oracle *o, double t, int32_t i, int32_t j) {
    return 8 * unit(o) * place_size(o, t, i, j) + 0x1p-148 * (fabs(o->dx) + fabs(o->dy));
}

/* E(t) near a cell; span is the size of d at the ends of the stretch that a hit was interpolated on. */
static double height_error(const oracle *o, double t, int32_t i, int32_t j, double span) {
    const cell_bounds *b = delta(o, t, i, j) < 0.5 ? &o->cell[(size_t)j * (o->nx - 1) + (size_t)i] : &o->all;
    const double size = fabs(o->oz) + fabs(t * o->dz) + b->high + b->slope * place_size(o, t, i, j) + span;
    return 8 * unit(o) * size + 0x1p-146 * (1 + fabs(o->dz) + b->slope * (fabs(o->dx) + fabs(o->dy)));
}

/* ---- the clear pass ---------------------------------------------------------------------------------------------- */

/* t from a to b. */
typedef struct stretch {
    double a, b;
} stretch;

/* Keeps the part of the stretch on which f0 + f1 t >= margin. */
static void keep(stretch *s, double f0, double f1, double margin) {
    if (f1 == 0) {
        if (f0 < margin) s->b = -(double)INFINITY;
        return;
    }
    const double t = (margin - f0) / f1;
    if (f1 > 0)
        s->a = fmax(s->a, t);
    else
        s->b = fmin(s->b, t);
}

static bool vertex_solid(const oracle *o, int32_t i, int32_t j) {
    return oracle_solid(o, i, j, CW_TRIANGLE_A) && oracle_solid(o, i, j, CW_TRIANGLE_B) &&
           oracle_solid(o, i - 1, j, CW_TRIANGLE_A) && oracle_solid(o, i, j - 1, CW_TRIANGLE_B) &&
           oracle_solid(o, i - 1, j - 1, CW_TRIANGLE_A) && oracle_solid(o, i - 1, j - 1, CW_TRIANGLE_B);
}

/* Keeps what is farther than margin from everything beside the triangle that is not solid. x and y are measured from
 * (i, j); by mirroring x and y a triangle B becomes an A: y >= 0, x <= 1, x >= y. */
static void keep_off_holes(const oracle *o, stretch *s, const oracle_triangle *t, double margin) {
    const bool a = t->triangle == CW_TRIANGLE_A;
    const int32_t i = t->i, j = t->j;
    const double fx = o->ox - i, fy = o->oy - j;
    const double x0 = a ? fx : fy, x1 = a ? o->dx : o->dy, y0 = a ? fy : fx, y1 = a ? o->dy : o->dx;
    const uint32_t other = a ? CW_TRIANGLE_B : CW_TRIANGLE_A;
    if (!oracle_solid(o, a ? i : i - 1, a ? j - 1 : j, other)) keep(s, y0, y1, margin);
    if (!oracle_solid(o, a ? i + 1 : i, a ? j : j + 1, other)) keep(s, 1 - x0, -x1, margin);
    if (!oracle_solid(o, i, j, other)) keep(s, x0 - y0, x1 - y1, margin);
    if (!vertex_solid(o, i, j)) keep(s, x0, x1, margin);
    if (!vertex_solid(o, a ? i + 1 : i, a ? j : j + 1)) keep(s, 1 - x0 + y0, y1 - x1, margin);
    if (!vertex_solid(o, i + 1, j + 1)) keep(s, 1 - y0, -y1, margin);
}

/* t of a crossing; exact where the double could be off by more than 2^-15 of the bounds. */
static double value(oracle *o, const crossing *c) {
    const double place = fabs(o->ox) + fabs(o->oy) + fabs(c->t) * (fabs(o->dx) + fabs(o->dy)) + 2;
    const double height = fabs(o->oz) + fabs(c->t * o->dz) + o->all.high;
    const double moves = fabs(o->dx) + fabs(o->dy);
    if (c->error * moves <= 0x1p-40 * place && c->error * fabs(o->dz) <= 0x1p-40 * height) return c->t;
    return exact_value(&o->numbers, c);
}

/* The part of a segment that is safe from holes and borders; empty if a > b. */
static stretch safe_part(const oracle *o, const segment *s, double from, double to) {
    stretch part = {from, to};
    if (s->solid < s->count || s->count < s->whole) return (stretch){1, 0};
    const oracle_triangle *t = &s->triangle[0];
    const double margin = 2 * fmax(delta(o, from, t->i, t->j), delta(o, to, t->i, t->j));
    if (margin >= 1) { /* so far from the origin that places are off by cells */
        if (o->holes) return (stretch){1, 0};
        keep(&part, o->ox, o->dx, margin);
        keep(&part, (double)(o->nx - 1) - o->ox, -o->dx, margin);
        keep(&part, o->oy, o->dy, margin);
        keep(&part, (double)(o->ny - 1) - o->oy, -o->dy, margin);
    } else if (!o->cell[(size_t)t->j * (o->nx - 1) + (size_t)t->i].all_solid) {
        for (unsigned k = 0; k < s->count; k++) keep_off_holes(o, &part, &s->triangle[k], margin);
    }
    return part;
}

static double minimum3(double a, double b, double c) { return fmin(a, fmin(b, c)); }

/* Least distance, measured along x or y or as x - y, from a triangle's three edges; negative outside. */
static double edge_distance(const oracle *o, const oracle_triangle *t, double at) {
    const double x = o->ox + at * o->dx - t->i, y = o->oy + at * o->dy - t->j;
    return t->triangle == CW_TRIANGLE_A ? minimum3(y, 1 - x, x - y) : minimum3(x, 1 - y, y - x);
}

static double slope(const oracle *o, const oracle_triangle *t) {
    const plane p = oracle_plane(o, t);
    return o->dz - p.a * o->dx - p.b * o->dy;
}

/* How far Möller-Trumbore's place may be off: quotients of sums of products of the origin, as seen from the cell, and the
 * direction; the divisor is d'. Infinite where rounding decides about the divisor, its reciprocal is no float, or a
 * product overflows. */
static double blur(const oracle *o, const oracle_triangle *t) {
    const plane p = oracle_plane(o, t);
    const double x = fabs(o->ox - t->i) + fabs(o->oy - t->j) + 1, z = fabs(o->oz - p.h), divisor = fabs(slope(o, t));
    const double flat = fabs(o->dx) + fabs(o->dy), steep = fabs(o->dz) + 2 * (fabs(p.a) + fabs(p.b)) * flat;
    const double terms = x * steep + z * flat, u = unit(o), least = 0x1p-146;
    if (32 * (u * steep + least) > divisor || divisor < 0x1p-126 || terms > 0x1p124) return (double)INFINITY;
    return (32 * u * terms + least * (x + z + 1)) / divisor;
}

static void note_pass(oracle *o, double at, const segment *change) {
    if (o->truth.passes) return;
    const oracle_triangle *t = &change->triangle[0];
    o->truth.passes = true;
    o->truth.pass_t = at;
    o->truth.pass_triangle = *t;
    o->truth.pass_blur = blur(o, t);
    const double near = change->from.t, root = near - oracle_height(o, t, near) / slope(o, t);
    o->truth.pass_edge = edge_distance(o, t, root);
}

void oracle_find_pass(oracle *o) {
    int last = 0;                 /* the side on which the ray was clear */
    const segment *change = NULL; /* where it changed sides since */
    for (size_t k = 0; k < o->segments && !o->truth.passes; k++) {
        const segment *s = &o->segment[k];
        const double from = value(o, &s->from), to = value(o, &s->to);
        const stretch part = safe_part(o, s, from, to);
        if (!(part.a <= part.b)) {
            last = 0;
            continue;
        }
        if (part.a > from) last = 0;
        for (int end = 0; end < 2; end++) {
            const oracle_triangle *t = &s->triangle[0];
            const double at = end ? part.b : part.a, d = oracle_height(o, t, at);
            if (end && s->side_from != s->side_to) change = s;
            if (!(fabs(d) > height_error(o, at, t->i, t->j, 0))) continue;
            const int clear = d > 0 ? 1 : -1;
            if (last && clear != last) note_pass(o, at, change ? change : s);
            last = clear;
        }
        if (part.b < to) last = 0;
    }
}

/* ---- verdicts ---------------------------------------------------------------------------------------------------- */

const char *verdict_name(verdict v) {
    static const char *const names[VERDICTS] = {"right", "tie", "leak", "phantom", "wrong surface"};
    return names[v];
}

static bool holds_the_point(const oracle_truth *truth, const cw_hit *hit) {
    for (unsigned k = 0; truth->hit && k < truth->at; k++) {
        const oracle_triangle *t = &truth->triangle[k];
        if (t->i == hit->i && t->j == hit->j && t->triangle == hit->triangle) return true;
    }
    return false;
}

judgement oracle_judge(const oracle *o, const cw_hit *hit) {
    const oracle_truth *truth = &o->truth;
    judgement j = {.verdict = VERDICT_RIGHT};
    if (hit->i < 0) {
        j.verdict = truth->passes ? VERDICT_LEAK : truth->hit ? VERDICT_TIE : VERDICT_RIGHT;
        return j;
    }
    const oracle_triangle t = {hit->i, hit->j, hit->triangle};
    const double at = (double)hit->t;
    j.verdict = VERDICT_PHANTOM;
    if (!oracle_solid(o, t.i, t.j, t.triangle) || !(hit->t >= o->ray.tmin && hit->t <= o->ray.tmax)) return j;
    j.blur = blur(o, &t);
    j.apart = -edge_distance(o, &t, at);
    /* A cell is crossed within a range of t that is no longer than this. */
    const double range = (double)o->ray.tmax - (double)o->ray.tmin;
    const double across = minimum3(1 / fabs(o->dx), 1 / fabs(o->dy), range);
    const double span = fmin(fabs(o->oz) + 3 * o->all.high, fabs(o->dz) * across);
    const double error = height_error(o, at, t.i, t.j, span);
    j.residual = fabs(oracle_height(o, &t, at)) / error;
    if (j.apart > 2 * delta(o, at, t.i, t.j) || !(j.residual <= 1)) return j;
    if (truth->passes && at > truth->pass_t + 8 * unit(o) * fabs(truth->pass_t)) {
        j.verdict = VERDICT_WRONG_SURFACE;
        return j;
    }
    if (!holds_the_point(truth, hit)) {
        j.verdict = VERDICT_TIE;
        return j;
    }
    j.verdict = VERDICT_RIGHT;
    j.t_error = fabs(at - truth->t);
    j.t_bound = error / fabs(slope(o, &t)) + 0x1p-23 * fabs(at) + 0x1p-148;
    return j;
}
