/* SPDX-License-Identifier: Apache-2.0 */
/* The caller's floating-point environment must not change a query's result. pool.c has threads and other queries. */

#include "case.h"
#include "cellwalk_expert.h"
#include "check.h"
#include "fp_register.h"

#include <math.h>
#include <string.h>

static size_t count; /* of the rays, as many as there is time for */
static cw_hit got[RAYS];

static int set_up(void **state) {
    (void)state;
    count = test_share(RAYS, 200);
    case_make(FIELD_TINY, 31, 12, 13, count);
    size_t hits = 0;
    for (size_t k = 0; k < count; k++) hits += expected[k].i >= 0;
    check(hits > count / 4, "too few hits for the tests to mean anything");
    return 0;
}

static bool same(const cw_hit *a, const cw_hit *b, size_t n) {
    for (size_t k = 0; k < n; k++)
        if (!hit_same(&a[k], &b[k])) return false;
    return true;
}

/* Flush-to-zero and denormals-are-zero change what denormal directions and heights are, rounding modes change bits. */
static void test_caller_environment(void **state) {
    (void)state;
    static uint8_t occluded[RAYS];
    if (FP_MODES == 0) skip();
    const uint64_t before = fp_register();
    for (unsigned mode = 0; mode < FP_MODES; mode++)
        for (size_t kernel = 0; kernel < cw_kernel_count(); kernel++) {
            const cw_run q = {.expert.kernel = cw_kernel_at(kernel)};
            const cw_kernel_info info = cw_kernel_describe(q.expert.kernel);
            if (!info.available || strcmp(info.name, "brute") == 0) continue;
            fp_register_set(fp_register_mode(mode));
            const cw_status closest = cw_closest(field, &q, rays, count, got),
                            any = cw_occluded(field, &q, rays, count, occluded);
            const uint64_t after = fp_register();
            fp_register_set(before);
            check(closest == CW_OK && any == CW_OK && after == fp_register_mode(mode),
                  "%s: register %#llx became %#llx", info.name, (unsigned long long)fp_register_mode(mode),
                  (unsigned long long)after);
            check(info.default_leaf != CW_LEAF_WATERTIGHT || same(got, expected, count), "%s: other hits in mode %u",
                  info.name, mode);
            for (size_t k = 0; k < count; k++)
                check(occluded[k] == (got[k].i >= 0), "%s: any hit in mode %u", info.name, mode);
        }
}

/* Samples so small that a caller's DAZ turns them to zero: the field's range and its structures must not. */
static void test_field_made_under_daz(void **state) {
    (void)state;
    if (FP_MODES == 0) skip();
    static test_field small;
    static cw_hit here[RAYS];
    random_state r = {14};
    field_make(&small, FIELD_RANDOM, 9, 9, 14);
    for (size_t k = 0; k < 81; k++) small.z[k] = (small.z[k] - 0.5f) * 0x1p-127f;
    small.low = -0x1p-128f;
    small.high = 0x1p-128f;
    static cw_ray down[500];
    for (size_t k = 0; k < 500; k++)
        down[k] = (cw_ray){.org = {8 * (float)random_unit(&r), 8 * (float)random_unit(&r), 0x1p-126f},
                           .dir = {0, 0, -0x1p-127f},
                           .tmax = INFINITY};
    size_t hits = 0;
    const uint64_t before = fp_register();
    cw_field *plain = field_open(&small);
    fp_register_set(fp_register_mode(FP_FLUSHES));
    cw_field *under_daz = field_open(&small);
    fp_register_set(before);
    const cw_field_info a = cw_field_describe(plain), b = cw_field_describe(under_daz);
    check(a.low == b.low && a.high == b.high, "range %a to %a, but %a to %a under DAZ", (double)a.low, (double)a.high,
          (double)b.low, (double)b.high);
    for (size_t k = 0; k < cw_kernel_count(); k++) {
        const cw_run q = {.expert.kernel = cw_kernel_at(k)};
        if (!cw_kernel_describe(q.expert.kernel).available) continue;
        check_status(cw_closest(plain, &q, down, 500, here), CW_OK);
        check_status(cw_closest(under_daz, &q, down, 500, got), CW_OK);
        check(same(here, got, 500), "%s: other hits in a field made under DAZ",
              cw_kernel_describe(q.expert.kernel).name);
        for (size_t m = 0; m < 500; m++) hits += here[m].i >= 0;
    }
    check(hits > 500, "too few hits for the test to mean anything");
    cw_field_destroy(plain);
    cw_field_destroy(under_daz);
}

/* The map and its inverse, and the way from user space. */
static void test_spaces_under_other_rounding(void **state) {
    (void)state;
    if (FP_MODES == 0) skip();
    const cw_user_ray in = {.org = {0.1, 0.2, 0.3}, .dir = {1.0 / 3, 0.7, -0.9}, .tmax = 1e3};
    cw_field_desc d = {.samples = shape.z, .nx = shape.nx, .ny = shape.ny};
    for (int c = 0; c < 3; c++) d.map[c][c] = 0.3, d.map[c][3] = 0.7;
    const uint64_t before = fp_register();
    cw_ray ray[4];
    for (unsigned mode = 0; mode < 4; mode++) {
        cw_field *f;
        memset(&ray[mode], 0, sizeof ray[mode]);
        fp_register_set(fp_register_mode(4 * mode));
        const cw_status status = cw_field_create(&d, NULL, &f);
        cw_rays_to_field(f, NULL, &in, 1, &ray[mode]);
        fp_register_set(before);
        check_status(status, CW_OK);
        check(memcmp(&ray[mode], &ray[0], sizeof ray[0]) == 0, "other field-space ray under rounding mode %u", mode);
        cw_field_destroy(f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_caller_environment),
        cmocka_unit_test(test_field_made_under_daz),
        cmocka_unit_test(test_spaces_under_other_rounding),
    };
    return cmocka_run_group_tests_name("environment", tests, set_up, case_end);
}
