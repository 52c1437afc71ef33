/* SPDX-License-Identifier: Apache-2.0 */
/* Calls of few rays, for which the library chooses other kernels, have the bits of large ones; and limits on instruction sets hold for a
 * run from its beginning on. */

#include "cellwalk_expert.h"
#include "check.h"
#include "rays.h"

#include <string.h>

enum { RAYS = 6000, MOST = 17 };
static test_field shape;
static cw_field *field;
static cw_ray rays[RAYS];
static cw_user_ray user_rays[RAYS];
static cw_hit expected[RAYS], got[RAYS];
static uint8_t occluded[MOST];

static int set_up(void **state) {
    (void)state;
    field = ray_case(&shape, FIELD_RANDOM, 65, 50, 3, rays, expected, RAYS);
    for (size_t k = 0; k < RAYS; k++) {
        for (int c = 0; c < 3; c++) user_rays[k].org[c] = rays[k].org[c], user_rays[k].dir[c] = rays[k].dir[c];
        user_rays[k].tmin = rays[k].tmin;
        user_rays[k].tmax = rays[k].tmax;
    }
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    cw_field_destroy(field);
    return 0;
}

static void few_rays_have_the_same_bits(void **state) {
    (void)state;
    size_t number = 0;
    for (cw_isa isa = CW_ISA_ANY; isa < CW_ISA_COUNT; isa++) {
        const cw_run run = {.expert.isa = isa};
        for (size_t k = 0, n = 1; k + n <= RAYS; k += n, n = n % MOST + 1) {
            if (!test_takes(number++, 4)) continue;
            check_status(cw_closest(field, &run, rays + k, n, got), CW_OK);
            for (size_t m = 0; m < n; m++)
                check(hit_same(&got[m], &expected[k + m]), "ray %zu, the %zuth of %zu, isa %d", k + m, m, n, isa);
            check_status(cw_closest_user(field, &run, user_rays + k, n, got), CW_OK);
            for (size_t m = 0; m < n; m++)
                check(hit_same(&got[m], &expected[k + m]), "user ray %zu, the %zuth of %zu, isa %d", k + m, m, n, isa);
            check_status(cw_occluded(field, &run, rays + k, n, occluded), CW_OK);
            for (size_t m = 0; m < n; m++)
                check(occluded[m] == (expected[k + m].i >= 0), "ray %zu, the %zuth of %zu, isa %d", k + m, m, n, isa);
        }
    }
}

static void a_run_keeps_within_its_limit(void **state) {
    (void)state;
    for (cw_isa isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
        const cw_run run = {.expert.isa = isa};
        const cw_isa used = cw_kernel_describe(cw_run_kernel(NULL, &run)).isa;
        check(cw_isa_includes(isa, used) && cw_isa_includes(cw_isa_best(), used), "%s for %s", cw_isa_name(used),
              cw_isa_name(isa));
        for (size_t k = 0; k < cw_kernel_count(); k++) {
            const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
            const cw_run forced = {.expert = {.kernel = cw_kernel_at(k), .isa = isa}};
            check_status(cw_run_check(NULL, &forced),
                         info.available && cw_isa_includes(isa, info.isa) ? CW_OK : CW_ERROR_KERNEL);
        }
    }
    const cw_run odd = {.expert.isa = CW_ISA_COUNT};
    check_status(cw_closest(field, &odd, rays, 1, got), CW_ERROR_ARGUMENT);
}

static bool lower_the_limit(void *context, double done) {
    (void)context, (void)done;
    cw_isa_limit(CW_ISA_SCALAR);
    return true;
}

/* A query goes on with the kernel that it has begun with. */
static void a_limit_does_not_reach_into_a_query(void **state) {
    (void)state;
    for (int user = 0; user < 2; user++) {
        const cw_run run = {.expert.kernel = cw_run_kernel(NULL, NULL), .watch = lower_the_limit};
        check_status(user ? cw_closest_user(field, &run, user_rays, RAYS, got)
                          : cw_closest(field, &run, rays, RAYS, got),
                     CW_OK);
        cw_isa_limit(CW_ISA_ANY);
        for (size_t k = 0; k < RAYS; k++) check(hit_same(&got[k], &expected[k]), "ray %zu", k);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_rays_have_the_same_bits),
        cmocka_unit_test(a_run_keeps_within_its_limit),
        cmocka_unit_test(a_limit_does_not_reach_into_a_query),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
