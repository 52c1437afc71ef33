/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/judge.h"

#include <float.h>
#include <math.h>

/* A ray over a field, in double: errors are 2^-29 of the slack. */
typedef struct course {
    const tradeoff_ground *on;
    double ox, oy, oz, dx, dy, dz;
    double length; /* of the direction */
    const tradeoff_claim *claim;
} course;

static course course_of(const tradeoff_ground *on, const cw_ray *ray, const tradeoff_claim *claim) {
    course c = {.on = on, .claim = claim};
    c.ox = (double)ray->org[0], c.oy = (double)ray->org[1], c.oz = (double)ray->org[2];
    c.dx = (double)ray->dir[0], c.dy = (double)ray->dir[1], c.dz = (double)ray->dir[2];
    c.length = sqrt(c.dx * c.dx + c.dy * c.dy + c.dz * c.dz);
    return c;
}

/* The ray at one t: its height above the surface, and what its rounding depends on. */
typedef struct station {
    double above;
    double size, slope; /* of the cell there: largest height, largest difference between neighbours */
    double place;       /* P of papers/numerics.md */
} station;

static double clamp(double x, double low, double high) { return fmax(low, fmin(high, x)); }

static station station_at(const course *c, double t) {
    const size_t nx = c->on->nx, ny = c->on->ny;
    const double x = clamp(c->ox + t * c->dx, 0, (double)(nx - 1)), y = clamp(c->oy + t * c->dy, 0, (double)(ny - 1));
    const double i = fmin(floor(x), (double)(nx - 2)), j = fmin(floor(y), (double)(ny - 2));
    const float *z = c->on->z + (size_t)j * nx + (size_t)i;
    const double h00 = (double)z[0], h10 = (double)z[1], h01 = (double)z[nx], h11 = (double)z[nx + 1];
    const double fx = x - i, fy = y - j;
    const double surface =
        fy > fx ? h00 + fx * (h11 - h01) + fy * (h01 - h00) : h00 + fx * (h10 - h00) + fy * (h11 - h10);
    return (station){
        .above = c->oz + t * c->dz - surface,
        .size = fmax(fmax(fabs(h00), fabs(h10)), fmax(fabs(h01), fabs(h11))),
        .slope = fmax(fmax(fabs(h10 - h00), fabs(h01 - h00)), fmax(fabs(h11 - h10), fabs(h11 - h01))),
        .place = fabs(c->ox) + fabs(c->oy) + i + j + 2,
    };
}

/* E of papers/numerics.md for a hit, and the claim. A crossing belongs to the cells on both its sides: the station before
 * brings the other cell's numbers. */
static double slack_at(const course *c, double t, const station *here, const station *before) {
    const double u = 0x1p-24 * (1 + 0x1p-19), across = fabs(c->dx) + fabs(c->dy);
    const double size = fmax(here->size, before->size), slope = fmax(here->slope, before->slope);
    const double place = fmax(here->place, before->place);
    const double crossing = u * (fabs(c->oz) + fabs(t * c->dz) + 4 * size + 8 * slope * place) +
                            0x1p-146 * (1 + fabs(c->dz) + slope * across);
    /* The longest stay in a cell, and how much the height above the surface changes in it. */
    const double rounded = 1 + 6 * u * place, slab = fabs(c->oz) + 5 * c->on->highest;
    const double stay = fmin(fmin(rounded / fabs(c->dx), rounded / fabs(c->dy)), 2 * slab / fabs(c->dz));
    const double root = u * fmin(7 * slab, 5 * (fabs(c->dz) + slope * across) * stay);
    return crossing + root + c->claim->height + c->claim->cone * fabs(t) * c->length;
}

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

tradeoff_track tradeoff_follow(const tradeoff_ground *on, const cw_ray *ray, double from, double to,
                               const tradeoff_claim *claim) {
    const course c = course_of(on, ray, claim);
    const double limit = (double)FLT_MAX / 2; /* as the library clamps t */
    from = fmax(from, fmax((double)ray->tmin, -limit));
    to = fmin(to, fmin((double)ray->tmax, limit));
    cut(c.ox, c.dx, (double)(on->nx - 1), &from, &to);
    cut(c.oy, c.dy, (double)(on->ny - 1), &from, &to);
    if (!(from <= to)) return (tradeoff_track){0};
    lines all[3] = {lines_from(c.ox, c.dx, from), lines_from(c.oy, c.dy, from),
                    lines_from(c.ox - c.oy, c.dx - c.dy, from)};
    tradeoff_track track = {.clear = true, .near = true};
    int side = 0;
    station before = station_at(&c, from);
    for (double t = from;;) {
        const station here = station_at(&c, t);
        const double slack = slack_at(&c, t, &here, &before);
        const int now = here.above > slack ? 1 : here.above < -slack ? -1 : 0;
        track.passes = track.passes || (now != 0 && side != 0 && now != side);
        track.clear = track.clear && now != 0 && !track.passes;
        track.near = track.near && now == 0;
        if (now != 0) side = now;
        if (track.passes || t >= to) return track;
        before = here;
        double next = to;
        for (int k = 0; k < 3; k++) next = fmin(next, lines_t(&all[k]));
        for (int k = 0; k < 3; k++)
            if (lines_t(&all[k]) <= next) all[k].next += all[k].step;
        t = fmax(t, next);
    }
}

/* u and v come from sums in double of the ray's numbers, so they are off by some 2^-52 of those. A place that is outside
 * by no more is on the edge for all that is measured here: both triangles give the same t there but for that much. */
static bool is_inside(const cw_ray *ray, const tradeoff_place *p) {
    const double size = fabs((double)ray->org[0]) + fabs((double)ray->org[1]) + p->i + p->j + 2 +
                        fabs(p->t) * (fabs((double)ray->dir[0]) + fabs((double)ray->dir[1]));
    const double slack = 0x1p-48 * size;
    return p->u >= -slack && p->v >= -slack && p->u + p->v <= 1 + slack;
}

tradeoff_place tradeoff_exact(const tradeoff_ground *on, const cw_ray *ray, const cw_hit *hit) {
    static const tradeoff_claim none;
    tradeoff_place own, best = {.t = INFINITY};
    const bool meets = tradeoff_meet(on, ray, hit->i, hit->j, hit->triangle, &own);
    if (meets && is_inside(ray, &own)) return own;
    bool found = false;
    for (int32_t j = hit->j - 1; j <= hit->j + 1; j++)
        for (int32_t i = hit->i - 1; i <= hit->i + 1; i++)
            for (uint32_t triangle = 0; triangle < 2; triangle++) {
                if (i < 0 || j < 0 || (size_t)i + 1 >= on->nx || (size_t)j + 1 >= on->ny) continue;
                tradeoff_place p;
                if (!tradeoff_meet(on, ray, i, j, triangle, &p) || !is_inside(ray, &p)) continue;
                const double first = fmin(p.t, (double)hit->t), last = fmax(p.t, (double)hit->t);
                if (!tradeoff_follow(on, ray, first, last, &none).near) continue;
                if (found && fabs(p.t - (double)hit->t) >= fabs(best.t - (double)hit->t)) continue;
                best = p;
                found = true;
            }
    if (found) return best;
    if (meets) return own;
    return (tradeoff_place){.t = (double)hit->t,
                            .u = (double)hit->u,
                            .v = (double)hit->v,
                            .i = hit->i,
                            .j = hit->j,
                            .triangle = hit->triangle};
}

/* True if the ray is clear of the surface at t, or not over the field at all. */
static bool is_away(const tradeoff_ground *on, const cw_ray *ray, double t, const tradeoff_claim *claim) {
    if (!isfinite(t)) return true;
    const course c = course_of(on, ray, claim);
    const double x = c.ox + t * c.dx, y = c.oy + t * c.dy;
    const double end_x = (double)(on->nx - 1), end_y = (double)(on->ny - 1);
    const double delta = 0x1p-22 * (fabs(c.ox) + fabs(c.oy) + end_x + end_y + 2);
    if (x < -delta || x > end_x + delta || y < -delta || y > end_y + delta) return true;
    const station here = station_at(&c, t);
    return fabs(here.above) > slack_at(&c, t, &here, &here);
}

double tradeoff_off_surface(const tradeoff_ground *on, const cw_ray *ray, double t) {
    static const tradeoff_claim none;
    const course c = course_of(on, ray, &none);
    return fabs(station_at(&c, t).above);
}

static bool are_neighbours(const cw_hit *a, const tradeoff_place *b) {
    const int32_t di = a->i - b->i, dj = a->j - b->j;
    return di >= -1 && di <= 1 && dj >= -1 && dj <= 1;
}

tradeoff_verdict tradeoff_judge_closest(const tradeoff_ground *on, const cw_ray *ray, const tradeoff_claim *claim,
                                        const cw_hit *truth, const tradeoff_place *exact, const cw_hit *answer) {
    const bool hit = answer->i >= 0, should = exact != NULL;
    if (!hit && !should) return TRADEOFF_RIGHT;
    if (!hit) return tradeoff_judge_any(on, ray, claim, true, false);
    const double t = (double)answer->t;
    if (should) {
        /* On the triangle that the truth names, a bad t is a bad t and no other surface. */
        if (answer->i == truth->i && answer->j == truth->j && answer->triangle == truth->triangle)
            return TRADEOFF_RIGHT;
        const double first = fmin(t, exact->t), last = fmax(t, exact->t);
        if (are_neighbours(answer, exact) && tradeoff_follow(on, ray, first, last, claim).near) return TRADEOFF_RIGHT;
        if (t > exact->t && tradeoff_follow(on, ray, (double)ray->tmin, t, claim).passes) return TRADEOFF_WRONG;
    }
    return is_away(on, ray, t, claim) ? TRADEOFF_PHANTOM : TRADEOFF_TIE;
}

tradeoff_verdict tradeoff_judge_any(const tradeoff_ground *on, const cw_ray *ray, const tradeoff_claim *claim,
                                    bool truth, bool answer) {
    if (truth == answer) return TRADEOFF_RIGHT;
    const tradeoff_track track = tradeoff_follow(on, ray, (double)ray->tmin, (double)ray->tmax, claim);
    if (truth) return track.passes ? TRADEOFF_LEAK : TRADEOFF_TIE;
    return track.clear ? TRADEOFF_PHANTOM : TRADEOFF_TIE;
}
