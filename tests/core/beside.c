/* SPDX-License-Identifier: Apache-2.0 */
/* Rays beside a tilted plane, for hundreds of cells nearer to it than slabs can resolve: the close walk
 * (simd/close_walk.h) ends them, and gives the same bits as the plain walk from cell to cell. Planes of any slope and
 * size, also of denormal heights or far from zero, plain, rippled, with fins across the ray's way and with holes; rays
 * parallel to them or nearly so, from within the field, from its border, from behind it, and from where rays are moved.
 * There is no tolerance. */

#include "as_cell.h"
#include "check.h"
#include "rays.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { RAYS_MAX = 600, FIELDS = 600, PLAIN = 240 };

static const field_size sizes[] = {{300, 257}, {66, 66},  {1500, 70}, {70, 1500},
                                   {2049, 9},  {5, 1025}, {513, 400}, {9001, 2}};
enum { SIZES = sizeof sizes / sizeof sizes[0] };

/* A plane: a slope along each axis, the height at sample (0, 0), and the unit of a ray's distance from it. */
typedef struct plane {
    size_t nx, ny;
    double slope[2], base, unit;
    bool high; /* so far from zero and so level that a sample's rounding is more than the plane's rise in a cell */
    float *z;
} plane;

static void make_plane(plane *p, size_t number, random_state *r) {
    static const int exponents[][8] = {{0, -3, -20, -60, -132, 40, 90, 0}, {0, -3, -20, -60, -132, 40, 90, -140}};
    p->nx = sizes[number % SIZES].nx;
    p->ny = sizes[number % SIZES].ny;
    const double longest = (double)(p->nx > p->ny ? p->nx : p->ny);
    p->unit = ldexp(1, exponents[number >= PLAIN][random_below(r, 8)]);
    if (p->unit > 1) p->unit /= longest;
    for (int c = 0; c < 2; c++) {
        const double slope = random_below(r, 3) ? random_between(r, -1, 1) : 0.125 * ((double)random_below(r, 9) - 4);
        p->slope[c] = p->unit * slope;
    }
    p->base = random_below(r, 2) ? 0 : p->unit * random_between(r, -1000, 1000);
    p->high = number >= PLAIN && random_below(r, 3) > 0;
    if (p->high) {
        const double level = pow(10, random_between(r, -4, 0));
        for (int c = 0; c < 2; c++) p->slope[c] *= level;
        if (p->unit <= 1 && random_below(r, 2)) p->base *= 1000;
    }
    const double ripple = random_below(r, 2) ? 0 : p->unit * pow(10, random_between(r, -8, -2));
    const size_t fin = random_below(r, 2) ? 0 : 20 + random_below(r, 200), holes = random_below(r, 3) ? 0 : 3000;
    const bool along = p->nx > p->ny;
    for (size_t j = 0; j < p->ny; j++)
        for (size_t i = 0; i < p->nx; i++) {
            float *z = &p->z[j * p->nx + i];
            const size_t place = along ? i : j;
            *z = (float)(p->base + p->slope[0] * (double)i + p->slope[1] * (double)j +
                         ripple * random_between(r, -1, 1));
            if (fin > 0 && place % fin == fin - 1 && 2 * place > (along ? p->nx : p->ny)) *z += (float)(p->unit * 0.01);
            if (holes > 0 && random_below(r, holes) == 0) *z = NAN;
        }
    p->z[0] = (float)p->base; /* where the plane begins: no hole */
}

static cw_ray make_ray(const plane *p, random_state *r) {
    const double side[2] = {(double)(p->nx - 1), (double)(p->ny - 1)};
    double place[2], d[2];
    for (int c = 0; c < 2; c++) {
        place[c] = side[c] * random_unit(r);
        if (random_below(r, 3) == 0) place[c] = side[c] * (double)random_below(r, 2);
        if (random_below(r, 4) == 0) place[c] = rint(place[c]);
        /* mostly along the field */
        d[c] = random_between(r, -1, 1) * (random_below(r, 2) ? side[c] : 1);
        if (place[c] == 0 || place[c] == side[c]) d[c] = place[c] == 0 ? fabs(d[c]) : -fabs(d[c]);
    }
    if (random_below(r, 8) == 0) d[random_below(r, 2)] = 0;
    if (random_below(r, 8) == 0) d[1] = d[0];
    const double steep = fabs(p->slope[0]) + fabs(p->slope[1]) + 0.01 * p->unit, sign = random_below(r, 4) ? 1 : -1;
    double dz = p->slope[0] * d[0] + p->slope[1] * d[1];
    if (random_below(r, 2)) dz += steep * pow(10, random_between(r, -10, -3)) * random_between(r, -1, 1);
    double z = (double)p->z[0] + p->slope[0] * place[0] + p->slope[1] * place[1];
    if (random_below(r, 8)) z += sign * steep * pow(10, random_between(r, -8, -1));
    if (p->high && random_below(r, 4) == 0) z += sign * fabs(p->base) * 0x1p-24 * random_between(r, 0, 8);
    /* Its length: t is as much shorter or longer. */
    const double longest = fmax(fmax(fabs(d[0]), fabs(d[1])), fabs(dz));
    double scale = longest > 0 ? 1 / longest : 1;
    if (random_below(r, 4) == 0) scale *= exp2(random_between(r, -30, 30));
    if (fabs(dz) * scale < 0x1p-126 && fabs(dz) > 0 && random_below(r, 4)) scale = 0x1p-125 / fabs(dz);
    double back = 0;
    if (random_below(r, 4) == 0)
        back = (side[0] + side[1]) * pow(10, random_between(r, -1, 3)) / fmax(fabs(d[0]), fabs(d[1]));
    if (!(back < 1e6)) back = 0;
    cw_ray ray = {.tmax = INFINITY};
    const double org[3] = {place[0], place[1], z}, dir[3] = {d[0], d[1], dz};
    for (int c = 0; c < 3; c++) {
        ray.org[c] = (float)(org[c] - back * dir[c]);
        ray.dir[c] = (float)(dir[c] * scale);
    }
    const size_t range = random_below(r, 4);
    ray.tmin = range == 0 ? -INFINITY : range == 1 ? -(float)exp2((double)random_below(r, 127)) : 0;
    return ray;
}

static void test_beside(void **state) {
    (void)state;
    static cw_ray rays[RAYS_MAX];
    plane p = {.z = malloc((size_t)512 * 512 * sizeof *p.z)};
    assert_non_null(p.z);
    random_state r = {20261122};
    as_cell_counts sum = {0};
    const size_t fields = test_share(FIELDS, 14);
    for (size_t m = 0; m < fields; m++) {
        make_plane(&p, m, &r);
        cw_field_desc d = {0};
        d.samples = p.z;
        d.nx = p.nx;
        d.ny = p.ny;
        cw_field *field;
        check_status(cw_field_create(&d, NULL, &field), CW_OK);
        const size_t n = m % 3 == 0 ? 1 + random_below(&r, 40) : RAYS_MAX - random_below(&r, 300);
        const bool alike = random_below(&r, 3) == 0;
        for (size_t k = 0; k < n; k++) {
            rays[k] = make_ray(&p, &r);
            if (alike && k % 16 != 0) { /* side by side */
                rays[k] = rays[k - 1];
                rays[k].org[k % 2] += (float)random_between(&r, -1, 1);
            }
        }
        as_cell_check(field, rays, n, &sum);
        cw_field_destroy(field);
    }
    free(p.z);
    printf("%zu rays beside %zu planes, %zu hits, the same bits in every kernel\n", sum.rays, fields, sum.hits);
    check(sum.kernels >= fields, "no kernel was compared");
    check(sum.hits > sum.rays / 10 && sum.hits < sum.rays, "too few rays hit or miss for the test to mean anything");
}

/* A ray a float's width above level ground, through the corners of cells: two cells along one axis for each along the other. It
 * touches one sample, whose first cell on the way has a hole. So its hit is in a cell that it only enters through a corner. */
static void test_corners_behind_holes(void **state) {
    (void)state;
    enum { SHORT = 300, LONG = 2 * SHORT };
    static float z[SHORT * LONG];
    const float level = 1000, ground = nextafterf(level, 0);
    as_cell_counts sum = {0};
    size_t cases = 0;
    for (int number = 0; number < 8 * 3; number++, cases++) {
        const int along = number & 1, turn_x = number & 2, turn_y = number & 4,
                  k = 150 + 60 * (number / 8); /* axis 0: x is longer */
        const int nx = along ? LONG : SHORT, ny = along ? SHORT : LONG;
        const int i = along ? 2 * k : k, j = along ? k : 2 * k, last_x = nx - 1, last_y = ny - 1;
        for (int m = 0; m < SHORT * LONG; m++) z[m] = ground;
        z[(turn_y ? last_y - j : j) * nx + (turn_x ? last_x - i : i)] = level;
        z[(turn_y ? last_y - j + 1 : j - 1) * nx + (turn_x ? last_x - i + 1 : i - 1)] = NAN;
        const cw_ray ray = {
            .org = {(float)(turn_x ? last_x : 0), (float)(turn_y ? last_y : 0), level},
            .dir = {(turn_x ? -1.0f : 1.0f) * (along ? 1 : 0.5f), (turn_y ? -1.0f : 1.0f) * (along ? 0.5f : 1), 0},
            .tmax = INFINITY};
        cw_field_desc d = {0};
        d.samples = z;
        d.nx = (size_t)nx;
        d.ny = (size_t)ny;
        cw_field *field;
        check_status(cw_field_create(&d, NULL, &field), CW_OK);
        as_cell_check(field, &ray, 1, &sum);
        cw_field_destroy(field);
    }
    check(sum.hits == cases, "%zu hits of %zu", sum.hits, cases);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_beside), cmocka_unit_test(test_corners_behind_holes)};
    return cmocka_run_group_tests_name("beside", tests, NULL, NULL);
}
