/* SPDX-License-Identifier: Apache-2.0 */
#include "rays.h"

#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- places ------------------------------------------------------------------------------------------------------ */

static double sign(random_state *r) { return random_bits(r) >> 63 ? 1 : -1; }

/* One in so many. */
static bool rarely(random_state *r, size_t in) { return random_below(r, in) == 0; }

/* The field's extent in height, never 0: the unit of heights above or below it. */
static double tall(const test_field *f) {
    const double span = (double)f->high - (double)f->low, size = fmax(fabs((double)f->low), fabs((double)f->high));
    return span > 0 ? span : size > 0 ? size : 1;
}

static double height_at(const test_field *f, size_t i, size_t j) {
    const double z = (double)f->z[j * f->nx + i];
    return isnan(z) ? (double)f->low : z;
}

/* A place on the surface of a cell, x and y within it. */
static void surface(const test_field *f, const size_t cell[2], double x, double y, double p[3]) {
    const size_t i = cell[0], j = cell[1];
    const double h00 = height_at(f, i, j), h11 = height_at(f, i + 1, j + 1);
    const double corner = x >= y ? height_at(f, i + 1, j) : height_at(f, i, j + 1);
    const double longer = fmax(x, y), shorter = fmin(x, y);
    p[0] = (double)i + x;
    p[1] = (double)j + y;
    p[2] = h00 + longer * (corner - h00) + shorter * (h11 - corner);
}

static void random_in_box(const test_field *f, random_state *r, double p[3]) {
    p[0] = random_between(r, 0, (double)(f->nx - 1));
    p[1] = random_between(r, 0, (double)(f->ny - 1));
    p[2] = random_between(r, (double)f->low, (double)f->high);
}

typedef enum aim { ANYWHERE, VERTEX, BORDER, DIAGONAL } aim;

/* A place on the surface of a random cell. */
static void take_aim(aim at, const test_field *f, random_state *r, size_t cell[2], double p[3]) {
    cell[0] = random_below(r, f->nx - 1);
    cell[1] = random_below(r, f->ny - 1);
    double x = random_unit(r), y = random_unit(r);
    if (at == VERTEX) x = rint(x), y = rint(y);
    if (at == BORDER) *(random_below(r, 2) ? &x : &y) = (double)random_below(r, 2);
    if (at == DIAGONAL) y = x;
    surface(f, cell, x, y, p);
}

/* ---- ways to a place --------------------------------------------------------------------------------------------- */

/* What a class makes a ray of: a field, and a place on the surface of one of its cells. */
typedef struct target {
    const test_field *f;
    size_t cell[2];
    double p[3];
} target;
typedef cw_ray maker(const target *at, random_state *r);

static void scale_dir(cw_ray *ray, double by) {
    for (int c = 0; c < 3; c++) ray->dir[c] = (float)((double)ray->dir[c] * by);
}

/* From org towards p. */
static cw_ray towards(const double org[3], const double p[3]) {
    cw_ray ray = {.tmin = 0, .tmax = INFINITY};
    for (int c = 0; c < 3; c++) {
        ray.org[c] = (float)org[c];
        ray.dir[c] = (float)(p[c] - (double)ray.org[c]);
    }
    return ray;
}

/* From up to so far off in each direction, the last by heights of the field. */
static cw_ray from_within(const target *at, random_state *r, double beside, double above) {
    double org[3];
    for (int c = 0; c < 3; c++) org[c] = at->p[c] + random_between(r, -1, 1) * (c < 2 ? beside : above * tall(at->f));
    return towards(org, at->p);
}

static cw_ray through_box(const target *at, random_state *r) {
    double p[3], q[3];
    random_in_box(at->f, r, p);
    random_in_box(at->f, r, q);
    cw_ray ray = towards(p, q);
    ray.tmin = -INFINITY;
    return ray;
}

/* From somewhere above or below the field; one in four from a place whose coordinates are whole. */
static cw_ray from_above(const target *at, random_state *r) {
    const test_field *f = at->f;
    double org[3];
    random_in_box(f, r, org);
    org[2] = sign(r) > 0 ? (double)f->high + tall(f) * random_unit(r) : (double)f->low - tall(f) * random_unit(r);
    if (rarely(r, 4))
        for (int c = 0; c < 3; c++) org[c] = rint(org[c]);
    return towards(org, at->p);
}

/* In the vertical plane of a border (x or y whole) or of a diagonal; every third one along the edge itself. */
static cw_ray along(const target *at, random_state *r) {
    const size_t kind = random_below(r, 3);
    double a[3], b[3];
    surface(at->f, at->cell, 0, 0, a);
    surface(at->f, at->cell, kind != 1, kind != 0, b);
    const double back = floor(random_between(r, 0.5, 4)), d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    cw_ray ray = {.tmin = 0, .tmax = INFINITY};
    for (int c = 0; c < 3; c++) ray.org[c] = (float)(a[c] - back * d[c]), ray.dir[c] = (float)d[c];
    if (!rarely(r, 3)) ray.org[2] = (float)(a[2] + tall(at->f) * random_between(r, -1, 1));
    if (!rarely(r, 3)) ray.dir[2] = (float)(a[2] - (double)ray.org[2]) / (float)(back + 1);
    return ray;
}

static cw_ray parallel_to_axis(const target *at, random_state *r) {
    cw_ray ray = from_above(at, r);
    const size_t c = random_below(r, 2);
    ray.org[c] = (float)at->p[c];
    ray.dir[c] = random_below(r, 2) ? 0.0f : -0.0f;
    return ray;
}

static cw_ray vertical(const target *at, random_state *r) {
    const double up = sign(r), length = tall(at->f) * random_between(r, 0.1, 2);
    target t = *at;
    take_aim((aim)random_below(r, 4), at->f, r, t.cell, t.p);
    cw_ray ray = towards((double[3]){t.p[0], t.p[1], t.p[2] - up * length}, t.p);
    ray.dir[0] = random_below(r, 2) ? 0.0f : -0.0f;
    ray.dir[1] = 0;
    if (random_below(r, 2)) ray.dir[2] = (float)up;
    return ray;
}

/* Through a point of a triangle, at an angle to it that is tangent-of-angle times as steep as along it. */
static cw_ray at_angle(const target *at, random_state *r, double angle) {
    const double *p = at->p, turn = random_between(r, 0, 6.283185307179586), back = random_between(r, 0.1, 3);
    const bool a = p[0] - (double)at->cell[0] >= p[1] - (double)at->cell[1];
    double h00[3], h11[3], corner[3];
    surface(at->f, at->cell, 0, 0, h00);
    surface(at->f, at->cell, 1, 1, h11);
    surface(at->f, at->cell, a, !a, corner);
    const double sx = a ? corner[2] - h00[2] : h11[2] - corner[2], sy = a ? h11[2] - corner[2] : corner[2] - h00[2],
                 rise = sx * cos(turn) + sy * sin(turn), off = sign(r) * angle * sqrt(1 + rise * rise);
    return towards((double[3]){p[0] - back * cos(turn), p[1] - back * sin(turn), p[2] - back * (rise + off)}, p);
}
static cw_ray grazing(const target *at, random_state *r) {
    return at_angle(at, r, 0.017453292519943295 * pow(10, random_between(r, -6, 0)));
}
static cw_ray in_plane(const target *at, random_state *r) { return at_angle(at, r, 0); }

static cw_ray from_reach(const target *at, random_state *r, double reach) {
    cw_ray ray = from_within(at, r, reach, reach);
    if (random_below(r, 2)) scale_dir(&ray, 1 / reach);
    return ray;
}
static cw_ray from_outside(const target *at, random_state *r) {
    return from_reach(at, r, pow(10, random_between(r, 0, 3)));
}
static cw_ray from_far(const target *at, random_state *r) {
    return from_reach(at, r, pow(10, random_between(r, 4, 8)));
}
static cw_ray from_near(const target *at, random_state *r) {
    const double reach = pow(10, random_between(r, -4, 0.3));
    return from_within(at, r, reach, reach);
}

static cw_ray from_afar(const target *at, random_state *r) {
    const double beside = pow(10, random_between(r, 0, 7)), above = pow(10, random_between(r, 6, 25));
    cw_ray ray = from_within(at, r, beside, 0);
    ray.org[2] = (float)(at->p[2] + sign(r) * above * tall(at->f));
    ray.dir[2] = (float)(at->p[2] - (double)ray.org[2]);
    scale_dir(&ray, 1 / above);
    return ray;
}

static cw_ray with_tiny(const target *at, random_state *r) {
    cw_ray ray = from_above(at, r);
    const size_t kept = random_below(r, 3);
    for (size_t c = 0; c < 3; c++) {
        if (c == kept || (c + 1) % 3 == random_below(r, 6)) continue;
        ray.org[c] = (float)at->p[c];
        ray.dir[c] = (float)(sign(r) * (double)ray.dir[kept] * exp2(random_between(r, -70, -10)));
    }
    return ray;
}

/* Some component becomes zero, minus zero, denormal, or the smallest that does not count as zero. */
static cw_ray with_zeros(const target *at, random_state *r) {
    static const float odd[] = {0.0f, -0.0f, 0x1p-149f, -0x1p-130f, 0x1p-128f, -0x1p-128f, 0x1.00001p-128f, 0x1p-126f};
    cw_ray ray = from_above(at, r);
    for (size_t n = 1 + random_below(r, 3); n > 0; n--) {
        const size_t c = random_below(r, 3);
        ray.dir[c] = odd[random_below(r, sizeof odd / sizeof odd[0])];
        if (c < 2) ray.org[c] = (float)at->p[c];
    }
    if (rarely(r, 4)) ray.org[random_below(r, 3)] = odd[random_below(r, 4)];
    return ray;
}

/* Every other one has any length that a float can have, so that its reciprocals and t come near the ends of the floats'
 * range too; one in four of these is all but parallel to the diagonal, where the difference of directions is far
 * smaller than they are. */
static cw_ray scaled(const target *at, random_state *r) {
    cw_ray ray = from_above(at, r);
    double length = pow(10, random_between(r, -30, 30));
    if (random_below(r, 2)) {
        if (rarely(r, 4)) ray.dir[1] = ray.dir[0] * (float)(1 + ldexp(random_unit(r), -(int)random_below(r, 24)));
        const double longest = (double)fmaxf(fmaxf(fabsf(ray.dir[0]), fabsf(ray.dir[1])), fabsf(ray.dir[2]));
        length = longest > 0 ? exp2(random_between(r, -129, 127)) / longest : 1;
        ray.tmin = -INFINITY;
    }
    scale_dir(&ray, length);
    return ray;
}

/* Ends of the t-range where the ray meets the surface (as a float: mostly a rounding beside it) or near by. */
static cw_ray with_range(const target *at, random_state *r) {
    cw_ray ray = from_above(at, r); /* meets p at t = 1 */
    const float near = nextafterf(1, sign(r) > 0 ? 2 : 0), some = (float)random_between(r, 0, 2);
    const float ends[] = {1, near, some, -INFINITY, INFINITY, 0, -1, 2};
    const float a = ends[random_below(r, 8)], b = rarely(r, 4) ? a : ends[random_below(r, 8)];
    const bool in_order = !rarely(r, 4);
    ray.tmin = in_order ? fminf(a, b) : a;
    ray.tmax = in_order ? fmaxf(a, b) : b;
    if (rarely(r, 4)) { /* starts on the surface, as a shadow ray does */
        for (int c = 0; c < 3; c++) ray.org[c] = (float)at->p[c];
        ray.tmin = 0;
        ray.tmax = INFINITY;
    }
    return ray;
}

/* From a place over the field, at the height of an extreme sample; mostly it rises little. The range begins behind it,
 * at a power of 2 or at minus infinity. Lengths are such that no direction counts as zero, or it is meant to. */
static cw_ray behind(const target *at, random_state *r) {
    const test_field *f = at->f;
    double q[3];
    random_in_box(f, r, q);
    q[2] = random_below(r, 2) ? (double)f->low : (double)f->high;
    if (rarely(r, 8)) q[2] = height_at(f, random_below(r, f->nx), random_below(r, f->ny));
    cw_ray ray = towards(q, at->p);
    if (rarely(r, 4)) {
        const double turn = random_between(r, 0, 6.283185307179586);
        ray.dir[0] = (float)cos(turn), ray.dir[1] = (float)sin(turn);
        ray.dir[2] = (float)(sign(r) * tall(f) * pow(10, random_between(r, -6, 0)));
    }
    if (rarely(r, 8)) ray.dir[0] = ray.dir[1] = 0;
    double scale = exp2(random_below(r, 3) ? random_between(r, -20, 0) : random_between(r, -60, 60));
    const double rise = fabs((double)ray.dir[2]);
    if (rise > 0 && rise * scale < 0x1p-126 && !rarely(r, 8)) scale = exp2(random_between(r, -120, -80)) / rise;
    scale_dir(&ray, rarely(r, 4) ? -scale : scale);
    ray.tmin = rarely(r, 4) ? -INFINITY : -(float)exp2((double)random_below(r, 128));
    return ray;
}

/* From half a side's length and more outside the field on one side, where rays are moved, to a place that it meets at
 * t = 1, and that mostly is farther from where it enters the field than that is from the origin. */
static cw_ray moved(const target *at, random_state *r) {
    double q[3];
    random_in_box(at->f, r, q);
    const size_t c = random_below(r, 2);
    const double side = (double)(c ? at->f->ny : at->f->nx) - 1;
    q[c] = random_below(r, 2) ? -side * random_between(r, 0.51, 1) : side * random_between(r, 1.51, 2);
    q[2] += sign(r) * tall(at->f) * random_between(r, 0, 2);
    cw_ray ray = towards(q, at->p);
    const float near[3] = {nextafterf(1, 0), 1, nextafterf(1, 2)};
    if (!rarely(r, 4)) ray.tmin = near[random_below(r, 3)];
    if (rarely(r, 4)) ray.tmax = near[random_below(r, 3)];
    if (rarely(r, 4) || ray.tmin > ray.tmax) ray.tmax = ray.tmin;
    return ray;
}

static cw_ray lattice(const target *at, random_state *r) {
    cw_ray ray = {.tmin = (float)random_below(r, 3) - 1, .tmax = random_below(r, 2) ? INFINITY : 2};
    const size_t range[3] = {2 * at->f->nx + 3, 2 * at->f->ny + 3, 13};
    const int parts = random_below(r, 2) ? 2 : 4; /* of a cell */
    for (int c = 0; c < 3; c++) {
        ray.org[c] = (float)((int)random_below(r, range[c] * (size_t)parts / 2)) / (float)parts - (c < 2 ? 1.5f : 3);
        ray.dir[c] = (float)((int)random_below(r, 4 * (size_t)parts + 1) - 2 * parts) / (float)parts;
    }
    return ray;
}

static cw_ray not_finite(const target *at, random_state *r) {
    const float odd[] = {NAN, INFINITY, -INFINITY};
    cw_ray ray = from_above(at, r);
    float *part[8] = {&ray.org[0], &ray.org[1], &ray.org[2], &ray.tmin,
                      &ray.dir[0], &ray.dir[1], &ray.dir[2], &ray.tmax};
    for (size_t n = 1 + random_below(r, 2); n > 0; n--) *part[random_below(r, 8)] = odd[random_below(r, 3)];
    return ray;
}

/* ---- classes ----------------------------------------------------------------------------------------------------- */

static const struct {
    aim at;
    maker *make;
} classes[RAY_CLASSES] = {
    [RAY_RANDOM] = {ANYWHERE, through_box},  [RAY_VERTEX] = {VERTEX, from_above},
    [RAY_EDGE] = {BORDER, from_above},       [RAY_DIAGONAL] = {DIAGONAL, from_above},
    [RAY_ALONG] = {ANYWHERE, along},         [RAY_AXIS] = {ANYWHERE, parallel_to_axis},
    [RAY_VERTICAL] = {ANYWHERE, vertical},   [RAY_GRAZING] = {ANYWHERE, grazing},
    [RAY_IN_PLANE] = {ANYWHERE, in_plane},   [RAY_OUTSIDE] = {BORDER, from_outside},
    [RAY_FAR] = {BORDER, from_far},          [RAY_AFAR] = {ANYWHERE, from_afar},
    [RAY_NEAR] = {ANYWHERE, from_near},      [RAY_TINY] = {ANYWHERE, with_tiny},
    [RAY_ZEROS] = {BORDER, with_zeros},      [RAY_SCALED] = {BORDER, scaled},
    [RAY_RANGE] = {ANYWHERE, with_range},    [RAY_BEHIND] = {ANYWHERE, behind},
    [RAY_MOVED] = {ANYWHERE, moved},         [RAY_LATTICE] = {ANYWHERE, lattice},
    [RAY_NOT_FINITE] = {BORDER, not_finite},
};

cw_ray ray_make(ray_class kind, const test_field *f, random_state *r) {
    target at = {.f = f};
    take_aim(classes[kind].at, f, r, at.cell, at.p);
    return classes[kind].make(&at, r);
}

cw_user_ray ray_for_user(const cw_ray *ray) {
    cw_user_ray user = {.tmin = (double)ray->tmin, .tmax = (double)ray->tmax};
    for (int c = 0; c < 3; c++) user.org[c] = (double)ray->org[c], user.dir[c] = (double)ray->dir[c];
    return user;
}

void ray_print(const cw_ray *ray) {
    printf("ray org {%a, %a, %a} dir {%a, %a, %a} t [%a, %a]\n", (double)ray->org[0], (double)ray->org[1],
           (double)ray->org[2], (double)ray->dir[0], (double)ray->dir[1], (double)ray->dir[2], (double)ray->tmin,
           (double)ray->tmax);
}

void hit_print(const char *who, const cw_hit *hit) {
    printf("%s: t %a u %a v %a cell (%d, %d) triangle %u\n", who, (double)hit->t, (double)hit->u, (double)hit->v,
           (int)hit->i, (int)hit->j, (unsigned)hit->triangle);
}

bool hit_same(const cw_hit *a, const cw_hit *b) {
    _Static_assert(sizeof(cw_hit) == 24, "padding would be compared");
    return memcmp(a, b, sizeof *a) == 0;
}
