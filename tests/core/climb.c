/* SPDX-License-Identifier: Apache-2.0 */
/* Rays that climb out of the terrain from next to the corner of a node: the pyramid kernels, which end such a walk early
 * (simd/climb.h), give the same bits as the plain walk from cell to cell. Rounding decides in which of the four nodes
 * a ray's beginning lies, and which it enters first. Towers stand beside the corners, so that one cell more or less shows.
 * Ranges begin a few floats before or behind the corner, at negative t too; directions have zeros of either sign; some
 * origins lie so far out that floats there are an eighth of a cell apart. There is no tolerance. */

#include "as_cell.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RAYS = 1024, FIELDS = 240, SIDE_MAX = 90, WIDE = (1 << 20) + 300, WIDE_ROWS = 13 };

typedef struct towers {
    size_t nx, ny, first; /* columns before the first one are level, and rays do not go there */
    float *z;
} towers;

/* Level ground, with towers next to some corners of nodes, each so high that one float beside the corner its flank is above
 * the ground; holes in some fields. */
static void make_towers(towers *f, size_t nx, size_t ny, random_state *r) {
    const size_t holes = random_below(r, 3) ? 0 : 200;
    f->nx = nx;
    f->ny = ny;
    f->first = nx > 400 ? nx - 400 : 0;
    memset(f->z, 0, nx * ny * sizeof *f->z);
    for (size_t j = 0; j < ny; j++)
        for (size_t i = f->first; i < nx; i++) {
            float *z = &f->z[j * nx + i];
            const bool beside_x = j % 8 == 0 && (i % 8 == 1 || i % 8 == 7),
                       beside_y = i % 8 == 0 && (j % 8 == 1 || j % 8 == 7);
            *z = (float)random_below(r, 3);
            if ((beside_x || beside_y) && random_below(r, 6) == 0)
                *z = (float)ldexp(random_between(r, 1, 2), 25 + (int)random_below(r, 30));
            if (holes > 0 && random_below(r, holes) == 0) *z = NAN;
        }
}

static float floats_on(float x, int n) {
    for (; n > 0; n--) x = nextafterf(x, INFINITY);
    for (; n < 0; n++) x = nextafterf(x, -INFINITY);
    return x;
}
static int few(random_state *r, int most) { return (int)random_below(r, 2 * (size_t)most + 1) - most; }

/* A place next to a node's corner, and a direction. */
static void aim(const towers *f, cw_ray *ray, random_state *r) {
    const size_t side = random_below(r, 4) ? 8 : 4;
    size_t corner[2] = {(f->first + random_below(r, f->nx - f->first)) / side * side,
                        random_below(r, f->ny) / side * side};
    if (corner[0] < f->ny && random_below(r, 2)) corner[1] = corner[0]; /* floats as far apart along both axes */
    for (int c = 0; c < 2; c++) {
        ray->org[c] = (float)corner[c];
        ray->dir[c] = (float)random_between(r, -1, 1);
        if (random_below(r, 4) == 0) ray->dir[c] = 0.25f * (float)few(r, 4);
    }
    if (random_below(r, 2)) ray->dir[1] = ray->dir[0] * (float)random_between(r, 0.5, 1.5);
    if (random_below(r, 2)) ray->dir[1] = -ray->dir[1];
    if (random_below(r, 12) == 0) ray->dir[random_below(r, 2)] = random_below(r, 2) ? 0 : -0.0f;
    ray->dir[2] = (float)random_between(r, 0, 2);
}

static float way(const towers *f, random_state *r) {
    return f->first > 0 || random_below(r, 4) ? (float)exp2(random_between(r, -3, 4)) : INFINITY;
}

/* A ray whose range begins less than a float's width before the corner, or behind it: the sum of origin and way rounds. */
static cw_ray from_a_float_off(const towers *f, random_state *r) {
    cw_ray ray;
    aim(f, &ray, r);
    float t = 0, corner[2];
    for (int c = 0; c < 2; c++) {
        const float speed = fmaxf(fabsf(ray.dir[c]), 0.01f);
        corner[c] = ray.org[c];
        ray.org[c] = floats_on(corner[c], random_below(r, 6) ? ray.dir[c] < 0 ? 1 : -1 : few(r, 2));
        if (c == 1 && random_below(r, 2)) ray.org[c] = corner[c] - ray.dir[c] * t * (float)random_between(r, 0.5, 1.1);
        t = fmaxf(t, fabsf(corner[c] - ray.org[c]) / speed);
    }
    ray.tmin = t * (float)(random_below(r, 4) ? random_between(r, 0.4, 1.1) : random_between(r, -1, 2));
    ray.tmax = way(f, r);
    ray.org[2] = (float)random_between(r, 1, 4);
    return ray;
}

/* A ray that is at the corner at some t, also a negative one, and whose range begins there, as nearly as floats allow. */
static cw_ray from_afar(const towers *f, random_state *r) {
    cw_ray ray;
    aim(f, &ray, r);
    const float t = (float)random_between(r, -0.5, 0.5) * (float)f->ny;
    const float high = random_below(r, 2) ? (float)random_between(r, 1, 4) : (float)exp2(random_between(r, 0, 24));
    for (int c = 0; c < 2; c++) ray.org[c] = floats_on(ray.org[c] - t * ray.dir[c], few(r, 2));
    if (random_below(r, 2)) ray.dir[2] = (float)exp2(random_between(r, 0, 12));
    ray.org[2] = high - t * ray.dir[2];
    ray.tmin = floats_on(t, few(r, 3));
    ray.tmax = t + way(f, r);
    return ray;
}

static void trace(const towers *f, size_t times, as_cell_counts *sum, random_state *r) {
    static cw_ray rays[RAYS];
    cw_field_desc d = {0};
    d.samples = f->z;
    d.nx = f->nx;
    d.ny = f->ny;
    cw_field *field;
    check_status(cw_field_create(&d, NULL, &field), CW_OK);
    for (; times > 0; times--) {
        for (size_t k = 0; k < RAYS; k++) rays[k] = random_below(r, 4) ? from_a_float_off(f, r) : from_afar(f, r);
        as_cell_check(field, rays, RAYS, sum);
    }
    cw_field_destroy(field);
}

static void test_corners(void **state) {
    (void)state;
    towers f = {.z = malloc((size_t)SIDE_MAX * SIDE_MAX * sizeof *f.z)};
    assert_non_null(f.z);
    random_state r = {20261123};
    as_cell_counts sum = {0};
    const size_t fields = test_share(FIELDS, 12);
    for (size_t m = 0; m < fields; m++) {
        make_towers(&f, 6 + random_below(&r, SIDE_MAX - 5), 6 + random_below(&r, SIDE_MAX - 5), &r);
        trace(&f, 1, &sum, &r);
    }
    free(f.z);
    printf("%zu rays from corners of nodes, %zu hits, the same bits in every kernel\n", sum.rays, sum.hits);
    check(sum.kernels >= fields, "no kernel was compared");
    check(sum.hits > sum.rays / 20 && sum.hits < sum.rays, "too few rays hit or miss for the test to mean anything");
}

/* Where neighbouring floats are an eighth of a cell apart, and a quarter further on. */
static void test_far_out(void **state) {
    (void)state;
    if (test_divisor() >= 1000) skip(); /* on an emulated CPU (old_cpu.cmake) */
    towers f = {.z = malloc((size_t)WIDE * WIDE_ROWS * sizeof *f.z)};
    assert_non_null(f.z);
    random_state r = {20261124};
    as_cell_counts sum = {0};
    make_towers(&f, WIDE, WIDE_ROWS, &r);
    trace(&f, test_share(60, 8), &sum, &r);
    free(f.z);
    printf("%zu rays far out, %zu hits, the same bits in every kernel\n", sum.rays, sum.hits);
    check(sum.hits > sum.rays / 20 && sum.hits < sum.rays, "too few rays hit or miss for the test to mean anything");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_corners), cmocka_unit_test(test_far_out)};
    return cmocka_run_group_tests_name("climb", tests, NULL, NULL);
}
