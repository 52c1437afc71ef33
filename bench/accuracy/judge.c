/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/judge.h"

#include "bounds.h"

#include <float.h>
#include <math.h>

/* The ray at one t: how far it is above the surface, over which cell, and in which place of it. */
typedef struct ray_point {
    double above, i, j;
} ray_point;

static bounds_ray ray_of(const true_surface *on, const cw_ray *ray) {
    const double org[3] = {(double)ray->org[0], (double)ray->org[1], (double)ray->org[2]};
    const double dir[3] = {(double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2]};
    return bounds_ray_of(org, dir, on->nx, on->ny, on->low, on->high);
}

static double clamp(double x, double low, double high) { return fmax(low, fmin(high, x)); }

static ray_point point_at(const true_surface *on, const bounds_ray *r, double t) {
    const size_t nx = on->nx;
    const double x = clamp(r->org[0] + t * r->dir[0], 0, (double)(nx - 1));
    const double y = clamp(r->org[1] + t * r->dir[1], 0, (double)(on->ny - 1));
    const ray_point p = {.i = fmin(floor(x), (double)(nx - 2)), .j = fmin(floor(y), (double)(on->ny - 2))};
    const float *z = on->z + (size_t)p.j * nx + (size_t)p.i;
    const double h00 = (double)z[0], h10 = (double)z[1], h01 = (double)z[nx], h11 = (double)z[nx + 1];
    const double fx = x - p.i, fy = y - p.j;
    const double surface =
        fy > fx ? h00 + fx * (h11 - h01) + fy * (h01 - h00) : h00 + fx * (h10 - h00) + fy * (h11 - h10);
    return (ray_point){r->org[2] + t * r->dir[2] - surface, p.i, p.j};
}

/* Bounds of the cell and its neighbours, or of the whole field. */
static bounds_surface surface_around(const true_surface *on, const ray_point *p, double delta) {
    const size_t first_i = p->i > 0 ? (size_t)p->i - 1 : 0, first_j = p->j > 0 ? (size_t)p->j - 1 : 0;
    const size_t last_i = (size_t)p->i + 2 < on->nx ? (size_t)p->i + 2 : on->nx - 1;
    const size_t last_j = (size_t)p->j + 2 < on->ny ? (size_t)p->j + 2 : on->ny - 1;
    if (delta >= 0.5) return (bounds_surface){on->low, on->high, on->steepest};
    bounds_surface s = {INFINITY, -INFINITY, 0};
    for (size_t j = first_j; j <= last_j; j++)
        for (size_t i = first_i; i <= last_i; i++) {
            const float *z = on->z + j * on->nx + i;
            s.low = fmin(s.low, (double)z[0]);
            s.high = fmax(s.high, (double)z[0]);
            if (i < last_i) s.S = fmax(s.S, fabs((double)z[1] - (double)z[0]));
            if (j < last_j) s.S = fmax(s.S, fabs((double)z[on->nx] - (double)z[0]));
            if (i < last_i && j < last_j) s.S = fmax(s.S, fabs((double)z[on->nx + 1] - (double)z[0]));
        }
    return s;
}

/* How far from the surface the ray is clear of it at t, and how far a hit with that t may be. */
typedef struct slack {
    double clear, hit;
} slack;

static slack slack_at(const true_surface *on, const bounds_ray *r, double t, const ray_point *p,
                      const accuracy_claim *claim) {
    const double D = bounds_D(r, p->i, p->j);
    const bounds_surface s = surface_around(on, p, bounds_delta(r, D));
    const double clear = bounds_clear(r, D, s) + bounds_height_evaluation(r, t, s) + claim->height;
    const double steepest = fabs(r->dir[2]) + 2 * s.S * (fabs(r->dir[0]) + fabs(r->dir[1]));
    return (slack){clear, clear + bounds_height_of_t(t, steepest)};
}

/* ---- along the ray ---- */

/* A family of parallel lines that the ray crosses, at whole numbers: x, y, or x - y. */
typedef struct lines {
    double org, dir;
    double next, step; /* the number of the next line */
} lines;

static lines lines_from(double org, double dir, double t) {
    lines l = {.org = org, .dir = dir, .step = dir > 0 ? 1 : -1};
    if (dir == 0 || !isfinite(t)) return l;
    const double at = org + t * dir;
    l.next = dir > 0 ? floor(at) + 1 : ceil(at) - 1;
    return l;
}

static double lines_t(const lines *l) { return l->dir == 0 ? INFINITY : (l->next - l->org) / l->dir; }

/* Cuts [from, to] down to where org + t dir lies in [0, end]. */
static void cut(double org, double dir, double end, double *from, double *to) {
    if (dir == 0) {
        if (org < 0 || org > end) *to = -INFINITY;
        return;
    }
    const double a = (0 - org) / dir, b = (end - org) / dir;
    *from = fmax(*from, fmin(a, b));
    *to = fmin(*to, fmax(a, b));
}

accuracy_track accuracy_follow(const true_surface *on, const cw_ray *ray, double from, double to,
                               const accuracy_claim *claim) {
    const bounds_ray r = ray_of(on, ray);
    const double limit = (double)FLT_MAX / 2; /* as the library clamps t */
    from = fmax(from, fmax((double)ray->tmin, -limit));
    to = fmin(to, fmin((double)ray->tmax, limit));
    cut(r.org[0], r.dir[0], (double)(on->nx - 1), &from, &to);
    cut(r.org[1], r.dir[1], (double)(on->ny - 1), &from, &to);
    if (!(from <= to)) return (accuracy_track){0};
    lines all[3] = {lines_from(r.org[0], r.dir[0], from), lines_from(r.org[1], r.dir[1], from),
                    lines_from(r.org[0] - r.org[1], r.dir[0] - r.dir[1], from)};
    accuracy_track track = {.clear = true, .near = true};
    int side = 0;
    for (double t = from;;) {
        const ray_point p = point_at(on, &r, t);
        const slack s = slack_at(on, &r, t, &p, claim);
        const int now = p.above > s.clear ? 1 : p.above < -s.clear ? -1 : 0;
        track.passes = track.passes || (now != 0 && side != 0 && now != side);
        track.clear = track.clear && now != 0 && !track.passes;
        track.near = track.near && fabs(p.above) <= s.hit;
        if (now != 0) side = now;
        if (track.passes || t >= to) return track;
        double next = to;
        for (int k = 0; k < 3; k++) next = fmin(next, lines_t(&all[k]));
        for (int k = 0; k < 3; k++)
            if (lines_t(&all[k]) <= next) all[k].next += all[k].step;
        t = fmax(t, next);
    }
}

/* ---- the exact place ---- */

/* u and v come from sums in double of the ray's numbers, so they are off by some 2^-52 of those. A place that is outside
 * by no more is on the edge for all that is measured here: both triangles give the same t there but for that much. */
static bool is_inside(const true_surface *on, const cw_ray *ray, const exact_hit *p) {
    const bounds_ray r = ray_of(on, ray);
    const double off = 8 * bounds_place_evaluation(&r, p->t);
    return p->u >= -off && p->v >= -off && p->u + p->v <= 1 + off;
}

static const accuracy_claim none;

exact_hit accuracy_exact(const true_surface *on, const cw_ray *ray, const cw_hit *hit) {
    exact_hit own, p, best = {(double)hit->t, (double)hit->u, (double)hit->v, hit->i, hit->j, hit->triangle};
    const bool meets = exact_meet(on, ray, hit->i, hit->j, hit->triangle, &own);
    if (meets && is_inside(on, ray, &own)) return own;
    bool found = false;
    for (uint32_t k = 0; k < 18; k++) {
        const int32_t i = hit->i + (int32_t)(k / 2 % 3) - 1, j = hit->j + (int32_t)(k / 6) - 1;
        if (i < 0 || j < 0 || (size_t)i + 1 >= on->nx || (size_t)j + 1 >= on->ny) continue;
        if (!exact_meet(on, ray, i, j, k % 2, &p) || !is_inside(on, ray, &p)) continue;
        if (!accuracy_follow(on, ray, fmin(p.t, (double)hit->t), fmax(p.t, (double)hit->t), &none).near) continue;
        if (found && fabs(p.t - (double)hit->t) >= fabs(best.t - (double)hit->t)) continue;
        best = p;
        found = true;
    }
    return found || !meets ? best : own;
}

double accuracy_off_surface(const true_surface *on, const cw_ray *ray, double t) {
    const bounds_ray r = ray_of(on, ray);
    return fabs(point_at(on, &r, t).above);
}

/* ---- verdicts ---- */

/* True if a hit with that t is not on the surface, or not over the field at all. */
static bool is_away(const true_surface *on, const cw_ray *ray, double t, const accuracy_claim *claim) {
    if (!(isfinite(t) && t >= (double)ray->tmin && t <= (double)ray->tmax)) return true;
    const bounds_ray r = ray_of(on, ray);
    const double x = r.org[0] + t * r.dir[0], y = r.org[1] + t * r.dir[1];
    const double end_x = (double)(on->nx - 1), end_y = (double)(on->ny - 1);
    const double D = fmax(fmax(bounds_D(&r, 0, 0), bounds_D(&r, end_x, 0)),
                          fmax(bounds_D(&r, 0, end_y), bounds_D(&r, end_x, end_y)));
    const double delta = bounds_delta(&r, D) + bounds_place_of_t(&r, t) + bounds_place_evaluation(&r, t);
    if (x < -delta || x > end_x + delta || y < -delta || y > end_y + delta) return true;
    const ray_point p = point_at(on, &r, t);
    return fabs(p.above) > slack_at(on, &r, t, &p, claim).hit;
}

accuracy_verdict accuracy_judge_closest(const true_surface *on, const cw_ray *ray, const accuracy_claim *claim,
                                        const cw_hit *truth, const exact_hit *exact, const cw_hit *answer) {
    const bool hit = answer->i >= 0, should = exact != NULL;
    if (!hit) return accuracy_judge_any(on, ray, claim, should, false);
    const double t = (double)answer->t;
    if (should) {
        /* On the triangle that the truth names, a bad t is a bad t and no other surface. */
        if (answer->i == truth->i && answer->j == truth->j && answer->triangle == truth->triangle)
            return ACCURACY_RIGHT;
        const int32_t di = answer->i - exact->i, dj = answer->j - exact->j;
        if (di >= -1 && di <= 1 && dj >= -1 && dj <= 1 &&
            accuracy_follow(on, ray, fmin(t, exact->t), fmax(t, exact->t), claim).near)
            return ACCURACY_RIGHT;
        if (t > exact->t && accuracy_follow(on, ray, (double)ray->tmin, t, claim).passes) return ACCURACY_WRONG;
    }
    return is_away(on, ray, t, claim) ? ACCURACY_PHANTOM : ACCURACY_TIE;
}

accuracy_verdict accuracy_judge_any(const true_surface *on, const cw_ray *ray, const accuracy_claim *claim, bool truth,
                                    bool answer) {
    if (truth == answer) return ACCURACY_RIGHT;
    const accuracy_track track = accuracy_follow(on, ray, (double)ray->tmin, (double)ray->tmax, claim);
    if (truth) return track.passes ? ACCURACY_LEAK : ACCURACY_TIE;
    return track.clear ? ACCURACY_PHANTOM : ACCURACY_TIE;
}
