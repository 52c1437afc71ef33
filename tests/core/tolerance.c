/* SPDX-License-Identifier: Apache-2.0 */
/* Tolerant queries before the exact oracle: every hit of every kernel that makes use of a tolerance lies on a solid
 * triangle, and the ray at its t no farther from that, in height, than what is allowed and what rounding excuses
 * (papers/numerics.md); no ray that passes the surface gets through. Alone, rays get the same bits at all widths. */

#include "check.h"
#include "oracle.h"
#include "rays.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#ifndef TEST_SCALE_DOWN
#define TEST_SCALE_DOWN 1
#endif
/* CELLWALK_TEST_ROUNDS=3 makes more than 10^5 rays of each class of it. */
enum { SIZES = FIELD_SIZES + 1, FIELDS = SIZES * FIELD_SHAPES, RAYS = 448 / TEST_SCALE_DOWN };
static const field_size large = {261, 131}; /* several levels of the pyramid, and nodes that stick out of the field */

static bool is_tolerant(const cw_kernel *kernel) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    return info.available && strncmp(info.name, "pyramid", 7) == 0;
}

/* What was seen, so that a test of nothing is noticed. */
typedef struct seen {
    size_t rays, hits, near, passes; /* near: hits that would be phantoms without the tolerance */
} seen;

typedef struct run {
    const test_field *shape;
    cw_field *field;
    oracle *o;
    float tolerance, cone;
    size_t n;
    cw_ray rays[RAYS];
    cw_hit strict[RAYS];
} run;

static double allowed(const run *q, const cw_ray *ray, double t) {
    double square = 0;
    for (int c = 0; c < 3; c++) square += (double)ray->dir[c] * (double)ray->dir[c];
    return (double)q->tolerance + (double)q->cone * fmax(0, t) * sqrt(square);
}

static double sample(const run *q, int32_t i, int32_t j) {
    return (double)q->shape->z[(size_t)j * q->shape->nx + (size_t)i];
}

/* A component as the library counts it. */
static double direction(float d) { return fabsf(d) <= 0x1p-128f ? 0 : (double)d; }

/* The ray's height above the plane of the hit's triangle, and how far u and v are from its place, along x or y. */
static double height_above(const run *q, const cw_ray *ray, const cw_hit *hit, double *astray) {
    const double t = (double)hit->t, u = (double)hit->u, v = (double)hit->v;
    const double x = (double)ray->org[0] - hit->i + t * direction(ray->dir[0]);
    const double y = (double)ray->org[1] - hit->j + t * direction(ray->dir[1]);
    const double h = sample(q, hit->i, hit->j), far = sample(q, hit->i + 1, hit->j + 1);
    const bool a = hit->triangle == CW_TRIANGLE_A;
    const double corner = a ? sample(q, hit->i + 1, hit->j) : sample(q, hit->i, hit->j + 1);
    *astray = fmax(fabs(x - (a ? u + v : u)), fabs(y - (a ? v : u + v)));
    const double surface = a ? h + x * (corner - h) + y * (far - corner) : h + y * (corner - h) + x * (far - corner);
    return (double)ray->org[2] + t * direction(ray->dir[2]) - surface;
}

/* What is wrong with an answer to the ray last traced; NULL if nothing is. */
static const char *fault(const run *q, size_t k, const oracle_truth *truth, const cw_hit *hit, seen *s) {
    const cw_ray *ray = &q->rays[k];
    if (hit->i < 0) return truth->passes ? "a leak" : NULL;
    const double t = (double)hit->t, h = sample(q, hit->i, hit->j), far = sample(q, hit->i + 1, hit->j + 1);
    const double corner =
        hit->triangle == CW_TRIANGLE_A ? sample(q, hit->i + 1, hit->j) : sample(q, hit->i, hit->j + 1);
    if (!isfinite(h + far + corner)) return "a hit in a hole";
    if (!(hit->t >= ray->tmin && hit->t <= ray->tmax)) return "t out of range";
    if (!(hit->u >= 0 && hit->v >= 0 && hit->u + hit->v <= 1)) return "u or v out of range";
    const hit_check c = oracle_check(q->o, hit);
    s->hits++;
    if (!c.holds) {
        double astray;
        const double off = fabs(height_above(q, ray, hit, &astray)), error = c.residual > 0 ? off / c.residual : 0;
        const double doubt = 1 + 0x1p-20;
        if (!(c.apart <= doubt * c.apart_most)) return "a hit beside its triangle";
        if (!(astray <= 2 * doubt * c.apart_most)) return "u and v elsewhere";
        if (!(off <= doubt * (allowed(q, ray, t) + error))) return "a hit farther off than allowed";
        s->near++;
    }
    if (q->strict[k].i >= 0 && hit->t > q->strict[k].t && oracle_judge(q->o, hit).verdict > VERDICT_TIE)
        return "a hit behind the surface";
    return NULL;
}

static void judge(const run *q, const cw_kernel *kernel, seen *s) {
    static cw_hit hits[RAYS];
    static uint8_t occluded[RAYS];
    const char *name = cw_kernel_describe(kernel).name;
    const cw_query query = {.kernel = kernel, .tolerance = q->tolerance, .cone = q->cone};
    check_status(cw_closest(q->field, &query, q->rays, q->n, hits), CW_OK);
    check_status(cw_any(q->field, &query, q->rays, q->n, occluded), CW_OK);
    for (size_t k = 0; k < q->n; k++) {
        const oracle_truth *truth = oracle_trace(q->o, &q->rays[k]);
        const char *why = fault(q, k, truth, &hits[k], s);
        if (why == NULL && occluded[k] != (hits[k].i >= 0)) why = "any hit says otherwise";
        s->rays++;
        s->passes += truth->passes;
        if (why == NULL) continue;
        field_print(q->shape);
        ray_print(&q->rays[k]);
        hit_print(name, &hits[k]);
        hit_print("strict", &q->strict[k]);
        check(false, "%s, ray %zu of %zu, tolerance %a, cone %a: %s", name, k, q->n, (double)q->tolerance,
              (double)q->cone, why);
    }
}

/* A ray alone shares no walk. One in 16 is enough. */
static void compare_alone(const run *q) {
    const cw_kernel *reference = cw_kernel_find("pyramid1");
    for (size_t k = 0; k < q->n / 16; k++) {
        cw_query query = {.kernel = reference, .tolerance = q->tolerance, .cone = q->cone};
        cw_hit first;
        check_status(cw_closest(q->field, &query, &q->rays[k], 1, &first), CW_OK);
        for (size_t m = 0; m < cw_kernel_count(); m++) {
            query.kernel = cw_kernel_at(m);
            if (!is_tolerant(query.kernel)) continue;
            cw_hit hit;
            uint8_t occluded;
            check_status(cw_closest(q->field, &query, &q->rays[k], 1, &hit), CW_OK);
            check_status(cw_any(q->field, &query, &q->rays[k], 1, &occluded), CW_OK);
            if (hit_same(&hit, &first) && occluded == (first.i >= 0)) continue;
            field_print(q->shape);
            ray_print(&q->rays[k]);
            hit_print("pyramid1", &first);
            hit_print(cw_kernel_describe(query.kernel).name, &hit);
            check(false, "alone, %s differs", cw_kernel_describe(query.kernel).name);
        }
    }
}

static void test_class(void **state) {
    const ray_class kind = *(const ray_class *)*state;
    static test_field shape;
    static run q;
    seen s = {0};
    for (size_t k = 0, n = test_rounds() * FIELDS; k < n; k++) {
        const size_t which = k % FIELDS / FIELD_SHAPES;
        const field_size size = which < FIELD_SIZES ? field_sizes[which] : large;
        random_state r = {(uint64_t)kind + RAY_CLASSES * k + 4711};
        field_make(&shape, (field_shape)(k % FIELD_SHAPES), size.nx, size.ny, k);
        q = (run){.shape = &shape, .field = field_open(&shape), .n = test_share(RAYS)};
        q.o = oracle_create(shape.z, shape.nx, shape.ny);
        assert_non_null(q.o);
        /* From much less than the field's heights to more than all of them, so that nodes of every level are taken. */
        const double range = (double)shape.high - (double)shape.low;
        const double part = range * pow(10, random_between(&r, -3, 0.5));
        const bool cone = random_below(&r, 2);
        q.tolerance = (float)(cone ? 0 : part);
        q.cone = (float)(cone ? part / (double)(size.nx + size.ny) : 0);
        for (size_t m = 0; m < q.n; m++) q.rays[m] = ray_make(kind, &shape, &r);
        const cw_query strict = {.kernel = cw_kernel_find("cell")};
        check_status(cw_closest(q.field, &strict, q.rays, q.n, q.strict), CW_OK);
        /* One kernel a field, in turn: what a tolerance allows is the same for all. */
        size_t turn = k;
        for (size_t m = 0;; m = (m + 1) % cw_kernel_count())
            if (is_tolerant(cw_kernel_at(m)) && turn-- == 0) {
                judge(&q, cw_kernel_at(m), &s);
                break;
            }
        compare_alone(&q);
        oracle_destroy(q.o);
        cw_field_destroy(q.field);
    }
    printf("%-10s %zu rays, %zu pass, %zu hits, %zu of them off the surface\n", ray_class_name(kind), s.rays, s.passes,
           s.hits, s.near);
    /* Vertical rays meet their cell within the steps from cell to cell that come before the lane walk. */
    const bool aims = kind != RAY_VERTICAL && kind != RAY_IN_PLANE && kind != RAY_NOT_FINITE && kind != RAY_LATTICE &&
                      kind != RAY_FAR;
    check(!aims || s.near > s.rays / 100, "too few hits off the surface for the test to mean anything");
}

/* However much is allowed, what is not there is not hit: holes stay open, and so does the outside of the field. */
static void test_holes(void **state) {
    (void)state;
    static float z[65 * 65];
    for (size_t k = 0; k < 65 * 65; k++) z[k] = (float)(k % 65);
    z[32 * 65 + 32] = NAN;
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = 65;
    cw_field *field = NULL;
    check_status(cw_field_create(&desc, &field), CW_OK);
    const cw_ray rays[] = {{{32, 32, 100}, 0, {0, 0, -1}, INFINITY},
                           {{-0.5f, 32, 100}, 0, {0, 0, -1}, INFINITY},
                           {{20, 65, 100}, 0, {0, 0, -1}, INFINITY},
                           {{10.5f, 10.25f, 100}, 0, {0, 0, -1}, INFINITY}};
    for (size_t m = 0; m < cw_kernel_count(); m++) {
        if (!is_tolerant(cw_kernel_at(m))) continue;
        const cw_query query = {.kernel = cw_kernel_at(m), .tolerance = 1e30f};
        cw_hit hits[4];
        uint8_t occluded[4];
        check_status(cw_closest(field, &query, rays, 4, hits), CW_OK);
        check_status(cw_any(field, &query, rays, 4, occluded), CW_OK);
        for (int k = 0; k < 4; k++) {
            check((hits[k].i >= 0) == (k == 3), "%s, ray %d", cw_kernel_describe(query.kernel).name, k);
            check(occluded[k] == (k == 3), "%s, any, ray %d", cw_kernel_describe(query.kernel).name, k);
        }
    }
    cw_field_destroy(field);
}

/* Kernels and the leaf test that have no use for a tolerance. */
static void test_ignored(void **state) {
    (void)state;
    static test_field shape;
    static cw_ray rays[1000];
    static cw_hit hits[1000], strict[1000];
    random_state r = {5};
    field_make(&shape, FIELD_RANDOM, 40, 40, 1);
    cw_field *field = field_open(&shape);
    for (size_t k = 0; k < 1000; k++) rays[k] = ray_make(RAY_RANDOM, &shape, &r);
    for (size_t m = 0; m < cw_kernel_count(); m++)
        for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++) {
            cw_query query = {.kernel = cw_kernel_at(m), .leaf = (cw_leaf)leaf};
            if (is_tolerant(query.kernel) && leaf == CW_LEAF_WATERTIGHT) continue;
            if (cw_closest(field, &query, rays, 1000, strict) != CW_OK) continue;
            query.tolerance = 10;
            query.cone = 1;
            check_status(cw_closest(field, &query, rays, 1000, hits), CW_OK);
            for (size_t k = 0; k < 1000; k++)
                check(hit_same(&hits[k], &strict[k]), "%s", cw_kernel_describe(query.kernel).name);
        }
    cw_field_destroy(field);
}

static void test_arguments(void **state) {
    (void)state;
    static const float z[4], bad[] = {-1, NAN, INFINITY, -INFINITY};
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = 2;
    cw_field *field = NULL;
    check_status(cw_field_create(&desc, &field), CW_OK);
    for (size_t k = 0; k < 4; k++) {
        const cw_query height = {.tolerance = bad[k]}, cone = {.cone = bad[k]};
        check_status(cw_closest(field, &height, NULL, 0, NULL), CW_ERROR_ARGUMENT);
        check_status(cw_any(field, &cone, NULL, 0, NULL), CW_ERROR_ARGUMENT);
    }
    const cw_query good = {.tolerance = 1, .cone = -0.0f};
    check_status(cw_closest(field, &good, NULL, 0, NULL), CW_OK);
    cw_field_destroy(field);
}

int main(void) {
    static ray_class kinds[RAY_CLASSES];
    static struct CMUnitTest tests[RAY_CLASSES + 3];
    for (int k = 0; k < RAY_CLASSES; k++) {
        kinds[k] = (ray_class)k;
        tests[k] =
            (struct CMUnitTest){.name = ray_class_name(kinds[k]), .test_func = test_class, .initial_state = &kinds[k]};
    }
    tests[RAY_CLASSES] = (struct CMUnitTest)cmocka_unit_test(test_holes);
    tests[RAY_CLASSES + 1] = (struct CMUnitTest)cmocka_unit_test(test_ignored);
    tests[RAY_CLASSES + 2] = (struct CMUnitTest)cmocka_unit_test(test_arguments);
    return cmocka_run_group_tests_name("tolerance", tests, NULL, NULL);
}
