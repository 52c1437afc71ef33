/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test judged by the exact oracle: no leak, no phantom, no wrong surface, on every adversarial ray class
 * and field shape. All kernels with this leaf test give the same bits (lanes.c), so one is judged for all. */

#include "check.h"
#include "tally.h"

#include <stdio.h>

enum { RAYS = 500, FIELDS = FIELD_SIZES * FIELD_SHAPES };

/* RAYS rays of a class on one field; the number judged wrong, of which the first few are explained. */
static size_t judge_field(ray_class kind, const test_field *shape, random_state *r, tally *t, bool explain) {
    static cw_ray rays[RAYS];
    static cw_hit hits[RAYS];
    const size_t n = test_share(RAYS, 10);
    size_t wrong = 0;
    cw_field *field = field_open(shape);
    oracle *o = oracle_create(shape->z, shape->nx, shape->ny);
    assert_non_null(o);
    for (size_t k = 0; k < n; k++) rays[k] = ray_make(kind, shape, r);
    const cw_run query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    check_status(cw_closest(field, &query, rays, n, hits), CW_OK);
    for (size_t k = 0; k < n; k++) {
        const oracle_truth *truth = oracle_trace(o, &rays[k]);
        const judgement j = oracle_judge(o, &hits[k]);
        tally_add(t, &hits[k], truth, &j);
        if (j.verdict <= VERDICT_TIE && digits_hold(&j)) continue;
        if (wrong++ < 2 && explain) tally_explain(shape, &rays[k], &hits[k], truth, &j);
    }
    oracle_destroy(o);
    cw_field_destroy(field);
    return wrong;
}

static void test_class(void **state) {
    const ray_class kind = *(const ray_class *)*state;
    static test_field shape;
    tally t = {.residual = 0};
    size_t wrong = 0;
    for (size_t k = 0, n = test_rounds() * FIELDS; k < n; k++) {
        const field_size size = field_sizes[k % FIELD_SIZES];
        const size_t round = k / FIELDS;
        random_state r = {(uint64_t)kind + RAY_CLASSES * k};
        field_make(&shape, (field_shape)(k % FIELDS / FIELD_SIZES), size.nx, size.ny, 77 + round);
        wrong += judge_field(kind, &shape, &r, &t, wrong < 4);
    }
    tally_print(ray_class_name(kind), &t);
    check(wrong == 0, "%zu rays of class %s judged wrong", wrong, ray_class_name(kind));
    const bool aims = kind != RAY_IN_PLANE && kind != RAY_NOT_FINITE && kind != RAY_LATTICE && kind != RAY_AFAR;
    check(!aims || t.passes > t.rays / 10, "too few rays pass for the test to mean anything");
}

int main(void) {
    static ray_class kinds[RAY_CLASSES];
    static struct CMUnitTest tests[RAY_CLASSES];
    for (int k = 0; k < RAY_CLASSES; k++) {
        kinds[k] = (ray_class)k;
        tests[k] =
            (struct CMUnitTest){.name = ray_class_name(kinds[k]), .test_func = test_class, .initial_state = &kinds[k]};
    }
    return cmocka_run_group_tests_name("watertight", tests, NULL, NULL);
}
