/* SPDX-License-Identifier: Apache-2.0 */
#include "lanes_grounds.h"

#include "check.h"
#include "workload/fractal_terrain.h"

#include <math.h>

/* ---- shapes and classes of rays ---------------------------------------------------------------------------------- */

static const field_size large = {261, 131}; /* several levels of any pyramid, and blocks that stick out */

static cw_field *make(const ground *g, field_shape shape, field_size size, uint64_t seed) {
    field_make(g->shape, shape, size.nx, size.ny, seed);
    return field_open(g->shape);
}

cw_field *any_shape(ground *g, random_state *r) {
    const size_t s = g->number / FIELD_ALL_SHAPES % (FIELD_SIZES + 1);
    return make(g, (field_shape)(g->number % FIELD_ALL_SHAPES), s < FIELD_SIZES ? field_sizes[s] : large, s + 1);
}

cw_field *large_shape(ground *g, random_state *r) { return make(g, FIELD_RANDOM, large, 1); }

cw_field *small_shape(ground *g, random_state *r) {
    static const field_size sizes[] = {{2, 2}, {9, 5}, {65, 50}};
    return make(g, g->number % 2 ? FIELD_HOLES : FIELD_RANDOM, sizes[g->number % 3], g->number);
}

/* A plateau over a plain, both rough, with some holes. */
cw_field *cliff(ground *g, random_state *r) {
    test_field *f = g->shape;
    *f = (test_field){.shape = FIELD_MIXED, .nx = large.nx, .ny = large.ny, .low = -1001, .high = 1};
    for (size_t k = 0; k < f->nx * f->ny; k++) {
        const float rough = (float)random_between(r, -1, 1);
        f->z[k] = random_below(r, 400) == 0 ? NAN : k % f->nx < f->nx / 2 ? rough : rough - 1000;
    }
    return field_open(f);
}

/* They fall to the ground within some cells, or fly out over the plain. */
size_t rays_over_cliff(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const double edge = (double)(g->shape->nx / 2), across = (double)(g->shape->ny - 1);
    for (size_t k = 0; k < most; k++) {
        const double turn = random_between(r, -3, 3), fall = random_between(r, 0.02, 0.5);
        const double start = k % 8 > 0 ? edge : -2; /* some come from beside the field */
        rays[k] = (cw_ray){{(float)random_between(r, start - 40, start), (float)random_between(r, 0, across),
                            (float)random_between(r, 0.5, 4)},
                           0,
                           {(float)cos(turn), (float)sin(turn), (float)-fall},
                           INFINITY};
    }
    return most;
}

size_t rays_in_turn(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    for (size_t k = 0; k < most; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), g->shape, r);
    return most;
}

/* Bundles are what cameras, lights and leaf hits send. Some kernels treat such rays together. */
static size_t run_of(ray_class first, ray_class last, const ground *g, cw_ray *rays, size_t most, random_state *r) {
    static const double spreads[] = {0, 1e-7, 1e-3, 0.02, 0.1, 0.3};
    const size_t any = 1 + random_below(r, RUN_MAX), n = any < most ? any : most;
    const bool bundles = random_below(r, 2);
    for (size_t k = 0; k < n;) {
        const cw_ray one = ray_make((ray_class)(first + random_below(r, (size_t)(last - first + 1))), g->shape, r);
        if (!bundles) {
            rays[k++] = one;
            continue;
        }
        const double turn = spreads[random_below(r, 6)], shift = 10 * spreads[random_below(r, 6)];
        float longest = 0;
        for (int c = 0; c < 3; c++) longest = fmaxf(longest, fabsf(one.dir[c]));
        for (size_t left = 4 + random_below(r, 60); left > 0 && k < n; left--, k++) {
            rays[k] = one;
            for (int c = 0; c < 3; c++) {
                rays[k].dir[c] += (float)(turn * random_between(r, -1, 1)) * longest;
                if (c < 2) rays[k].org[c] += (float)(shift * random_between(r, -1, 1));
            }
        }
    }
    return n;
}

size_t random_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    return run_of(RAY_RANDOM, RAY_RANDOM, g, rays, most, r);
}

size_t adversarial_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    return run_of(RAY_VERTEX, RAY_NOT_FINITE, g, rays, most, r);
}

/* Tiles of all but vertical rays, each past a sample at about its height. Tiles fall apart, and t at the far side of a
 * block is so large that a lane's rounding counts, if a ray is not cut to the field's heights. */
size_t steep_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const test_field *f = g->shape;
    for (size_t k = 0; k < most;) {
        const size_t i = 16 * random_below(r, f->nx / 16 - 1), j = 16 * random_below(r, f->ny / 16 - 1);
        const float away = ldexpf(1, (int)random_below(r, 8)), turn = random_below(r, 2) ? 1 : -1;
        const float lean[2] = {ldexpf(turn, -13 - (int)random_below(r, 6)), ldexpf(1, -13 - (int)random_below(r, 6))};
        for (size_t n = 0; n < 64 && k < most; n++, k++) {
            const size_t x = i + random_below(r, 16), y = j + random_below(r, 16);
            const float up = away * (1 + 0x1p-22f * (float)random_below(r, 8));
            const float org[3] = {(float)x - away * lean[0], (float)y - away * lean[1], f->z[y * f->nx + x] + up};
            rays[k] = (cw_ray){{org[0], org[1], org[2]}, 0, {lean[0], lean[1], -1}, INFINITY};
        }
    }
    return most;
}

/* Tiles of like rays from whole and half places. Along each axis some stand and the rest go one way, so where a tile is
 * one fat ray, the distance of one ray from a border is zero while another's 1 / dir is infinite. */
size_t standing_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const test_field *f = g->shape;
    for (size_t k = 0; k < most;) {
        const size_t corner[2] = {random_below(r, f->nx - 10), random_below(r, f->ny - 10)};
        const float turn[2] = {random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 1 : -1};
        for (size_t n = 0; n < 64 && k < most; n++, k++) {
            cw_ray *ray = &rays[k];
            *ray = (cw_ray){.org = {0, 0, f->high + 2}, .dir = {0, 0, -4}, .tmax = INFINITY};
            for (int c = 0; c < 2; c++) {
                ray->org[c] = (float)(corner[c] + random_below(r, 8)) + (random_below(r, 3) ? 0 : 0.5f);
                ray->dir[c] = turn[c] * (float)random_below(r, 3) / 4;
            }
        }
    }
    return most;
}

/* ---- known ------------------------------------------------------------------------------------------------------- */

/* A component that counts as zero, signs of zeros, a tower, a range of the hit alone. All samples but four are 0. */
static const struct {
    field_size size;
    size_t at[4];
    float z[4];
    cw_ray ray;
} known[KNOWN] = {
    {{2, 2},
     {0, 1, 2, 3},
     {0x1.22145cp-1f, 0x1.f12746p-1f, 0x1.c6ed54p-2f, 0x1.c133d8p-1f},
     {{0, 0x1.b5880ep-2f, 0x1.5148aap+0f}, 0, {0x1p-128f, 0x1.bd3f8ap-2f, -0x1.b678p-1f}, INFINITY}},
    {{2, 2},
     {0, 1, 2, 3},
     {0, 0, 0, 0x1.e848p+19f},
     {{0, 0x1.e4c49cp-3f, -0.0f}, 0, {0x1.00001p-128f, 0x1.1deefp-1f, 0x1.9a5836p+19f}, INFINITY}},
    {{2, 2}, {0, 1, 2, 3}, {0}, {{0, -0.0f, -0.0f}, 0, {1, -0x1.fffd62p-1f, 0x1p-128f}, INFINITY}},
    {{47, 54},
     {20 * 47 + 12, 21 * 47 + 13},
     {0x1.98p+42f, -37},
     {{0, 28.5f, -16.75f}, -108, {-14.25f, 9.25f, 23}, INFINITY}},
    {{2, 2}, {0, 1, 2, 3}, {0}, {{0.25f, 0.5f, 3}, 3, {0, 0, -1}, 3}},
};

cw_field *known_field(ground *g, random_state *r) {
    const size_t n = g->number % KNOWN;
    *g->shape = (test_field){.shape = FIELD_MIXED, .nx = known[n].size.nx, .ny = known[n].size.ny};
    for (int k = 0; k < 4; k++) g->shape->z[known[n].at[k]] = known[n].z[k];
    return field_open(g->shape);
}

/* In calls of 1, 17 and 33. */
size_t known_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    const size_t n = most == KNOWN_RAYS ? 1 : most == KNOWN_RAYS - 1 ? 17 : most;
    for (size_t k = 0; k < n; k++) rays[k] = known[g->number % KNOWN].ray;
    return n;
}

/* ---- towers ------------------------------------------------------------------------------------------------------ */

/* Next to a tower a triangle is all but vertical, and Möller and Trumbore's test tosses a coin where a ray passes the
 * foot of it, at any height. Without a spike on the other side all that is not a tower lies at an end of the field's
 * heights, so that rays are cut off close by; with one, only climbing rays are. */
cw_field *towers(ground *g, random_state *r) {
    const size_t nx = 12 + random_below(r, 80), ny = 12 + random_below(r, 80), tower_in = 128;
    const bool spike = random_below(r, 2);
    const size_t small = random_below(r, 2) ? 0 : 1 + random_below(r, 40);
    test_field *f = g->shape;
    g->up = random_below(r, 2);
    f->shape = FIELD_MIXED;
    f->nx = nx;
    f->ny = ny;
    f->low = -(float)small;
    f->high = (float)small;
    for (size_t k = 0; k < nx * ny; k++) {
        const double size = ldexp(random_between(r, 1, 2), 20 + (int)random_below(r, 41));
        f->z[k] = (float)few(r, (int)small);
        if (random_below(r, tower_in) == 0 || k == nx + 1) f->z[k] = (float)(g->up ? size : -size);
    }
    if (spike) f->z[0] = (float)ldexp(g->up ? -1 : 1, (int)random_below(r, 60));
    return field_open(f);
}

/* Past the foot of a tower, in or out of one of its four cells, where it is below or above the cell's other samples, or
 * little beside that; and across their height within the cell. */
static cw_ray past_tower(const ground *g, random_state *r) {
    const test_field *f = g->shape;
    size_t i, j;
    do {
        i = 1 + random_below(r, f->nx - 2);
        j = 1 + random_below(r, f->ny - 2);
    } while (fabsf(f->z[j * f->nx + i]) < 0x1p20f);
    const int side[2] = {random_below(r, 2) ? 1 : -1, random_below(r, 2) ? 1 : -1};
    const float *z = f->z + j * f->nx + i;
    const float z0 = z[side[0]], z1 = z[side[0] + side[1] * (int)f->nx], out = g->up ? -1 : 1;
    const float beside = 0.0625f * (float)((int)random_below(r, 17) - 1), away = 0.25f * (float)random_below(r, 9);
    const float p[3] = {(float)i + (float)side[0], (float)j + (float)side[1] * beside,
                        (g->up ? fminf(z0, z1) : fmaxf(z0, z1)) + out * away};
    cw_ray ray = {.tmin = random_below(r, 4) ? -INFINITY : 0, .tmax = INFINITY};
    const float d[3] = {-(float)side[0] * 0.25f * (float)(1 + random_below(r, 64)), 0.25f * (float)few(r, 32),
                        -out * 0.25f * (float)random_below(r, 128)};
    const float t = 0.125f * (float)few(r, 16), turn = random_below(r, 2) ? 1 : -1;
    const bool odd = random_below(r, 2);
    for (int c = 0; c < 3; c++) {
        ray.dir[c] = turn * d[c] * (odd ? (float)random_between(r, 0.5, 1) : 1);
        ray.org[c] = p[c] - t * ray.dir[c];
    }
    return ray;
}

/* On half of the fields some are alike, and share their walk. */
size_t rays_past_towers(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    for (size_t k = 0; k < most; k++) {
        rays[k] = random_below(r, 8) ? past_tower(g, r) : ray_make(RAY_LATTICE, g->shape, r);
        if (g->number / 3 % 2 && k % 64) rays[k] = rays[k - 1], rays[k].org[k % 3] += 0.125f;
    }
    return most;
}

/* ---- the benchmark's --------------------------------------------------------------------------------------------- */

static cw_field *land(ground *g, size_t number, uint32_t seed) {
    /* Of several levels of the pyramid, whose last blocks stick out; one that is long, one small and steep; water; the
     * same always; and one with more samples than caches hold. */
    static const struct {
        size_t nx, ny;
        float relief; /* 0: water */
    } lands[] = {{257, 257, 0.1f}, {1023, 310, 0.1f}, {39, 66, 0.6f},    {500, 500, 0},
                 {257, 257, 0.1f}, {257, 257, 0},     {2049, 2049, 0.1f}};
    const size_t nx = lands[number].nx, ny = lands[number].ny;
    g->seed = seed;
    if (lands[number].relief > 0)
        terrain_fractal(g->z, nx, ny, seed, lands[number].relief);
    else
        terrain_sea(g->z, nx, ny, seed, 0.5f);
    return field_of(g->z, nx, ny);
}

cw_field *any_land(ground *g, random_state *r) { return land(g, (g->number + test_turn()) % 4, (uint32_t)g->number); }

cw_field *same_land(ground *g, random_state *r) { return land(g, 4 + g->number % 2, 7); }

cw_field *large_land(ground *g, random_state *r) { return land(g, 6, 7); }

size_t benchmark_rays(const ground *g, cw_ray *rays, size_t most, random_state *r) {
    return workload_rays_make(g->field, g->class, g->seed, most, rays);
}
