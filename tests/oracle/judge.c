/* SPDX-License-Identifier: Apache-2.0 */
/* What rounding excuses, by the bounds of papers/numerics.md: the clear pass, and verdicts. All in double, whose error
 * is 2^-27 of the bounds or less. */

#include "bounds.h"
#include "oracle_walk.h"

#include <math.h>

static double distance(const oracle *o, int32_t i, int32_t j) { return bounds_D(&o->bounds, i, j); }

static double delta(const oracle *o, int32_t i, int32_t j) { return bounds_delta(&o->bounds, distance(o, i, j)); }

static bounds_surface surface_at(const oracle *o, int32_t i, int32_t j) {
    return delta(o, i, j) < 0.5 ? o->cell[(size_t)j * (o->nx - 1) + (size_t)i].surface : o->all;
}

/* E near a cell. */
static double height_error(const oracle *o, int32_t i, int32_t j) {
    return bounds_E(&o->bounds, distance(o, i, j), surface_at(o, i, j));
}

/* Where |d|, in double, is more than this, the exact ray is clear. */
static double clear_error(const oracle *o, double t, int32_t i, int32_t j) {
    const bounds_surface s = surface_at(o, i, j);
    return bounds_clear(&o->bounds, distance(o, i, j), s) + bounds_height_evaluation(&o->bounds, t, s);
}

/* By how much d, in double, may be off. */
static double evaluation(const oracle *o, double t, int32_t i, int32_t j) {
    return bounds_height_evaluation(&o->bounds, t, surface_at(o, i, j));
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
    const double height = fabs(o->oz) + fabs(c->t * o->dz) + fmax(fabs(o->all.low), fabs(o->all.high));
    const double moves = fabs(o->dx) + fabs(o->dy);
    if (c->error * moves <= 0x1p-40 * place && c->error * fabs(o->dz) <= 0x1p-40 * height) return c->t;
    return exact_value(o, c);
}

/* The part of a segment that is safe from holes and borders; empty if a > b. */
static stretch safe_part(const oracle *o, const segment *s, double from, double to) {
    stretch part = {from, to};
    if (s->solid < s->count || s->count < s->whole) return (stretch){1, 0};
    const oracle_triangle *t = &s->triangle[0];
    const double margin = 2 * delta(o, t->i, t->j) + bounds_place_evaluation(&o->bounds, fmax(fabs(from), fabs(to)));
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

/* How far Möller-Trumbore's place may be off: quotients of sums of products of the origin, as seen from the cell, and
 * the direction; the divisor is d'. Infinite where rounding decides about the divisor, its reciprocal is no float, or a
 * product overflows. */
static double blur(const oracle *o, const oracle_triangle *t) {
    const plane p = oracle_plane(o, t);
    const bounds_ray *r = &o->bounds;
    const double x = bounds_D(r, t->i, t->j) - 1, z = fabs(r->from[2] - p.h) + r->spare[2], divisor = fabs(slope(o, t));
    const double flat = fabs(o->dx) + fabs(o->dy), steep = fabs(o->dz) + 2 * (fabs(p.a) + fabs(p.b)) * flat;
    const double terms = x * steep + z * flat, u = bounds_u(), least = 0x1p-146;
    if (32 * (u * steep + least) > divisor || divisor < 0x1p-126 || terms > 0x1p124) return (double)INFINITY;
    return (32 * u * terms + least * (x + z + 1)) / divisor;
}

static void note_pass(oracle *o, double at, const segment *change) {
    if (o->truth.passes) return;
    const oracle_triangle *t = &change->triangle[0];
    o->truth.passes = true;
    o->truth.pass_t = at;
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
            if (!(fabs(d) > clear_error(o, at, t->i, t->j))) continue;
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

bool oracle_names(const oracle_truth *truth, const oracle_triangle *t) {
    const oracle_triangle *at = truth->triangle, *end = at + truth->at;
    while (at < end && !(at->i == t->i && at->j == t->j && at->triangle == t->triangle)) at++;
    return at < end;
}

bool oracle_clear(const oracle *o, double at, int side, const oracle_triangle *over) {
    const double x = o->ox + at * o->dx, y = o->oy + at * o->dy, z = o->oz + at * o->dz;
    const double place = bounds_place_evaluation(&o->bounds, at);
    const int32_t last_i = (int32_t)o->nx - 1, last_j = (int32_t)o->ny - 1;
    if (over) {
        const double margin = 2 * delta(o, over->i, over->j) + place, inside = edge_distance(o, over, at);
        /* Near an edge it may count as over a neighbour, whose bounds are others. */
        const double error = inside > margin ? clear_error(o, at, over->i, over->j)
                                             : bounds_clear(&o->bounds, distance(o, over->i, over->j) + 2, o->all) +
                                                   bounds_height_evaluation(&o->bounds, at, o->all);
        return inside >= -place && x > margin && x < last_i - margin && y > margin && y < last_j - margin &&
               side * oracle_height(o, over, at) > error;
    }
    const double D = fmax(fmax(distance(o, 0, 0), distance(o, last_i, 0)),
                          fmax(distance(o, 0, last_j), distance(o, last_i, last_j)));
    const double margin = 2 * bounds_delta(&o->bounds, D) + place;
    const double error = bounds_clear(&o->bounds, D, o->all) + bounds_height_evaluation(&o->bounds, at, o->all);
    return x > margin && x < last_i - margin && y > margin && y < last_j - margin &&
           (side > 0 ? z - o->all.high > error : o->all.low - z > error);
}

hit_check oracle_check(oracle *o, const cw_hit *hit) {
    const oracle_triangle t = {hit->i, hit->j, hit->triangle};
    hit_check c = {.holds = false};
    if (!oracle_solid(o, t.i, t.j, t.triangle) || !(hit->t >= o->ray.tmin && hit->t <= o->ray.tmax)) return c;
    /* Doubles are off by less than 2^-26 of the bounds, and for a ray from afar by what its place is. */
    const double at = (double)hit->t, part = 0x1p-20;
    const double error = height_error(o, t.i, t.j) + bounds_height_of_t(at, slope(o, &t));
    const double d = fabs(oracle_height(o, &t, at)), d_uncertainty = part * error + evaluation(o, at, t.i, t.j);
    c.apart = -edge_distance(o, &t, at);
    c.apart_most = delta(o, t.i, t.j) + bounds_place_of_t(&o->bounds, at);
    c.residual = d / error;
    const double apart_uncertainty = part * c.apart_most + bounds_place_evaluation(&o->bounds, at);
    if (fabs(c.apart - c.apart_most) <= apart_uncertainty || fabs(d - error) <= d_uncertainty)
        c.holds = exact_within(o, &t, at, error, c.apart_most);
    else
        c.holds = c.apart <= c.apart_most && c.residual <= 1;
    return c;
}

/* What t and u, v of a hit may be off by: half an ulp if the exact ray meets the triangle farther than delta from its
 * edges, since then the root lies on the stretch that it is kept to; but a moved ray's range has rounded ends. */
static void check_digits(const oracle *o, const cw_hit *hit, judgement *j) {
    const oracle_triangle t = {hit->i, hit->j, hit->triangle};
    const double at = (double)hit->t, root_t = o->truth.t, divisor = fabs(slope(o, &t));
    const bounds_surface s = surface_at(o, t.i, t.j);
    const double D = distance(o, t.i, t.j), run = fabs(o->dx) + fabs(o->dy), steep = fabs(o->dz) + 2 * s.S * run;
    /* In double, the library's arithmetic and this one's. */
    const double doubles =
        0x1p-49 * (s.S * D + bounds_Z(&o->bounds, s) + fabs(at) * steep) + bounds_height_evaluation(&o->bounds, at, s);
    j->t_error = fabs(at - root_t);
    j->t_bound = (double)INFINITY;
    if (!(divisor > 0x1p-50 * steep)) return;
    const double root = doubles / divisor, rounding = ldexp(0x1p-24, ilogb(root_t)) + 0x1p-149 + root;
    j->t_bound = rounding + height_error(o, t.i, t.j) / divisor;
    const double place = bounds_place_evaluation(&o->bounds, at) + root * run;
    if (!(edge_distance(o, &t, root_t) > delta(o, t.i, t.j) + place)) return;
    const double end = fmin(fabs(root_t - (double)o->ray.tmin), fabs(root_t - (double)o->ray.tmax));
    if (o->bounds.moved && end <= bounds_end(&o->bounds, root_t) + root)
        return; /* the stretch may end before the root */
    j->t_bound = rounding;
    const double x = o->ox + root_t * o->dx - t.i, y = o->oy + root_t * o->dy - t.j;
    const double u = hit->triangle == CW_TRIANGLE_A ? x - y : x, v = hit->triangle == CW_TRIANGLE_A ? y : y - x;
    j->place_error = fmax(fabs((double)hit->u - u), fabs((double)hit->v - v));
    j->place_bound = 1.25 * 0x1p-24 + 2 * place;
}

judgement oracle_judge(oracle *o, const cw_hit *hit) {
    const oracle_truth *truth = &o->truth;
    if (hit->i < 0)
        return (judgement){.verdict = truth->passes ? VERDICT_LEAK : truth->hit ? VERDICT_TIE : VERDICT_RIGHT};
    const oracle_triangle t = {hit->i, hit->j, hit->triangle};
    const double latest = truth->pass_t + (bounds_u() + 0x1p-50) * fabs(truth->pass_t);
    judgement j = {.at = oracle_check(o, hit)};
    if (oracle_solid(o, t.i, t.j, t.triangle)) j.blur = blur(o, &t);
    j.verdict = !j.at.holds                                ? VERDICT_PHANTOM
                : truth->passes && (double)hit->t > latest ? VERDICT_WRONG_SURFACE
                : !oracle_names(truth, &t)                 ? VERDICT_TIE
                                                           : VERDICT_RIGHT;
    if (j.verdict == VERDICT_RIGHT) check_digits(o, hit, &j);
    return j;
}
