/* SPDX-License-Identifier: Apache-2.0 */
#include "rays.h"

#include "check.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const char *ray_class_name(ray_class kind) {
    static const char *const names[RAY_CLASSES] = {"random",   "vertex",  "edge",      "diagonal", "along", "axis",
                                                   "vertical", "grazing", "in-plane",  "outside",  "far",   "afar",
                                                   "near",     "tiny",    "zeros",     "scaled",   "range", "behind",
                                                   "moved",    "lattice", "not-finite"};
    return names[kind];
}

static double sign(random_state *r) { return random_bits(r) >> 63 ? 1 : -1; }

/* The field's extent in height, never 0: the unit of heights above or below it. */
static double tall(const test_field *f) {
    const double span = (double)f->high - (double)f->low, size = fmax(fabs((double)f->low), fabs((double)f->high));
    return span > 0 ? span : size > 0 ? size : 1;
}

static double height_at(const test_field *f, size_t i, size_t j) {
    const double z = (double)f->z[j * f->nx + i];
    return isnan(z) ? (double)f->low : z;
}

/* A place on the surface of cell (i, j), x and y within it. */
static void surface(const test_field *f, size_t i, size_t j, double x, double y, double p[3]) {
    const double h00 = height_at(f, i, j), h11 = height_at(f, i + 1, j + 1);
    const double corner = x >= y ? height_at(f, i + 1, j) : height_at(f, i, j + 1);
    const double longer = fmax(x, y), shorter = fmin(x, y);
    p[0] = (double)i + x;
    p[1] = (double)j + y;
    p[2] = h00 + longer * (corner - h00) + shorter * (h11 - corner);
}

static void random_cell(const test_field *f, random_state *r, size_t *i, size_t *j) {
    *i = random_below(r, f->nx - 1);
    *j = random_below(r, f->ny - 1);
}

static void random_in_box(const test_field *f, random_state *r, double p[3]) {
    p[0] = random_between(r, 0, (double)(f->nx - 1));
    p[1] = random_between(r, 0, (double)(f->ny - 1));
    p[2] = random_between(r, (double)f->low, (double)f->high);
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

/* From somewhere above or below the field towards p; one in four from a place whose coordinates are whole. */
static cw_ray from_outside(const test_field *f, random_state *r, const double p[3]) {
    double org[3];
    random_in_box(f, r, org);
    org[2] = sign(r) > 0 ? (double)f->high + tall(f) * random_unit(r) : (double)f->low - tall(f) * random_unit(r);
    if (random_below(r, 4) == 0)
        for (int c = 0; c < 3; c++) org[c] = rint(org[c]);
    return towards(org, p);
}

static void on_edge(const test_field *f, random_state *r, double p[3]) {
    size_t i, j;
    random_cell(f, r, &i, &j);
    const double along = random_unit(r), side = (double)random_below(r, 2);
    if (random_below(r, 2))
        surface(f, i, j, along, side, p);
    else
        surface(f, i, j, side, along, p);
}

/* In the vertical plane of a border (x or y whole) or of a diagonal; every third one along the edge itself. */
static cw_ray along(const test_field *f, random_state *r) {
    size_t i, j;
    random_cell(f, r, &i, &j);
    const size_t kind = random_below(r, 3);
    double a[3], b[3];
    surface(f, i, j, 0, 0, a);
    surface(f, i, j, kind != 1, kind != 0, b);
    const double back = random_between(r, 0.5, 4), d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    double org[3];
    for (int c = 0; c < 3; c++) org[c] = a[c] - floor(back) * d[c];
    if (random_below(r, 3)) org[2] = a[2] + tall(f) * random_between(r, -1, 1);
    cw_ray ray = {.tmin = 0, .tmax = INFINITY};
    for (int c = 0; c < 3; c++) {
        ray.org[c] = (float)org[c];
        ray.dir[c] = (float)d[c];
    }
    if (random_below(r, 3)) ray.dir[2] = (float)(a[2] - org[2]) / (float)floor(back + 1);
    return ray;
}

static cw_ray vertical(const test_field *f, random_state *r) {
    double p[3];
    size_t i, j;
    random_cell(f, r, &i, &j);
    const double x = random_unit(r), y = random_unit(r);
    switch (random_below(r, 4)) {
    case 0:
        surface(f, i, j, floor(x * 2), floor(y * 2), p);
        break;
    case 1:
        surface(f, i, j, x, x, p);
        break;
    case 2:
        on_edge(f, r, p);
        break;
    default:
        surface(f, i, j, x, y, p);
    }
    const double up = sign(r), length = tall(f) * random_between(r, 0.1, 2);
    cw_ray ray = towards((double[3]){p[0], p[1], p[2] - up * length}, p);
    ray.org[0] = (float)p[0];
    ray.org[1] = (float)p[1];
    ray.dir[0] = random_below(r, 2) ? 0.0f : -0.0f;
    ray.dir[1] = 0;
    if (random_below(r, 2)) ray.dir[2] = (float)up;
    return ray;
}

/* Through a point of a triangle, at an angle to it that is tangent-of-angle times as steep as along it. */
static cw_ray at_angle(const test_field *f, random_state *r, double angle) {
    size_t i, j;
    random_cell(f, r, &i, &j);
    const double x = random_unit(r), y = random_unit(r), turn = random_between(r, 0, 6.283185307179586);
    double p[3], q[3];
    surface(f, i, j, x, y, p);
    const double h00 = height_at(f, i, j), h11 = height_at(f, i + 1, j + 1);
    const double sx = x >= y ? height_at(f, i + 1, j) - h00 : h11 - height_at(f, i, j + 1);
    const double sy = x >= y ? h11 - height_at(f, i + 1, j) : height_at(f, i, j + 1) - h00;
    const double along_z = sx * cos(turn) + sy * sin(turn), back = random_between(r, 0.1, 3);
    q[0] = p[0] - back * cos(turn);
    q[1] = p[1] - back * sin(turn);
    q[2] = p[2] - back * (along_z + sign(r) * angle * sqrt(1 + along_z * along_z));
    return towards(q, p);
}

/* Some component becomes zero, minus zero, denormal, or the smallest that does not count as zero. */
static cw_ray with_zeros(const test_field *f, random_state *r) {
    static const float odd[] = {0.0f, -0.0f, 0x1p-149f, -0x1p-130f, 0x1p-128f, -0x1p-128f, 0x1.00001p-128f, 0x1p-126f};
    double p[3];
    on_edge(f, r, p);
    cw_ray ray = from_outside(f, r, p);
    for (size_t k = 0, n = 1 + random_below(r, 3); k < n; k++) {
        const size_t c = random_below(r, 3);
        ray.dir[c] = odd[random_below(r, sizeof odd / sizeof odd[0])];
        if (c < 2) ray.org[c] = (float)p[c];
    }
    if (random_below(r, 4) == 0) ray.org[random_below(r, 3)] = odd[random_below(r, 4)];
    return ray;
}

/* Ends of the t-range where the ray meets the surface (as a float: mostly a rounding beside it) or near by. */
static cw_ray with_range(const test_field *f, random_state *r) {
    double p[3];
    size_t i, j;
    random_cell(f, r, &i, &j);
    surface(f, i, j, random_unit(r), random_unit(r), p);
    cw_ray ray = from_outside(f, r, p); /* meets p at t = 1 */
    const float near = nextafterf(1, sign(r) > 0 ? 2 : 0), some = (float)random_between(r, 0, 2);
    const float ends[] = {1, near, some, -INFINITY, INFINITY, 0, -1, 2};
    ray.tmin = ends[random_below(r, sizeof ends / sizeof ends[0])];
    ray.tmax = ends[random_below(r, sizeof ends / sizeof ends[0])];
    if (random_below(r, 4) == 0) ray.tmax = ray.tmin;
    if (ray.tmin > ray.tmax && random_below(r, 4)) {
        const float swap = ray.tmin;
        ray.tmin = ray.tmax;
        ray.tmax = swap;
    }
    if (random_below(r, 4) == 0) { /* starts on the surface, as a shadow ray does */
        for (int c = 0; c < 3; c++) ray.org[c] = (float)p[c];
        ray.tmin = 0;
        ray.tmax = INFINITY;
    }
    return ray;
}

/* From a place over the field, at the height of an extreme sample, to a place on the surface; mostly it rises little. The range
 * begins behind it, at a power of 2 or at minus infinity. Lengths are such that no direction counts as zero, or it is meant to. */
static cw_ray behind(const test_field *f, random_state *r) {
    double p[3], q[3];
    size_t i, j;
    random_cell(f, r, &i, &j);
    surface(f, i, j, random_unit(r), random_unit(r), p);
    random_in_box(f, r, q);
    q[2] = random_below(r, 2) ? (double)f->low : (double)f->high;
    if (random_below(r, 8) == 0) q[2] = (double)f->z[random_below(r, f->nx * f->ny)];
    if (isnan(q[2])) q[2] = (double)f->low;
    cw_ray ray = towards(q, p);
    if (random_below(r, 4) == 0) {
        const double turn = random_between(r, 0, 6.283185307179586);
        ray.dir[0] = (float)cos(turn);
        ray.dir[1] = (float)sin(turn);
        ray.dir[2] = (float)(sign(r) * tall(f) * pow(10, random_between(r, -6, 0)));
    }
    if (random_below(r, 8) == 0) ray.dir[0] = ray.dir[1] = 0;
    double scale = exp2(random_below(r, 3) ? random_between(r, -20, 0) : random_between(r, -60, 60));
    const double rise = fabs((double)ray.dir[2]);
    if (rise > 0 && rise * scale < 0x1p-126 && random_below(r, 8)) scale = exp2(random_between(r, -120, -80)) / rise;
    if (random_below(r, 4) == 0) scale = -scale;
    for (int c = 0; c < 3; c++) ray.dir[c] = (float)((double)ray.dir[c] * scale);
    ray.tmin = random_below(r, 4) ? -(float)exp2((double)random_below(r, 128)) : -INFINITY;
    return ray;
}

/* From half a side's length and more outside the field on one side, where rays are moved, to a place on the surface that it
 * meets at t = 1, and that mostly is farther from where it enters the field than that is from the origin. */
static cw_ray moved(const test_field *f, random_state *r) {
    double p[3], q[3];
    size_t i, j;
    random_cell(f, r, &i, &j);
    surface(f, i, j, random_unit(r), random_unit(r), p);
    random_in_box(f, r, q);
    const size_t c = random_below(r, 2);
    const double side = (double)(c ? f->ny : f->nx) - 1;
    q[c] = random_below(r, 2) ? -side * random_between(r, 0.51, 1) : side * random_between(r, 1.51, 2);
    q[2] += sign(r) * tall(f) * random_between(r, 0, 2);
    cw_ray ray = towards(q, p);
    const float near[3] = {nextafterf(1, 0), 1, nextafterf(1, 2)};
    if (random_below(r, 4)) ray.tmin = near[random_below(r, 3)];
    if (random_below(r, 4) == 0) ray.tmax = near[random_below(r, 3)];
    if (random_below(r, 4) == 0) ray.tmax = ray.tmin;
    if (ray.tmin > ray.tmax) ray.tmax = ray.tmin;
    return ray;
}

/* Every other one has any length that a float can have, so that its reciprocals and t come near the ends of the floats'
 * range too; one in four of these is all but parallel to the diagonal, where the difference of directions is far smaller
 * than they are. */
static cw_ray scaled(const test_field *f, random_state *r) {
    double p[3];
    on_edge(f, r, p);
    cw_ray ray = from_outside(f, r, p);
    double length = pow(10, random_between(r, -30, 30));
    if (random_below(r, 2)) {
        if (random_below(r, 4) == 0)
            ray.dir[1] = ray.dir[0] * (float)(1 + ldexp(random_unit(r), -(int)random_below(r, 24)));
        const double longest = fmax(fmax(fabs((double)ray.dir[0]), fabs((double)ray.dir[1])), fabs((double)ray.dir[2]));
        length = longest > 0 ? exp2(random_between(r, -129, 127)) / longest : 1;
        ray.tmin = -INFINITY;
    }
    for (int c = 0; c < 3; c++) ray.dir[c] = (float)((double)ray.dir[c] * length);
    return ray;
}

static cw_ray lattice(const test_field *f, random_state *r) {
    cw_ray ray = {.tmin = (float)random_below(r, 3) - 1, .tmax = random_below(r, 2) ? INFINITY : 2};
    const size_t side[2] = {f->nx, f->ny};
    for (int c = 0; c < 3; c++) {
        const size_t range = c < 2 ? 2 * side[c] + 3 : 13;
        ray.org[c] = 0.5f * (float)((int)random_below(r, range) - (c < 2 ? 3 : 6));
        ray.dir[c] = 0.5f * (float)((int)random_below(r, 9) - 4);
    }
    return ray;
}

static cw_ray not_finite(const test_field *f, random_state *r) {
    const float odd[] = {NAN, INFINITY, -INFINITY};
    double p[3];
    on_edge(f, r, p);
    cw_ray ray = from_outside(f, r, p);
    float *at[8] = {&ray.org[0], &ray.org[1], &ray.org[2], &ray.tmin, &ray.dir[0], &ray.dir[1], &ray.dir[2], &ray.tmax};
    for (size_t k = 0, n = 1 + random_below(r, 2); k < n; k++) *at[random_below(r, 8)] = odd[random_below(r, 3)];
    return ray;
}

cw_ray ray_make(ray_class kind, const test_field *f, random_state *r) {
    double p[3], q[3];
    size_t i, j;
    cw_ray ray;
    random_cell(f, r, &i, &j);
    switch (kind) {
    case RAY_VERTEX:
        surface(f, i, j, (double)random_below(r, 2), (double)random_below(r, 2), p);
        return from_outside(f, r, p);
    case RAY_EDGE:
        on_edge(f, r, p);
        return from_outside(f, r, p);
    case RAY_DIAGONAL: {
        const double at = random_unit(r);
        surface(f, i, j, at, at, p);
        return from_outside(f, r, p);
    }
    case RAY_ALONG:
        return along(f, r);
    case RAY_AXIS: {
        surface(f, i, j, random_unit(r), random_unit(r), p);
        ray = from_outside(f, r, p);
        const size_t c = random_below(r, 2);
        ray.org[c] = (float)p[c];
        ray.dir[c] = random_below(r, 2) ? 0.0f : -0.0f;
        return ray;
    }
    case RAY_VERTICAL:
        return vertical(f, r);
    case RAY_GRAZING:
        return at_angle(f, r, 0.017453292519943295 * pow(10, random_between(r, -6, 0)));
    case RAY_IN_PLANE:
        return at_angle(f, r, 0);
    case RAY_OUTSIDE:
    case RAY_FAR: {
        on_edge(f, r, p);
        const double reach = pow(10, kind == RAY_FAR ? random_between(r, 4, 8) : random_between(r, 0, 3));
        const double away[3] = {random_between(r, -1, 1), random_between(r, -1, 1), random_between(r, -1, 1)};
        for (int c = 0; c < 3; c++) q[c] = p[c] + away[c] * reach * (c < 2 ? 1 : tall(f));
        ray = towards(q, p);
        if (random_below(r, 2))
            for (int c = 0; c < 3; c++) ray.dir[c] /= (float)reach;
        return ray;
    }
    case RAY_AFAR: {
        surface(f, i, j, random_unit(r), random_unit(r), p);
        const double beside = pow(10, random_between(r, 0, 7)), above = pow(10, random_between(r, 6, 25));
        q[0] = p[0] + random_between(r, -beside, beside);
        q[1] = p[1] + random_between(r, -beside, beside);
        q[2] = p[2] + sign(r) * above * tall(f);
        ray = towards(q, p);
        for (int c = 0; c < 3; c++) ray.dir[c] /= (float)above;
        return ray;
    }
    case RAY_NEAR: {
        surface(f, i, j, random_unit(r), random_unit(r), p);
        const double reach = pow(10, random_between(r, -4, 0.3));
        for (int c = 0; c < 3; c++) q[c] = p[c] + random_between(r, -1, 1) * reach * (c < 2 ? 1 : tall(f));
        return towards(q, p);
    }
    case RAY_TINY: {
        surface(f, i, j, random_unit(r), random_unit(r), p);
        ray = from_outside(f, r, p);
        const size_t kept = random_below(r, 3);
        for (size_t c = 0; c < 3; c++) {
            if (c == kept || (c + 1) % 3 == random_below(r, 6)) continue;
            ray.org[c] = (float)p[c];
            ray.dir[c] = (float)(sign(r) * (double)ray.dir[kept] * exp2(random_between(r, -70, -10)));
        }
        return ray;
    }
    case RAY_ZEROS:
        return with_zeros(f, r);
    case RAY_SCALED:
        return scaled(f, r);
    case RAY_RANGE:
        return with_range(f, r);
    case RAY_BEHIND:
        return behind(f, r);
    case RAY_MOVED:
        return moved(f, r);
    case RAY_LATTICE:
        return lattice(f, r);
    case RAY_NOT_FINITE:
        return not_finite(f, r);
    case RAY_RANDOM:
    default:
        random_in_box(f, r, p);
        random_in_box(f, r, q);
        ray = towards(p, q);
        ray.tmin = -INFINITY;
        return ray;
    }
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
    return memcmp(&a->t, &b->t, sizeof a->t) == 0 && memcmp(&a->u, &b->u, sizeof a->u) == 0 &&
           memcmp(&a->v, &b->v, sizeof a->v) == 0 && a->i == b->i && a->j == b->j && a->triangle == b->triangle;
}
