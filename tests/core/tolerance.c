/* SPDX-License-Identifier: Apache-2.0 */
/* Tolerant queries judged by the exact oracle: every hit of every kernel that makes use of a tolerance lies on a solid
 * triangle, and the ray at its t no farther from that, in height, than what is allowed and what rounding excuses
 * (papers/numerics.md); no ray that passes the surface gets through. Alone, rays get the same bits at all widths. */

#include "check.h"
#include "oracle.h"
#include "rays.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* CELLWALK_TEST_ROUNDS=3 makes more than 10^5 rays of each class of it. */
enum { SIZES = FIELD_SIZES + 1, FIELDS = SIZES * FIELD_SHAPES, RAYS = 448 };
static const field_size large = {261, 131}; /* several levels of the pyramid, and nodes that stick out of the field */

static bool is_tolerant(const cw_kernel *kernel) {
    const cw_kernel_info info = cw_kernel_describe(kernel);
    return info.available && strncmp(info.name, "pyramid", 7) == 0;
}

enum { KERNELS_MAX = 16 };
static const cw_kernel *tolerant[KERNELS_MAX];
static size_t tolerant_count;

/* A field and its oracle, which take longer to make than a class of rays takes on most of them: kept from class to class. */
typedef struct judged_field {
    size_t number;
    test_field shape;
    cw_field *field;
    oracle *o;
} judged_field;
static judged_field *judged_fields[FIELDS];

static void judged_field_free(judged_field *g) {
    if (g == NULL) return;
    oracle_destroy(g->o);
    cw_field_destroy(g->field);
    free(g);
}

static const judged_field *judged_field_get(size_t number) {
    judged_field **g = &judged_fields[number % FIELDS];
    if (*g && (*g)->number == number) return *g;
    judged_field_free(*g);
    const size_t which = number % FIELDS / FIELD_SHAPES;
    const field_size size = which < FIELD_SIZES ? field_sizes[which] : large;
    *g = calloc(1, sizeof **g);
    assert_non_null(*g);
    (*g)->number = number;
    field_make(&(*g)->shape, (field_shape)(number % FIELD_SHAPES), size.nx, size.ny, number);
    (*g)->field = field_open(&(*g)->shape);
    (*g)->o = oracle_create((*g)->shape.z, size.nx, size.ny);
    assert_non_null((*g)->o);
    return *g;
}

static int free_fields(void **state) {
    (void)state;
    for (size_t k = 0; k < FIELDS; k++) judged_field_free(judged_fields[k]);
    return 0;
}

static int find_kernels(void **state) {
    (void)state;
    for (size_t k = 0; k < cw_kernel_count(); k++)
        if (is_tolerant(cw_kernel_at(k))) {
            if (tolerant_count == KERNELS_MAX) return -1;
            tolerant[tolerant_count++] = cw_kernel_at(k);
        }
    return tolerant_count > 0 ? 0 : -1;
}

/* What was seen of a kernel, so that a test of nothing is noticed. */
typedef struct seen {
    size_t rays, hits, by_tolerance, passes; /* by_tolerance: hits that would be phantoms without it */
} seen;

typedef struct run {
    const test_field *shape;
    cw_field *field;
    oracle *o;
    float tolerance, cone;
    size_t n;
    cw_ray rays[RAYS];
    cw_hit strict[RAYS], hits[KERNELS_MAX][RAYS];
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

/* What is wrong with an answer to the ray last traced; NULL if nothing is. by_tolerance: whether it was needed. */
static const char *fault(const run *q, size_t k, const oracle_truth *truth, const cw_hit *hit, bool *by_tolerance) {
    *by_tolerance = false;
    const cw_ray *ray = &q->rays[k];
    if (hit->i < 0) return truth->passes ? "a leak" : NULL;
    const double t = (double)hit->t, h = sample(q, hit->i, hit->j), far = sample(q, hit->i + 1, hit->j + 1);
    const double corner =
        hit->triangle == CW_TRIANGLE_A ? sample(q, hit->i + 1, hit->j) : sample(q, hit->i, hit->j + 1);
    if (!isfinite(h + far + corner)) return "a hit in a hole";
    if (!(hit->t >= ray->tmin && hit->t <= ray->tmax)) return "t out of range";
    if (!(hit->u >= 0 && hit->v >= 0 && hit->u + hit->v <= 1)) return "u or v out of range";
    const hit_check c = oracle_check(q->o, hit);
    if (!c.holds) {
        double astray;
        const double off = fabs(height_above(q, ray, hit, &astray)), error = c.error;
        const double rounding = 1 + 0x1p-20; /* of what is computed here */
        if (!(c.apart <= rounding * c.apart_most)) return "a hit beside its triangle";
        if (!(astray <= 2 * rounding * c.apart_most)) return "u and v elsewhere";
        if (!(off <= rounding * (allowed(q, ray, t) + error))) return "a hit farther off than allowed";
        *by_tolerance = true;
    }
    if (q->strict[k].i >= 0 && hit->t > q->strict[k].t && oracle_judge(q->o, hit).verdict > VERDICT_TIE)
        return "a hit behind the surface";
    return NULL;
}

/* Every kernel gets the same rays and counts for itself. Equal answers are judged once. */
static void judge(run *q, seen *s) {
    static uint8_t occluded[KERNELS_MAX][RAYS];
    for (size_t m = 0; m < tolerant_count; m++) {
        const cw_query query = {.kernel = tolerant[m], .tolerance = q->tolerance, .cone = q->cone};
        check_status(cw_closest(q->field, &query, q->rays, q->n, q->hits[m]), CW_OK);
        check_status(cw_any(q->field, &query, q->rays, q->n, occluded[m]), CW_OK);
    }
    for (size_t k = 0; k < q->n; k++) {
        const oracle_truth *truth = oracle_trace(q->o, &q->rays[k]);
        const char *why[KERNELS_MAX];
        bool by_tolerance[KERNELS_MAX];
        for (size_t m = 0; m < tolerant_count; m++) {
            const cw_hit *hit = &q->hits[m][k];
            size_t same = 0;
            while (same < m && !hit_same(&q->hits[same][k], hit)) same++;
            if (same < m) {
                why[m] = why[same];
                by_tolerance[m] = by_tolerance[same];
            } else {
                why[m] = fault(q, k, truth, hit, &by_tolerance[m]);
            }
            if (why[m] == NULL && occluded[m][k] != (hit->i >= 0)) why[m] = "any hit says otherwise";
            s[m].rays++;
            s[m].passes += truth->passes;
            s[m].hits += hit->i >= 0;
            s[m].by_tolerance += by_tolerance[m];
            if (why[m] == NULL) continue;
            const char *name = cw_kernel_describe(tolerant[m]).name;
            field_print(q->shape);
            ray_print(&q->rays[k]);
            hit_print(name, hit);
            hit_print("strict", &q->strict[k]);
            check(false, "%s, ray %zu of %zu, tolerance %a, cone %a: %s", name, k, q->n, (double)q->tolerance,
                  (double)q->cone, why[m]);
        }
    }
}

/* A ray alone shares no walk. One in 16 is enough. */
static void compare_alone(const run *q) {
    const cw_kernel *reference = cw_kernel_find("pyramid1");
    for (size_t k = 0; k < q->n / 16; k++) {
        cw_query query = {.kernel = reference, .tolerance = q->tolerance, .cone = q->cone};
        cw_hit first;
        check_status(cw_closest(q->field, &query, &q->rays[k], 1, &first), CW_OK);
        for (size_t m = 0; m < tolerant_count; m++) {
            query.kernel = tolerant[m];
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

/* Classes of rays. The first steps, from cell to cell, and the walk that rays share come before the lane walk, which alone
 * makes use of a tolerance, and the wider the kernel the more of the rays they serve. So rays that start close to what they
 * are aimed at come once more from farther away. */
typedef struct rays_asked {
    const char *name;
    ray_class kind;
    bool set_back;
    unsigned
        least; /* one in so many has to be a hit off the surface, or nothing has been tested; 0: none is expected */
} rays_asked;

static const rays_asked asked[] = {
    {"random", RAY_RANDOM, .least = 100},
    {"vertex", RAY_VERTEX, .least = 100},
    {"edge", RAY_EDGE, .least = 100},
    {"diagonal", RAY_DIAGONAL, .least = 100},
    {"along", RAY_ALONG, .least = 100},
    {"axis", RAY_AXIS, .least = 100},
    {"vertical", RAY_VERTICAL, .least = 0}, /* they meet their cell within the first steps */
    {"grazing", RAY_GRAZING, .least = 200},
    {"grazing-set-back", RAY_GRAZING, .set_back = true, .least = 100},
    {"in-plane", RAY_IN_PLANE, .least = 1000},
    {"in-plane-set-back", RAY_IN_PLANE, .set_back = true, .least = 100},
    {"outside", RAY_OUTSIDE, .least = 100},
    {"far", RAY_FAR, .least = 200},
    {"afar", RAY_AFAR, .least = 0},
    {"near", RAY_NEAR, .least = 0},
    {"tiny", RAY_TINY, .least = 200},
    {"zeros", RAY_ZEROS, .least = 100},
    {"scaled", RAY_SCALED, .least = 100},
    {"range", RAY_RANGE, .least = 100},
    {"lattice", RAY_LATTICE, .least = 200},
    {"not-finite", RAY_NOT_FINITE, .least = 200},
};
enum { ASKED = sizeof asked / sizeof asked[0] };

/* Backwards by 3 to 100 cells. */
static void set_back(cw_ray *ray, random_state *r) {
    const double x = (double)ray->dir[0], y = (double)ray->dir[1], length = sqrt(x * x + y * y);
    const double back = pow(10, random_between(r, 0.5, 2)) / length;
    for (int c = 0; c < 3 && length > 0; c++) ray->org[c] = (float)((double)ray->org[c] - back * (double)ray->dir[c]);
}

static void test_class(void **state) {
    const rays_asked *a = *state;
    const ray_class kind = a->kind;
    static run q;
    seen s[KERNELS_MAX] = {{0}};
    for (size_t k = 0, n = test_rounds() * FIELDS; k < n; k++) {
        const judged_field *g = judged_field_get(k);
        const test_field *shape = &g->shape;
        random_state r = {(uint64_t)kind + RAY_CLASSES * k + 4711};
        q = (run){.shape = shape, .field = g->field, .o = g->o, .n = test_share(RAYS, 10)};
        /* From much less than the field's heights to more than all of them, so that nodes of every level are taken. */
        const double range = (double)shape->high - (double)shape->low;
        const double part = range * pow(10, random_between(&r, -3, 0.5));
        const bool cone = random_below(&r, 2);
        q.tolerance = (float)(cone ? 0 : part);
        q.cone = (float)(cone ? part / (double)(shape->nx + shape->ny) : 0);
        for (size_t m = 0; m < q.n; m++) {
            q.rays[m] = ray_make(kind, shape, &r);
            if (a->set_back) set_back(&q.rays[m], &r);
        }
        const cw_query strict = {.kernel = cw_kernel_find("cell")};
        check_status(cw_closest(q.field, &strict, q.rays, q.n, q.strict), CW_OK);
        judge(&q, s);
        compare_alone(&q);
    }
    for (size_t m = 0; m < tolerant_count; m++) {
        const char *name = cw_kernel_describe(tolerant[m]).name;
        printf("%-17s %-10s %zu rays, %zu pass, %zu hits, %zu of them off the surface\n", a->name, name, s[m].rays,
               s[m].passes, s[m].hits, s[m].by_tolerance);
        /* Of the few rays that slow machines get, there may be none. */
        check(a->least == 0 || s[m].rays < 10 * a->least || s[m].by_tolerance > s[m].rays / a->least,
              "%s: too few hits off the surface for the test to mean anything", name);
    }
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
    for (size_t m = 0; m < tolerant_count; m++) {
        const cw_query query = {.kernel = tolerant[m], .tolerance = 1e30f};
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
    size_t queries = 0, found = 0;
    for (size_t k = 0; k < 1000; k++) rays[k] = ray_make(RAY_RANDOM, &shape, &r);
    for (size_t m = 0; m < cw_kernel_count(); m++)
        for (int leaf = 1; leaf < CW_LEAF_COUNT; leaf++) {
            cw_query query = {.kernel = cw_kernel_at(m), .leaf = (cw_leaf)leaf};
            if (is_tolerant(query.kernel) && leaf == CW_LEAF_WATERTIGHT) continue;
            if (cw_closest(field, &query, rays, 1000, strict) != CW_OK) continue;
            queries++;
            query.tolerance = 10;
            query.cone = 1;
            check_status(cw_closest(field, &query, rays, 1000, hits), CW_OK);
            for (size_t k = 0; k < 1000; k++) {
                check(hit_same(&hits[k], &strict[k]), "%s", cw_kernel_describe(query.kernel).name);
                found += hits[k].i >= 0;
            }
        }
    /* At least brute, both grid3d, pyramid1 with one leaf test, packet1 and cell with two. */
    check(queries >= 8 && found > 500 * queries, "%zu kernels and leaf tests with %zu hits", queries, found);
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
        check_status(cw_closest(field, &height, NULL, 0, NULL), CW_ERROR_OPTION);
        check_status(cw_any(field, &cone, NULL, 0, NULL), CW_ERROR_OPTION);
    }
    const cw_query good = {.tolerance = 1, .cone = -0.0f};
    check_status(cw_closest(field, &good, NULL, 0, NULL), CW_OK);
    cw_field_destroy(field);
}

int main(void) {
    static struct CMUnitTest tests[ASKED + 3];
    for (int k = 0; k < ASKED; k++)
        tests[k] = (struct CMUnitTest){
            .name = asked[k].name, .test_func = test_class, .initial_state = (void *)(uintptr_t)&asked[k]};
    tests[ASKED] = (struct CMUnitTest)cmocka_unit_test(test_holes);
    tests[ASKED + 1] = (struct CMUnitTest)cmocka_unit_test(test_ignored);
    tests[ASKED + 2] = (struct CMUnitTest)cmocka_unit_test(test_arguments);
    return cmocka_run_group_tests_name("tolerance", tests, find_kernels, free_fields);
}
