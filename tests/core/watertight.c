/* SPDX-License-Identifier: Apache-2.0 */
/* The watertight leaf test judged by the exact oracle: no leak, no phantom, no wrong surface, on every adversarial ray class
 * and field shape; and no touch lost where nothing is rounded. All kernels with this leaf test give the same bits (lanes.c), so one is judged for all. */

#include "cellwalk_expert.h"
#include "check.h"
#include "tally.h"

#include <math.h>
#include <stdio.h>

enum { RAYS = 500, FIELDS = FIELD_SIZES * FIELD_ALL_SHAPES };

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
    const cw_run query = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = CW_LEAF_WATERTIGHT};
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
        if (!test_takes(k + k / FIELD_SIZES, 4)) continue;
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

/* A direction of zeros and powers of 2, with a difference of x and y that is one, too. So nothing is rounded. */
static void even_direction(random_state *r, float d[3]) {
    static const float powers[] = {0, 0.5f, 1, 2, 4, -0.5f, -1, -2, -4};
    float apart;
    do {
        for (int c = 0; c < 3; c++) d[c] = powers[random_below(r, 9)];
        apart = fabsf(d[0] - d[1]);
    } while ((d[0] == 0 && d[1] == 0) || (apart != 0 && exp2f(rintf(log2f(apart))) != apart));
}

/* A ray through a quarter of an edge or a vertex within the field, where the surface is at p. */
static cw_ray even_ray(const test_field *f, random_state *r) {
    const size_t i = 1 + random_below(r, f->nx - 2), j = 1 + random_below(r, f->ny - 2);
    const float along = 0.25f * (float)random_below(r, 4), back = 0.25f * (float)random_below(r, 40);
    const size_t way = random_below(r, 3); /* along x, y or the diagonal */
    const float x = way == 1 ? 0 : along, y = way == 0 ? 0 : along;
    const size_t next = j * f->nx + i + (way == 0 ? 1 : way == 1 ? f->nx : f->nx + 1);
    const float low = f->z[j * f->nx + i], z = low + along * (f->z[next] - low);
    cw_ray ray = {.tmin = random_below(r, 2) ? 0 : -INFINITY, .tmax = INFINITY};
    const bool inside = i + 1 < f->nx - 1 && j + 1 < f->ny - 1;
    const float p[3] = {(float)i + (inside ? x : 0), (float)j + (inside ? y : 0), inside ? z : low};
    even_direction(r, ray.dir);
    for (int c = 0; c < 3; c++) ray.org[c] = p[c] - back * ray.dir[c];
    return ray;
}

/* Whether the ray is traced from its own origin: see "Where a ray starts" in papers/numerics.md. */
static bool is_near(const cw_field *field, const cw_ray *ray) {
    const cw_field_info info = cw_field_describe(field);
    const double middle = ((double)info.low + (double)info.high) / 2, range = (double)info.high - (double)info.low;
    const double x = (double)(info.nx - 1), y = (double)(info.ny - 1);
    return fabs((double)ray->org[0] - x / 2) <= x && fabs((double)ray->org[1] - y / 2) <= y &&
           (range == 0 || fabs((double)ray->org[2] - middle) <= 8 * range);
}

/* Where no operation rounds, a ray from nearby that touches the surface within the field hits. */
static void test_touches(void **state) {
    (void)state;
    static const field_size sizes[] = {{3, 34}, {9, 9}, {40, 5}, {3, 3}};
    static test_field f;
    random_state r = {20261123};
    size_t touches = 0, lost = 0;
    for (size_t k = 0, n = test_share(400, 40); k < n; k++) {
        field_make(&f, k & 4 ? FIELD_CHECKER : FIELD_INTEGERS, sizes[k % 4].nx, sizes[k % 4].ny, k);
        cw_field *field = field_open(&f);
        oracle *o = oracle_create(f.z, f.nx, f.ny);
        assert_non_null(o);
        for (size_t m = 0; m < RAYS; m++) {
            const cw_ray ray = even_ray(&f, &r);
            const oracle_truth *truth = oracle_trace(o, &ray);
            const double x = (double)ray.org[0] + truth->t * (double)ray.dir[0],
                         y = (double)ray.org[1] + truth->t * (double)ray.dir[1];
            if (!is_near(field, &ray) || !truth->hit || truth->strict_pass || x <= 0 || y <= 0 ||
                x >= (double)(f.nx - 1) || y >= (double)(f.ny - 1))
                continue;
            cw_hit hit;
            const cw_run query = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = CW_LEAF_WATERTIGHT};
            check_status(cw_closest(field, &query, &ray, 1, &hit), CW_OK);
            touches++;
            if (hit.i >= 0 && fabs((double)hit.t - truth->t) == 0) continue;
            if (lost++ > 1) continue;
            const judgement j = oracle_judge(o, &hit);
            tally_explain(&f, &ray, &hit, truth, &j);
        }
        oracle_destroy(o);
        cw_field_destroy(field);
    }
    printf("%zu touches within the field, %zu lost\n", touches, lost);
    check(lost == 0, "%zu touches are lost", lost);
    check(touches > 1000, "too few touches for the test to mean anything");
}

int main(void) {
    static ray_class kinds[RAY_CLASSES];
    static struct CMUnitTest tests[RAY_CLASSES + 1];
    for (int k = 0; k < RAY_CLASSES; k++) {
        kinds[k] = (ray_class)k;
        tests[k] =
            (struct CMUnitTest){.name = ray_class_name(kinds[k]), .test_func = test_class, .initial_state = &kinds[k]};
    }
    tests[RAY_CLASSES] = (struct CMUnitTest)cmocka_unit_test(test_touches);
    return cmocka_run_group_tests_name("watertight", tests, NULL, NULL);
}
