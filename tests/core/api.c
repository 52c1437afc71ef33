/* SPDX-License-Identifier: Apache-2.0 */
/* The public functions: misuse gives the documented status, arrays of any length and alignment give the documented result,
 * and rays are moved to the field in one way. */

#include "case.h"
#include "cellwalk_expert.h"
#include "check.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- misuse ----------------------------------------------------------------------------------------------------- */

static cw_status try_create(cw_field_desc desc) {
    cw_field *f = (cw_field *)&desc; /* anything but NULL: failure has to reset it */
    const cw_status status = cw_field_create(&desc, NULL, &f);
    check((f == NULL) == (status != CW_OK), "field %p with status %d", (void *)f, (int)status);
    cw_field_destroy(f);
    return status;
}

static void test_bad_fields(void **state) {
    (void)state;
    static const float z[12] = {0};
    const struct {
        size_t nx, ny, stride;
        int storage;
        cw_status status;
    } cases[] = {
        {3, 2, 0, CW_COPY, CW_OK},
        {3, 2, 6, CW_COPY, CW_OK},
        {3, 2, 0, 2, CW_ERROR_ARGUMENT},
        {46341, 46341, 0, CW_COPY, CW_ERROR_ARGUMENT}, /* 46341 squared is the first square above 2^31 */
        {3, 2, 2, CW_COPY, CW_ERROR_ARGUMENT},
        {3, 2, SIZE_MAX / 4, CW_COPY, CW_ERROR_ARGUMENT},
        {3, 2, SIZE_MAX, CW_COPY, CW_ERROR_ARGUMENT},
        {3, 2, (size_t)1 << 31, CW_BORROW, CW_ERROR_ARGUMENT},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++)
        check_status(try_create((cw_field_desc){.samples = z,
                                                .nx = cases[k].nx,
                                                .ny = cases[k].ny,
                                                .stride = cases[k].stride,
                                                .storage = (cw_storage)cases[k].storage}),
                     cases[k].status);
    const size_t sides[] = {0, 1, (size_t)CW_SIDE_MAX + 1, SIZE_MAX / 2 + 1, SIZE_MAX};
    for (size_t k = 0; k < 3 * (sizeof sides / sizeof sides[0]); k++)
        check_status(try_create((cw_field_desc){
                         .samples = z, .nx = k % 3 == 1 ? 3 : sides[k / 3], .ny = k % 3 == 0 ? 2 : sides[k / 3]}),
                     CW_ERROR_ARGUMENT);
}

static void test_bad_maps(void **state) {
    (void)state;
    static const float z[4] = {0};
    static const struct {
        double map[3][4];
        cw_status status;
    } cases[] = {
        {{{1}, {0, 0}, {0, 0, 1}}, CW_ERROR_ARGUMENT},      /* a row of zeros */
        {{{1}, {1, 0}, {0, 0, 1}}, CW_ERROR_ARGUMENT},      /* two equal rows */
        {{{1}, {0, 1}, {0, 0, 1e-320}}, CW_ERROR_ARGUMENT}, /* the inverse overflows */
        {{{1e-9}, {0, 1e-9}, {0, 0, 1e-9}}, CW_OK},         /* nanometres are no singular map */
        {{{0, 0, 0, 1}, {0}, {0}}, CW_ERROR_ARGUMENT},      /* a translation alone is no map */
    };
    cw_field_desc d = {.samples = z, .nx = 2, .ny = 2};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        memcpy(d.map, cases[k].map, sizeof d.map);
        check_status(try_create(d), cases[k].status);
    }
    for (int k = 0; k < 3 * 12; k++) {
        static const double good[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        memcpy(d.map, good, sizeof d.map);
        d.map[k / 12][k / 3 % 4] = (const double[]){(double)NAN, (double)INFINITY, -(double)INFINITY}[k % 3];
        check_status(try_create(d), CW_ERROR_ARGUMENT);
    }
}

/* Beyond these, strict answers could overflow. */
static void test_heights_that_are_too_large(void **state) {
    (void)state;
    float z[4] = {0, CW_HEIGHT_MAX, -CW_HEIGHT_MAX, NAN};
    cw_field_desc d = {.samples = z, .nx = 2, .ny = 2};
    for (int storage = CW_COPY; storage <= CW_BORROW; storage++) {
        d.storage = (cw_storage)storage;
        check_status(try_create(d), CW_OK);
        z[1] = nextafterf(CW_HEIGHT_MAX, INFINITY);
        check_status(try_create(d), CW_ERROR_SAMPLE);
        z[1] = CW_HEIGHT_MAX;
        z[2] = -FLT_MAX;
        check_status(try_create(d), CW_ERROR_SAMPLE);
        z[2] = -CW_HEIGHT_MAX;
    }
}

static void test_pool_sizes(void **state) {
    (void)state;
    static const unsigned sizes[] = {CW_THREADS_MAX + 1, 4000000000, UINT32_MAX};
    cw_pool *pool;
    for (size_t k = 0; k < sizeof sizes / sizeof sizes[0]; k++) {
        pool = (cw_pool *)&pool;
        check_status(cw_pool_create(sizes[k], &pool), CW_ERROR_ARGUMENT);
        assert_null(pool);
    }
    check_status(cw_pool_create(0, &pool), CW_OK);
    check(cw_pool_threads(pool) >= 1 && cw_pool_threads(pool) <= CW_THREADS_MAX, "%u threads", cw_pool_threads(pool));
    cw_pool_destroy(pool);
    cw_pool_destroy(NULL);
    assert_int_equal(cw_pool_threads(NULL), 1);
}

static void test_holes_in_borrowed_samples(void **state) {
    (void)state;
    float z[4] = {0, NAN, 1, 2};
    cw_field_desc d = {.samples = z, .nx = 2, .ny = 2, .storage = CW_BORROW};
    check_status(try_create(d), CW_OK);
    z[1] = -INFINITY;
    check_status(try_create(d), CW_ERROR_SAMPLE);
    d.storage = CW_COPY;
    cw_field *f;
    check_status(cw_field_create(&d, NULL, &f), CW_OK);
    const cw_field_info info = cw_field_describe(f);
    assert_int_equal(info.holes, 1);
    check(info.low == 0 && info.high == 2, "holes count in the range %g to %g", (double)info.low, (double)info.high);
    cw_field_destroy(f);
    z[0] = z[1] = z[2] = z[3] = NAN;
    check_status(cw_field_create(&d, NULL, &f), CW_OK);
    check(cw_field_describe(f).low > cw_field_describe(f).high, "a field of holes has a range");
    cw_field_destroy(f);
}

/* In every tile of a field, which are summed up by rows of tiles. */
static void test_holes_are_counted(void **state) {
    (void)state;
    enum { NX = 200, NY = 140, STEP = 37 };
    float *z = calloc(NX * NY, sizeof *z);
    assert_non_null(z);
    size_t holes = 0;
    for (size_t k = 0; k < (size_t)NX * NY; k += STEP, holes++) z[k] = NAN;
    cw_field *f = field_of(z, NX, NY);
    assert_int_equal(cw_field_describe(f).holes, holes);
    cw_field_destroy(f);
    free(z);
}

static void test_bad_queries(void **state) {
    (void)state;
    uint8_t occluded[2];
    cw_hit hits[2];
    memset(hits, 0x5a, sizeof hits);
    memset(occluded, 0x5a, sizeof occluded);
    cw_run q = (cw_run){0};
    q.expert.leaf = (cw_leaf)CW_LEAF_COUNT;
    check_status(cw_closest(field, &q, rays, 2, hits), CW_ERROR_ARGUMENT);
    q.expert.leaf = (cw_leaf)-1;
    check_status(cw_occluded(field, &q, rays, 2, occluded), CW_ERROR_ARGUMENT);
    q.expert.leaf = CW_LEAF_WATERTIGHT;
    q.expert.kernel = cw_kernel_find("packet99");
    check_status(cw_closest(field, &q, rays, 2, hits), CW_ERROR_KERNEL);
    check_status(cw_occluded(field, &q, rays, 2, occluded), CW_ERROR_KERNEL);
    check_status(cw_closest(field, &q, NULL, 0, NULL), CW_ERROR_KERNEL);
    check_status(cw_field_build(field, &(cw_run){.expert.kernel = q.expert.kernel}), CW_ERROR_KERNEL);
    assert_ptr_equal(cw_run_kernel(field, &q), q.expert.kernel);
    q.expert.kernel = cw_kernel_find("brute");
    check_status(cw_closest(field, &q, rays, 2, hits), CW_ERROR_KERNEL);
    check_status(cw_occluded(field, &q, rays, 2, occluded), CW_ERROR_KERNEL);

    cw_field *f = field_of(shape.z, 2, 2);
    q = (cw_run){.expert.kernel = cw_kernel_find("grid3d")};
    assert_true(cw_kernel_describe(q.expert.kernel).needs_build);
    check_status(cw_closest(f, &q, rays, 2, hits), CW_ERROR_NOT_BUILT);
    check_status(cw_occluded(f, &q, rays, 2, occluded), CW_ERROR_NOT_BUILT);
    const size_t bounds = cw_field_describe(f).bytes_built;
    check_status(cw_field_build(f, NULL), CW_OK); /* the default kernel needs the bounds alone */
    assert_int_equal(cw_field_describe(f).bytes_built, bounds);
    check_status(cw_field_build(f, &(cw_run){.expert.kernel = q.expert.kernel}), CW_OK);
    const size_t built = cw_field_describe(f).bytes_built;
    check(built > bounds && bounds > 0, "a build of no bytes");
    check_status(cw_field_build(f, &(cw_run){.expert.kernel = q.expert.kernel}), CW_OK);
    assert_int_equal(cw_field_describe(f).bytes_built, built);
    check_status(cw_closest(f, &q, rays, 1, hits), CW_OK);
    memset(hits, 0x5a, sizeof hits);
    /* An update drops what it does not keep up to date. */
    const cw_update one = {.at = {1, 1, 1, 1}, .samples = shape.z};
    check_status(cw_field_update(f, NULL, &one), CW_OK);
    check_status(cw_closest(f, &q, rays, 2, hits), CW_ERROR_NOT_BUILT);
    assert_int_equal(cw_field_describe(f).bytes_built, bounds);
    cw_field_destroy(f);
    cw_field_destroy(NULL);

    for (size_t k = 0; k < sizeof hits; k++) check(((uint8_t *)hits)[k] == 0x5a, "an error wrote to the hits");
    for (size_t k = 0; k < sizeof occluded; k++) check(occluded[k] == 0x5a, "an error wrote to the results");
}

static void test_names(void **state) {
    (void)state;
    for (int s = CW_OK; s <= CW_ERROR_CANCELLED; s++) {
        const char *text = cw_status_message((cw_status)s);
        assert_non_null(text);
        check(strlen(text) > 5 && text[strlen(text) - 1] != '.', "status %d: \"%s\"", s, text);
        for (int other = CW_OK; other < s; other++) assert_string_not_equal(text, cw_status_message((cw_status)other));
    }
    assert_non_null(cw_status_message((cw_status)-1));
    assert_non_null(cw_status_message((cw_status)1000));
    assert_null(cw_isa_name((cw_isa)CW_ISA_COUNT));
    assert_null(cw_isa_name((cw_isa)-1));
    assert_null(cw_leaf_name((cw_leaf)CW_LEAF_COUNT));
    assert_string_equal(cw_leaf_name(CW_LEAF_WATERTIGHT), "watertight");
    assert_null(cw_kernel_at(cw_kernel_count()));
    assert_null(cw_kernel_at(SIZE_MAX));
    static const char *const unknown[] = {NULL, "", "packet", "packet99", "none"};
    for (size_t k = 0; k < sizeof unknown / sizeof unknown[0]; k++) {
        const cw_kernel *none = cw_kernel_find(unknown[k]);
        check(none != NULL && !cw_kernel_exists(none), "'%s' is a kernel, or NULL", unknown[k]);
        check(!cw_kernel_describe(none).available, "'%s' is available", unknown[k]);
    }
    assert_false(cw_kernel_exists(NULL));
    assert_string_equal(cw_kernel_describe(NULL).name, "none");
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        assert_ptr_equal(cw_kernel_find(info.name), cw_kernel_at(k));
        assert_true(cw_kernel_exists(cw_kernel_at(k)));
        check(info.width >= 1 && info.what != NULL && strlen(info.what) > 5, "%s: width or description", info.name);
        check(info.default_leaf != CW_LEAF_DEFAULT, "%s: no default leaf test", info.name);
    }
}

static void test_borrowed_and_copied(void **state) {
    (void)state;
    float z[6] = {1, 1, 9, 1, 1, 9}; /* 2 × 2 in rows of three */
    cw_field_desc d = {.samples = z, .nx = 2, .ny = 2, .stride = 3};
    cw_field *copied, *borrowed;
    check_status(cw_field_create(&d, NULL, &copied), CW_OK);
    d.storage = CW_BORROW;
    check_status(cw_field_create(&d, NULL, &borrowed), CW_OK);
    assert_int_equal(cw_field_describe(copied).bytes_samples, 4 * sizeof(float));
    assert_int_equal(cw_field_describe(borrowed).bytes_samples, 0);
    check(cw_field_describe(borrowed).high == 1, "a sample between rows counts");
    z[0] = z[1] = z[3] = z[4] = NAN;
    const cw_ray down = {.org = {0.25f, 0.5f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run q = {.expert.kernel = cw_kernel_at(k)};
        if (!cw_kernel_describe(q.expert.kernel).available) continue;
        cw_hit hit;
        check_status(cw_field_build(copied, &(cw_run){.expert.kernel = q.expert.kernel}), CW_OK);
        check_status(cw_closest(copied, &q, &down, 1, &hit), CW_OK);
        check(fabsf(hit.t - 2) <= 0x1p-22f && hit.triangle == CW_TRIANGLE_B, "%s: the copy changed",
              cw_kernel_describe(q.expert.kernel).name);
        check_status(cw_field_build(borrowed, &(cw_run){.expert.kernel = q.expert.kernel}), CW_OK);
        check_status(cw_closest(borrowed, &q, &down, 1, &hit), CW_OK);
        check(hit.i == -1, "%s: borrowed samples are not read in place", cw_kernel_describe(q.expert.kernel).name);
    }
    cw_field_destroy(copied);
    cw_field_destroy(borrowed);
}

/* ---- arrays ----------------------------------------------------------------------------------------------------- */

static void test_lengths_and_alignment(void **state) {
    (void)state;
    enum { LONGEST = 67, CANARY = 64 };
    /* Rays and hits at every multiple of four bytes, hits and results between canaries. */
    uint8_t *in = malloc(LONGEST * sizeof(cw_ray) + 64), *out = malloc(LONGEST * sizeof(cw_hit) + 64 + 2 * CANARY);
    check(in != NULL && out != NULL, "out of memory");
    for (size_t kernel = 0; kernel < cw_kernel_count(); kernel++) {
        const cw_run q = {.expert.kernel = cw_kernel_at(kernel)};
        const cw_kernel_info info = cw_kernel_describe(q.expert.kernel);
        if (!info.available) continue;
        cw_hit single[LONGEST];
        for (size_t k = 0; k < LONGEST; k++) check_status(cw_closest(field, &q, &rays[k], 1, &single[k]), CW_OK);
        for (size_t n = 0; n <= LONGEST; n++) {
            const size_t offset = 4 * (n % 16), size = n * sizeof(cw_hit);
            memcpy(in + offset, rays, n * sizeof(cw_ray));
            const cw_ray *from = (const cw_ray *)(const void *)(in + offset);
            cw_hit *hits = (cw_hit *)(void *)(out + CANARY + offset);
            memset(out, 0xc3, LONGEST * sizeof(cw_hit) + 64 + 2 * CANARY);
            check_status(cw_closest(field, &q, from, n, hits), CW_OK);
            for (size_t k = 0; k < n; k++)
                check(hit_same(&hits[k], &single[k]), "%s: ray %zu of %zu differs from itself alone", info.name, k, n);
            for (size_t k = 0; k < CANARY + offset; k++) check(out[k] == 0xc3, "%s: wrote before hits", info.name);
            for (size_t k = CANARY + offset + size; k < LONGEST * sizeof(cw_hit) + 64 + 2 * CANARY; k++)
                check(out[k] == 0xc3, "%s: wrote beyond %zu hits", info.name, n);

            uint8_t *occluded = out + CANARY + n % 16;
            memset(out, 0xc3, LONGEST + 16 + 2 * CANARY);
            check_status(cw_occluded(field, &q, from, n, occluded), CW_OK);
            for (size_t k = 0; k < n; k++)
                check(occluded[k] == (single[k].i >= 0), "%s: any hit, ray %zu of %zu", info.name, k, n);
            for (const uint8_t *p = out; p < occluded; p++) check(*p == 0xc3, "%s: wrote before results", info.name);
            for (const uint8_t *p = occluded + n; p < out + LONGEST + 16 + 2 * CANARY; p++)
                check(*p == 0xc3, "%s: wrote beyond %zu results", info.name, n);
        }
    }
    free(in);
    free(out);
}

/* ---- rays moved to the field --------------------------------------------------------------------------------------- */

/* A map with shear, rotation and a far origin; mirrored, so that orientation is not taken for granted. */
static const double map[3][4] = {{2, -0.5, 0.125, 300}, {0.75, 3, 0, -20}, {0.25, 0, -1.5, 7}};

/* Every instruction set moves rays in the same way, bit for bit, whatever is in them. */
static void test_moved_rays_agree(void **state) {
    (void)state;
    enum { N = 500 };
    static cw_user_ray given[N];
    static cw_ray got_rays[2][N];
    cw_field *f = field_mapped(shape.z, shape.nx, shape.ny, map);
    random_state r = {12};
    for (size_t k = 0; k < N; k++) {
        for (int c = 0; c < 3; c++) {
            given[k].org[c] = random_between(&r, -1000, 1000);
            given[k].dir[c] = random_between(&r, -1, 1);
        }
        given[k].tmin = random_between(&r, -1, 1);
        given[k].tmax = k % 2 ? INFINITY : random_between(&r, 1, 1e60);
        /* Sums that cancel show in what order they were taken. */
        for (int c = 0; c < 3 && k % 4 == 1; c++) {
            given[k].org[c] = map[c][3] + random_between(&r, -1e-12, 1e-12);
            given[k].dir[c] = map[c][0] + 2 * map[c][1] + random_between(&r, -1e-15, 1e-15);
        }
        if (k % 16 == 3) given[k].org[k / 16 % 3] = INFINITY;
    }
    const cw_isa best = cw_isa_best();
    cw_rays_to_field(f, NULL, given, N, got_rays[0]);
    for (int number = CW_ISA_SCALAR; number < CW_ISA_COUNT; number++) {
        const cw_isa isa = (cw_isa)number;
        if (!cw_isa_includes(best, isa)) continue;
        cw_isa_limit(isa);
        cw_rays_to_field(f, NULL, given, N, got_rays[1]);
        for (size_t k = 0; k < N; k++) {
            const float *a = got_rays[0][k].org, *b = got_rays[1][k].org; /* a NaN has no one bit pattern */
            for (int c = 0; c < 3; c++)
                check(a[c] == b[c] || (isnan(a[c]) && isnan(b[c])), "%s moves an origin elsewhere", cw_isa_name(isa));
            check(memcmp(got_rays[0][k].dir, got_rays[1][k].dir, sizeof got_rays[0][k].dir) == 0 &&
                      memcmp(&got_rays[0][k].tmin, &got_rays[1][k].tmin, sizeof(float)) == 0 &&
                      memcmp(&got_rays[0][k].tmax, &got_rays[1][k].tmax, sizeof(float)) == 0 &&
                      got_rays[1][k].tmin == (float)given[k].tmin && got_rays[1][k].tmax == (float)given[k].tmax,
                  "%s moves ray %zu otherwise", cw_isa_name(isa), k);
        }
    }
    cw_isa_limit(best);
    cw_field_destroy(f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bad_fields),
        cmocka_unit_test(test_bad_maps),
        cmocka_unit_test(test_heights_that_are_too_large),
        cmocka_unit_test(test_pool_sizes),
        cmocka_unit_test(test_holes_in_borrowed_samples),
        cmocka_unit_test(test_holes_are_counted),
        cmocka_unit_test(test_bad_queries),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_borrowed_and_copied),
        cmocka_unit_test(test_lengths_and_alignment),
        cmocka_unit_test(test_moved_rays_agree),
    };
    return cmocka_run_group_tests_name("api", tests, case_begin, case_end);
}
