/* SPDX-License-Identifier: Apache-2.0 */
/* Headings: the steepest rise from every sample, held against all edges of the field one by one in double; the same bits for
 * every instruction set, number of threads and rectangle; whether a ray hits, and how steep the rise is, said alike. */

#include "cellwalk_expert.h"
#include "check.h"
#include "crossings.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Of all directions and fields one in that many. */
static size_t step(void) { return test_step(10); }

/* The headings that are tried: where they end, and how the earth is curved. */
static double reach = 0, drop = 0;

/* The error bound is 2^-21 of the steeper of the rises to an edge's samples. */
static double brute(const test_field *f, size_t i, size_t j, const double dir[2], double *allowed) {
    static crossing all[CROSSINGS_MAX];
    const double start[3] = {(double)i, (double)j, (double)f->z[j * f->nx + i]};
    const size_t count = crossings_find(f, start, dir, drop, all);
    double steepest = -INFINITY;
    *allowed = 0;
    for (size_t k = 0; k < count && !(reach > 0 && all[k].t > reach); k++) {
        if (isnan(all[k].slope)) continue;
        steepest = fmax(steepest, all[k].slope);
        *allowed = fmax(*allowed, 0x1p-21 * all[k].steep + 0x1p-23 * drop * all[k].t);
    }
    return steepest;
}

static cw_heading *heading_open(const cw_field *field, const double dir[2]) {
    cw_heading *h = NULL;
    const cw_heading_desc desc = {.dir = {dir[0], dir[1]}, .reach = reach, .drop = drop};
    check_status(cw_heading_create(field, &desc, &h), CW_OK);
    return h;
}

/* Those of all samples. */
static void slopes_of(const cw_field *field, const double dir[2], float *slope) {
    const cw_field_info info = cw_field_describe(field);
    cw_heading *h = heading_open(field, dir);
    check_status(cw_heading_steepest(h, NULL, -INFINITY, INFINITY, (cw_rectangle){0, 0, info.nx, info.ny}, slope),
                 CW_OK);
    cw_heading_destroy(h);
}

static void check_sample(const test_field *f, const float *slope, size_t at, const double dir[2]) {
    const size_t i = at % f->nx, j = at / f->nx;
    double allowed;
    const double wanted = brute(f, i, j, dir, &allowed), got = (double)slope[at];
    check(isnan(f->z[at]) ? isnan(got) : got == wanted || fabs(got - wanted) <= allowed + 0x1p-140,
          "%s %zu x %zu, from (%zu, %zu) along (%a, %a): %.9g, not %.9g", field_shape_name(f->shape), f->nx, f->ny, i,
          j, dir[0], dir[1], got, wanted);
}

static float slope[FIELD_SAMPLES_MAX], plain[FIELD_SAMPLES_MAX];

/* Without bounds, where nothing is passed over, the bits are the same from every sample. */
static void check_against_brute(const test_field *f, uint64_t seed) {
    random_state r = {seed};
    cw_field *field = field_open(f), *bare;
    const cw_field_desc desc = {.samples = f->z, .nx = f->nx, .ny = f->ny};
    check_status(cw_field_create(&desc, &(cw_run){.expert.kernel = cw_kernel_find("cell")}, &bare), CW_OK);
    for (size_t d = 0; d < 20; d += step()) {
        const size_t all = f->nx * f->ny, most = test_share(200, 40), some = all > most ? most : all;
        double dir[2];
        line_direction(&r, d, dir);
        slopes_of(field, dir, slope);
        slopes_of(bare, dir, plain);
        assert_memory_equal(slope, plain, all * sizeof *plain);
        for (size_t k = 0; k < some; k++) check_sample(f, slope, some == all ? k : random_below(&r, all), dir);
    }
    cw_field_destroy(field);
    cw_field_destroy(bare);
}

static test_field field_a;

static void every_edge_counts(void **state) {
    (void)state;
    for (field_shape shape = 0; shape < FIELD_SHAPES; shape++)
        for (size_t s = 0; s < FIELD_SIZES; s++) {
            if (shape == FIELD_HUGE || shape == FIELD_MIXED) continue; /* whose slopes are no floats */
            field_make(&field_a, shape, field_sizes[s].nx, field_sizes[s].ny, 7 + s);
            check_against_brute(&field_a, 11 * (uint64_t)shape + s);
        }
}

/* A wall on the far border, 16 k columns from the first one. By rounding its crossing may be the first one of the next
 * stretch, of whose samples no other lies in the field. */
static void walls_on_the_border_count(void **state) {
    (void)state;
    random_state r = {20261123};
    test_field *f = &field_a;
    for (size_t nx = 17; nx <= 49; nx += 16) {
        field_make(f, FIELD_RANDOM, nx, 30, nx);
        for (size_t j = 0; j < f->ny; j++)
            for (size_t i = 0; i < nx; i++)
                f->z[j * nx + i] = (float)random_unit(&r) + (i == nx - 1 ? (float)(4 * nx) : 0);
        cw_field *field = field_open(f);
        for (size_t d = 0; d < 40; d++) {
            const double angle = random_between(&r, -0.7, 0.7), dir[2] = {cos(angle), sin(angle)};
            slopes_of(field, dir, slope);
            for (size_t at = 0; at < nx * f->ny; at += 16) check_sample(f, slope, at, dir);
        }
        cw_field_destroy(field);
    }
}

static void stretches_are_passed_over_rightly(void **state) {
    (void)state;
    field_make_land(&field_a, 255, 256);
    check_against_brute(&field_a, 5);
    field_make_land(&field_a, 1000, 60);
    check_against_brute(&field_a, 6);
    field_make(&field_a, FIELD_FLAT, 230, 150,
               1); /* single high samples in level land are what a bound must not miss */
    for (size_t k = 0; k < 4; k++) field_a.z[(k * 9001 + 77) % (230 * 150)] += 4 + (float)k;
    check_against_brute(&field_a, 7);
}

/* Headings that end after some cells, on an earth that is flat, a little curved, and as round as a ball. No crossing lies
 * within rounding of these ends. */
static void ends_and_curvature_count(void **state) {
    (void)state;
    static const double reaches[] = {0, 0.3137, 5.2713, 61.317}, drops[] = {0, 1e-4, 0.05};
    for (size_t k = 1; k < 12; k++) {
        reach = reaches[k % 4];
        drop = drops[k / 4];
        if (!test_takes(k, 4)) continue;
        field_make_land(&field_a, 255, 130);
        check_against_brute(&field_a, 20 + k);
        field_make(&field_a, FIELD_HOLES, 40, 31, k);
        check_against_brute(&field_a, 40 + k);
    }
    reach = drop = 0;
}

/* All instruction sets, threads and ways to cut the field up give the same bits. */
static void check_bits(size_t first_direction) {
    enum { NX = 203, NY = 187 };
    static float first[NX * NY];
    static uint8_t hit[NX * NY];
    random_state r = {99};
    field_make_land(&field_a, NX, NY);
    for (size_t k = 0; k < 300; k++) field_a.z[random_below(&r, NX * NY)] = NAN;
    cw_field *field = field_open(&field_a);
    cw_pool *pool = NULL;
    check_status(cw_pool_create(3, &pool), CW_OK);
    for (size_t d = 0; d < 24; d++) {
        double dir[2];
        line_direction(&r, d, dir);
        if (!test_takes(first_direction + d, 16)) continue;
        cw_heading *h = heading_open(field, dir);
        for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
            cw_isa_limit((cw_isa)isa);
            if ((int)cw_isa_best() != isa) continue;
            cw_run query = (cw_run){0};
            query.pool = isa % 2 ? pool : NULL;
            check_status(cw_heading_steepest(h, &query, -INFINITY, INFINITY, (cw_rectangle){0, 0, NX, NY},
                                             isa == CW_ISA_SCALAR ? first : slope),
                         CW_OK);
            if (isa > CW_ISA_SCALAR) assert_memory_equal(first, slope, sizeof first);

            const float threshold = first[random_below(&r, NX * NY)]; /* equal to one: a touch is a hit */
            if (!isfinite(threshold)) continue;
            check_status(cw_heading_occluded(h, &query, threshold, (cw_rectangle){0, 0, NX, NY}, hit), CW_OK);
            for (size_t k = 0; k < NX * NY; k++)
                check(hit[k] == (first[k] >= threshold),
                      "sample %zu: %d where the steepest is %a and the ray rises by %a", k, hit[k], (double)first[k],
                      (double)threshold);

            /* Told apart from low to high. */
            const float low = -0.5f, high = threshold > low ? threshold : low;
            check_status(cw_heading_steepest(h, &query, low, high, (cw_rectangle){0, 0, NX, NY}, slope), CW_OK);
            for (size_t k = 0; k < NX * NY; k++) {
                const float wanted = first[k] < low ? low : first[k] > high ? high : first[k];
                check(memcmp(&slope[k], &wanted, sizeof wanted) == 0, "sample %zu: %a, not %a", k, (double)slope[k],
                      (double)wanted);
            }

            const size_t i = random_below(&r, NX), j = random_below(&r, NY), nx = 1 + random_below(&r, NX - i),
                         ny = 1 + random_below(&r, NY - j);
            check_status(cw_heading_steepest(h, &query, -INFINITY, INFINITY, (cw_rectangle){i, j, nx, ny}, slope),
                         CW_OK);
            for (size_t k = 0; k < nx * ny; k++)
                check(memcmp(&slope[k], &first[(j + k / nx) * NX + i + k % nx], sizeof slope[k]) == 0,
                      "rectangle %zu x %zu at (%zu, %zu) differs from the whole at number %zu", nx, ny, i, j, k);
        }
        cw_isa_limit(CW_ISA_ANY);
        cw_heading_destroy(h);
    }
    cw_pool_destroy(pool);
    cw_field_destroy(field);
}

static void bits_are_the_same(void **state) {
    (void)state;
    check_bits(0);
    drop = 0.001;
    check_bits(5);
    reach = 33;
    check_bits(10);
    drop = reach = 0;
}

/* From the first sample, at -2^23, the ray along (1, 3/4) crosses one edge, at t = 5, three quarters of the way from a to a + 2. Both
 * rise from the start by a tie, which rounds to 2^24 + 4: up from a, down from a + 2. With the step along the edge the rise is
 * 2^24 + 6, above that to the higher sample. A bound that leaves rounding out passes the stretch over. */
static void rounding_above_both_samples_counts(void **state) {
    (void)state;
    enum { NX = 20, NY = 16 };
    test_field *f = &field_a;
    field_make(f, FIELD_FLAT, NX, NY, 1);
    for (size_t k = 0; k < NX * NY; k++) f->z[k] = NAN;
    f->z[0] = -0x1p23f;
    f->z[3 * NX + 5] = 0x1p23f + 3;
    f->z[4 * NX + 5] = 0x1p23f + 5;
    const float known = (0x1p24f + 4) / 5; /* the rise to the higher sample: anything steeper counts */
    cw_field *field = field_open(f);
    cw_heading *h = heading_open(field, (double[2]){1, 0.75});
    for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
        cw_isa_limit((cw_isa)isa);
        check_status(cw_heading_steepest(h, NULL, known, INFINITY, (cw_rectangle){0, 0, NX, NY}, slope), CW_OK);
        check(slope[0] == known + 0.5f, "%.9g, not %.9g", (double)slope[0], (double)(known + 0.5f));
    }
    cw_isa_limit(CW_ISA_ANY);
    cw_heading_destroy(h);
    cw_field_destroy(field);
}

static void misuse_is_refused(void **state) {
    (void)state;
    field_make(&field_a, FIELD_RANDOM, 5, 4, 1);
    cw_field *field = field_open(&field_a);
    cw_heading *h;
    const cw_heading_desc wrong[] = {{.dir = {0, 0}},
                                     {.dir = {NAN, 1}},
                                     {.dir = {1, INFINITY}},
                                     {.dir = {0x1p41, 0}},
                                     {.dir = {0x1p-41, 0}},
                                     {.dir = {1, 0}, .reach = -1},
                                     {.dir = {1, 0}, .drop = -1},
                                     {.dir = {1, 0}, .reach = INFINITY},
                                     {.dir = {1, 0}, .drop = 0x1p80}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        h = (cw_heading *)&field_a;
        check_status(cw_heading_create(field, &wrong[k], &h), CW_ERROR_ARGUMENT);
        assert_null(h);
    }
    h = heading_open(field, (double[2]){1, 0});
    uint8_t hit[20];
    const cw_rectangle all = {0, 0, 5, 4};
    const cw_run misspelt = {.expert.kernel = cw_kernel_find("packet99")};
    check_status(cw_heading_steepest(h, NULL, 1, 0, all, slope), CW_ERROR_ARGUMENT);
    const cw_rectangle outside[] = {{1, 0, 5, 4}, {0, SIZE_MAX, 5, 4}};
    for (int k = 0; k < 2; k++)
        check_status(cw_heading_steepest(h, NULL, -INFINITY, INFINITY, outside[k], slope), CW_ERROR_ARGUMENT);
    check_status(cw_heading_steepest(h, &misspelt, 0, 1, all, slope), CW_ERROR_KERNEL);
    check_status(cw_heading_steepest(h, NULL, -INFINITY, INFINITY, (cw_rectangle){5, 4, 0, 0}, slope), CW_OK);
    check_status(cw_heading_occluded(h, NULL, -INFINITY, all, hit), CW_OK);
    for (size_t k = 0; k < 20; k++) assert_int_equal(hit[k], k % 5 < 4); /* the last column sees nothing */
    check_status(cw_heading_occluded(h, NULL, INFINITY, all, hit), CW_OK);
    for (size_t k = 0; k < 20; k++) assert_int_equal(hit[k], 0);
    cw_heading_destroy(h);
    cw_heading_destroy(NULL);
    cw_field_destroy(field);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_edge_counts),
        cmocka_unit_test(stretches_are_passed_over_rightly),
        cmocka_unit_test(ends_and_curvature_count),
        cmocka_unit_test(bits_are_the_same),
        cmocka_unit_test(walls_on_the_border_count),
        cmocka_unit_test(misuse_is_refused),
        cmocka_unit_test(rounding_above_both_samples_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
