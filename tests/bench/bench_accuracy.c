/* SPDX-License-Identifier: Apache-2.0 */
/* How the trade of speed against error is measured: exact places, verdicts, counts and normals, on cases whose answers are
 * known. */
#include "accuracy/accuracy.h"

#include "scenes/table.h"

#include "check.h"
#include "workload/terrain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- fields ---- */

enum { SIDE = 9, SAMPLES = SIDE * SIDE };

/* Ground at height 1, and if requested a wall of height 3 along y at x = 4. */
static void make_ground(float *z, bool wall) {
    for (size_t k = 0; k < SAMPLES; k++) z[k] = wall && k % SIDE == 4 ? 3 : 1;
}

static cw_field *make_field(const float *z) {
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = z;
    desc.nx = desc.ny = SIDE;
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    check_status(cw_field_build(field, &(cw_run){.kernel = cw_kernel_find("cell")}), CW_OK);
    return field;
}

/* ---- exact places ---- */

static void sums_are_exact(void **state) {
    (void)state;
    const double cancels[] = {1e100, 1, 0x1p-60, -1e100, -1, 3, -3};
    check(exact_sum(cancels, 7) == 0x1p-60, "the sum is %g", exact_sum(cancels, 7));
    const double tenth[] = {0.1, 0.2, -0.3};
    check(exact_sum(tenth, 3) == 0x1p-55, "0.1 + 0.2 - 0.3 is %a", exact_sum(tenth, 3));
}

static void places_are_exact(void **state) {
    (void)state;
    float z[SAMPLES];
    make_ground(z, true);
    const true_surface on = true_surface_of(z, SIDE, SIDE);
    /* Triangle A of cell (4, 2) is z = 3 - 2 (x - 4). */
    const cw_ray ray = {.org = {5, 2.25f, 2}, .dir = {-1, 0, 1}, .tmax = 9};
    exact_hit p;
    check(exact_meet(&on, &ray, 4, 2, CW_TRIANGLE_A, &p), "the ray is parallel");
    check(p.t == 1, "t is %.17g", p.t); /* 2 + t = 3 - 2 (1 - t) */
    const cw_ray falling = {.org = {4.75f, 2.125f, 4}, .dir = {0, 0, -3}, .tmax = 9};
    check(exact_meet(&on, &falling, 4, 2, CW_TRIANGLE_A, &p), "the ray is parallel");
    check(fabs(p.t - 2.5 / 3) < 1e-15 && p.u == 0.625 && p.v == 0.125, "t, u, v are %.17g, %g, %g", p.t, p.u, p.v);
    const cw_ray along = {.org = {4.75f, 2.125f, 4}, .dir = {1, 0, -2}, .tmax = 9};
    check(!exact_meet(&on, &along, 4, 2, CW_TRIANGLE_A, &p), "the ray is not parallel");

    /* A hit that names the wrong triangle beside the edge is led to the right one; u and v in it. */
    const cw_ray beside = {.org = {4.5f, 2.5625f, 4}, .dir = {0, 0, -1}, .tmax = 9};
    const cw_hit wrong = {.t = 2, .u = 0.5f, .v = 0, .i = 4, .j = 2, .triangle = CW_TRIANGLE_A};
    p = accuracy_exact(&on, &beside, &wrong);
    check(p.triangle == CW_TRIANGLE_B && p.i == 4 && p.j == 2 && p.t == 2 && p.u == 0.5 && p.v == 0.0625,
          "the place is %d %d %u, t = %g", p.i, p.j, p.triangle, p.t);
}

static void errors_have_units(void **state) {
    (void)state;
    const cw_ray ray = {.dir = {0, 3, 4}};
    check(exact_error_ulp(1 + 0x1p-23, 1) == 1, "an ULP of 1 is %g", exact_error_ulp(1 + 0x1p-23, 1));
    check(exact_error_ulp(0.75, 0.75 - 0x1p-23) == 2, "an ULP of 0.75 is %g", exact_error_ulp(0.75, 0.75 - 0x1p-23));
    check(exact_error_ulp(0x1p-149, 0) == 1, "an ULP of 0 is %g", exact_error_ulp(0x1p-149, 0));
    check(exact_error_cells(&ray, 2, 2.5) == 2.5, "t off by 0.5 is %g cells", exact_error_cells(&ray, 2, 2.5));
    float z[SAMPLES];
    make_ground(z, true);
    const true_surface on = true_surface_of(z, SIDE, SIDE);
    const cw_ray falling = {.org = {4.75f, 2.125f, 4}, .dir = {0, 0, -1}, .tmax = 9};
    check(accuracy_off_surface(&on, &falling, 2) == 0.5, "off by %g", accuracy_off_surface(&on, &falling, 2));
}

/* ---- verdicts ---- */

typedef struct question {
    const char *what;
    bool wall;
    cw_ray ray;
    double answer; /* t; infinite: a miss */
    double claim;  /* height */
    accuracy_verdict closest, any;
} question;

static const question questions[] = {
    {"straight through the ground",
     false,
     {{2.3f, 2.6f, 3}, 0, {0, 0, -1}, 9},
     INFINITY,
     0,
     ACCURACY_LEAK,
     ACCURACY_LEAK},
    {"the same, all explained", false, {{2.3f, 2.6f, 3}, 0, {0, 0, -1}, 9}, INFINITY, 9, ACCURACY_TIE, ACCURACY_TIE},
    {"never reaches the ground",
     false,
     {{2.3f, 2.6f, 3}, 0, {0, 0, -1}, 1.5f},
     1.4,
     0,
     ACCURACY_PHANTOM,
     ACCURACY_PHANTOM},
    {"the same, within the claim",
     false,
     {{2.3f, 2.6f, 3}, 0, {0, 0, -1}, 1.5f},
     1.4,
     0.75,
     ACCURACY_TIE,
     ACCURACY_TIE},
    {"in the air, before the hit",
     false,
     {{1.5f, 2.5f, 2}, 0, {1, 0, -0.25f}, 9},
     1,
     0,
     ACCURACY_PHANTOM,
     ACCURACY_RIGHT},
    {"where it should be", false, {{1.5f, 2.5f, 2}, 0, {1, 0, -0.25f}, 9}, 4, 0, ACCURACY_RIGHT, ACCURACY_RIGHT},
    {"the ground behind the wall",
     true,
     {{0.5f, 2.5f, 2.5f}, 0, {1, 0, -0.25f}, 9},
     6,
     0,
     ACCURACY_WRONG,
     ACCURACY_RIGHT},
    {"touches the wall, and misses", true, {{0.5f, 2.5f, 3}, 0, {1, 0, 0}, 6}, INFINITY, 0, ACCURACY_TIE, ACCURACY_TIE},
    {"a hair below the wall", true, {{0.5f, 2.5f, 2.999f}, 0, {1, 0, 0}, 6}, INFINITY, 0, ACCURACY_LEAK, ACCURACY_LEAK},
    {"a hair above it, a hit",
     true,
     {{0.5f, 2.5f, 3.001f}, 0, {1, 0, 0}, 6},
     3.5,
     0,
     ACCURACY_PHANTOM,
     ACCURACY_PHANTOM},
    {"ends at the ground", false, {{2.3f, 2.6f, 3}, 0, {0, 0, -1}, 2}, INFINITY, 0, ACCURACY_TIE, ACCURACY_TIE},
    {"beside the field", false, {{-3, 2.6f, 3}, 0, {0, 0, -1}, 9}, 2, 0, ACCURACY_PHANTOM, ACCURACY_TIE},
};

static cw_hit hit_at(const cw_ray *ray, double t) {
    if (!isfinite(t)) return (cw_hit){.t = INFINITY, .i = -1, .j = -1};
    const double x = (double)ray->org[0] + t * (double)ray->dir[0], y = (double)ray->org[1] + t * (double)ray->dir[1];
    return (cw_hit){.t = (float)t, .i = x < 0 ? 0 : (int32_t)x, .j = (int32_t)y, .triangle = CW_TRIANGLE_B};
}

static void verdicts_are_right(void **state) {
    (void)state;
    const cw_run strict = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    for (size_t k = 0; k < sizeof questions / sizeof questions[0]; k++) {
        const question *q = &questions[k];
        float z[SAMPLES];
        make_ground(z, q->wall);
        cw_field *field = make_field(z);
        const true_surface on = true_surface_of(z, SIDE, SIDE);
        const accuracy_claim claim = {.height = q->claim};
        cw_hit truth;
        check_status(cw_closest(field, &strict, &q->ray, 1, &truth), CW_OK);
        cw_field_destroy(field);
        const bool hit = truth.i >= 0;
        exact_hit exact = {0};
        if (hit) exact = accuracy_exact(&on, &q->ray, &truth);
        const cw_hit answer = hit_at(&q->ray, q->answer);
        const accuracy_verdict closest =
            accuracy_judge_closest(&on, &q->ray, &claim, &truth, hit ? &exact : NULL, &answer);
        check(closest == q->closest, "%s: verdict %d", q->what, (int)closest);
        const accuracy_verdict any = accuracy_judge_any(&on, &q->ray, &claim, hit, answer.i >= 0);
        check(any == q->any, "%s, any hit: verdict %d", q->what, (int)any);
    }
}

/* Walls that a ray meets only where it crosses a line y = j, or a diagonal. */
static void all_crossings_are_looked_at(void **state) {
    (void)state;
    float along[SAMPLES], across[SAMPLES];
    for (size_t k = 0; k < SAMPLES; k++) {
        along[k] = k / SIDE == 4 ? 3 : 1;
        across[k] = k / SIDE == k % SIDE ? 3 : 1;
    }
    const true_surface y = true_surface_of(along, SIDE, SIDE), diagonal = true_surface_of(across, SIDE, SIDE);
    const accuracy_claim none = {0};
    const cw_ray over_y = {.org = {2.5f, 2.5f, 2.5f}, .dir = {0, 1, 0}, .tmax = 3};
    const cw_ray over_diagonal = {.org = {3, 4, 2.5f}, .dir = {1, -1, 0}, .tmax = 1};
    check(accuracy_follow(&y, &over_y, 0, 3, &none).passes, "a wall along x is not seen");
    check(accuracy_follow(&diagonal, &over_diagonal, 0, 1, &none).passes, "a wall along a diagonal is not seen");
}

/* ---- summing up ---- */

enum { RAYS = 200 };

static void errors_are_counted(void **state) {
    (void)state;
    float z[SAMPLES];
    make_ground(z, false);
    const true_surface on = true_surface_of(z, SIDE, SIDE);
    cw_field *field = make_field(z);
    cw_ray rays[RAYS];
    for (size_t k = 0; k < RAYS; k++)
        rays[k] = (cw_ray){.org = {0.5f + (float)(k % 8), 0.25f + (float)(k / 32), 3}, .dir = {0, 0, -1}, .tmax = 9};
    accuracy_truth truth;
    check(accuracy_truth_make(&truth, &on, field, rays, RAYS) == CW_OK, "the reference does not run");
    cw_hit answers[RAYS];
    uint8_t occluded[RAYS];
    memcpy(answers, truth.hits, sizeof answers);
    memset(occluded, 1, sizeof occluded);
    const accuracy_claim none = {0};
    accuracy_errors e = accuracy_errors_of(&truth, 0, &none, field, (contender_answers){.hits = answers});
    check(e.rays == RAYS && e.hits == RAYS && e.verdicts[ACCURACY_RIGHT] == RAYS && e.broken == 0,
          "strict is not right");
    check(e.right_hits == RAYS && e.worst[0] == 0 && e.worst[2] == 0 && e.worst[3] < 1e-6, "exact hits have errors");
    check(e.worst[4] == 0 && e.worst[5] == 0 && e.worst[6] == 0, "exact hits have errors of t, u, v or point");

    answers[3] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
    answers[5].t = 2 + 0x1p-20f; /* 4 ULP of 2 */
    answers[6].u += 0x1p-10f;
    answers[7].triangle = CW_TRIANGLE_B; /* the same place as seen from there */
    answers[7].u += answers[7].v;
    answers[7].v = -truth.hits[7].u;
    occluded[3] = occluded[9] = 0;
    e = accuracy_errors_of(&truth, 0, &none, field, (contender_answers){.hits = answers});
    check(e.hits == RAYS - 1 && e.verdicts[ACCURACY_LEAK] == 1 && e.broken == 1, "the leak is not counted");
    check(e.right_hits == RAYS - 1 && e.median[0] == 0 && e.worst[0] == 4, "the worst error is %g ULP", e.worst[0]);
    check(e.worst[1] == 0x1p-20 && e.worst[2] == 0x1p-20, "the worst error is %g cells", e.worst[1]);
    check(e.worst[4] == 0x1p-21 && e.worst[5] == 0x1p-10 && e.worst[6] >= 0x1p-10 && e.worst[6] < 0x1p-8,
          "the worst errors are %g of t, %g of u, %g of a point", e.worst[4], e.worst[5], e.worst[6]);
    check(e.most[4] == 0 && e.most[5] == 0, "one error in 199 is among the least 99.9 %%");
    e = accuracy_errors_of(&truth, 0, &none, NULL, (contender_answers){.occluded = occluded});
    check(e.hits == RAYS - 2 && e.verdicts[ACCURACY_LEAK] == 2, "leaks of any hit: %zu", e.verdicts[ACCURACY_LEAK]);

    /* A claim explains the leak, which stays one against the true surface. */
    const accuracy_claim wide = {.height = 9};
    e = accuracy_errors_of(&truth, 0, &wide, field, (contender_answers){.hits = answers});
    check(e.verdicts[ACCURACY_LEAK] == 1 && e.broken == 0, "a claim hides a leak, or does not explain it");
    e = accuracy_errors_of(&truth, 0, &wide, NULL, (contender_answers){.occluded = occluded});
    check(e.verdicts[ACCURACY_LEAK] == 2 && e.broken == 0, "a claim hides a leak, or does not explain it");

    /* Every second run of 16: rays 0 to 15, 32 to 47, … */
    cw_ray thin[RAYS];
    check(accuracy_thin(rays, RAYS, 1, thin) == 104, "thinned to %zu", accuracy_thin(rays, RAYS, 1, NULL));
    check(memcmp(&thin[16], &rays[32], 16 * sizeof thin[0]) == 0, "the second run is another");
    for (size_t m = 0; m < 104; m++) answers[m] = truth.hits[m / 16 * 32 + m % 16];
    e = accuracy_errors_of(&truth, 1, &none, field, (contender_answers){.hits = answers});
    check(e.rays == 104 && e.verdicts[ACCURACY_RIGHT] == 104, "thinned answers are held against other rays");
    accuracy_truth_free(&truth);
    cw_field_destroy(field);
}

static void quantising_keeps_its_claim(void **state) {
    (void)state;
    enum { COUNT = 65 * 65 };
    float z[COUNT], q[COUNT];
    terrain_fractal(z, 65, 65, 7, 0.3f);
    z[17] = NAN;
    memcpy(q, z, sizeof z);
    const accuracy_claim claim = accuracy_quantise(q, COUNT);
    double worst = 0;
    for (size_t k = 0; k < COUNT; k++) {
        check(isnan(z[k]) == isnan(q[k]), "sample %zu: hole or none", k);
        if (!isnan(z[k])) worst = fmax(worst, fabs((double)z[k] - (double)q[k]));
    }
    /* Heights span 0.3 · 64 cells; half of a 65535th of that. */
    check(fabs(claim.height - 19.2 / 65535 / 2) < 1e-6, "the claim is %g", claim.height);
    check(worst <= claim.height && worst > 0.9 * claim.height, "off by %g of %g", worst, claim.height);
    float flat[] = {2, 2, 2};
    check(accuracy_quantise(flat, 3).height == 0 && flat[1] == 2, "a flat field is quantised");
}

/* ---- aimed rays ---- */

static void aimed_rays_have_to_hit(void **state) {
    (void)state;
    enum { COUNT = 4096 };
    workload_field samples;
    check(workload_field_make("65", &samples), "no field");
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples.z;
    desc.nx = samples.nx;
    desc.ny = samples.ny;
    cw_field *field;
    check_status(cw_field_create(&desc, NULL, &field), CW_OK);
    const cw_field_info info = cw_field_describe(field);
    cw_ray *rays = malloc(COUNT * sizeof *rays);
    cw_hit *hits = malloc(COUNT * sizeof *hits);
    const cw_run strict = {.leaf = CW_LEAF_WATERTIGHT};
    for (workload_class c = WORKLOAD_VERTICES; c <= WORKLOAD_EDGES; c++) {
        check(workload_rays_make(field, c, 3, COUNT, rays) == COUNT, "no rays");
        check_status(cw_closest(field, &strict, rays, COUNT, hits), CW_OK);
        size_t near = 0, upwards = 0; /* hits at a vertex, or an edge */
        for (size_t k = 0; k < COUNT; k++) {
            const cw_ray *r = &rays[k];
            const float begin = r->org[2], end = r->org[2] + r->tmax * r->dir[2];
            const bool up = r->dir[2] > 0;
            check(up ? begin < info.low && end > info.high : begin > info.high && end < info.low,
                  "ray %zu is too short", k);
            upwards += up;
            for (int a = 0; a < 2; a++) check(r->org[a] > 0 && r->org[a] < 64, "ray %zu starts beside the field", k);
            check(hits[k].i >= 0, "strict misses with ray %zu", k);
            const float u = hits[k].u, v = hits[k].v, w = 1 - u - v, hair = 1e-4f;
            const bool edge = u < hair || v < hair || w<hair, vertex = u> 1 - hair || v > 1 - hair || w > 1 - hair;
            near += c == WORKLOAD_VERTICES ? vertex : edge;
        }
        check(near > COUNT / 2, "only %zu of the rays hit what they are aimed at", near);
        check(upwards > COUNT / 3 && upwards < COUNT - COUNT / 3, "%zu rays go upwards", upwards);
    }
    free(rays);
    free(hits);
    cw_field_destroy(field);
    workload_field_free(&samples);
}

/* ---- normals ---- */

static double apart(const double a[3], const double b[3]) {
    return fmax(fabs(a[0] - b[0]), fmax(fabs(a[1] - b[1]), fabs(a[2] - b[2])));
}

static void normals_are_known(void **state) {
    (void)state;
    float z[SAMPLES], plane[SAMPLES];
    terrain_fractal(z, SIDE, SIDE, 5, 0.5f);
    for (size_t k = 0; k < SAMPLES; k++) plane[k] = 2 * (float)(k % SIDE) - 3 * (float)(k / SIDE);
    const true_surface on = true_surface_of(z, SIDE, SIDE), flat = true_surface_of(plane, SIDE, SIDE);
    cw_field *field = make_field(z);
    const double up = sqrt(14), right[3] = {-2 / up, 3 / up, 1 / up};
    for (uint32_t k = 0; k < 200; k++) {
        cw_hit hit = {.i = 1 + (int32_t)(k % 6), .j = 1 + (int32_t)(k / 40), .triangle = k % 2};
        hit.u = (float)(terrain_hash(1, k, 0) % 100) / 200;
        hit.v = (float)(terrain_hash(1, k, 1) % 100) / 200;
        double ours[3], theirs[3];
        accuracy_normal_at(&on, &hit, ACCURACY_BARYCENTRIC, ours);
        cw_hit_phong_normals(field, NULL, &hit, 1, theirs);
        check(apart(ours, theirs) < 1e-14, "barycentric normal %u is off by %g", k, apart(ours, theirs));
        accuracy_normal_at(&on, &hit, ACCURACY_FACET, ours);
        cw_hit_normals(field, NULL, &hit, 1, theirs);
        check(apart(ours, theirs) < 1e-14, "facet normal %u is off by %g", k, apart(ours, theirs));
        for (int kind = 0; kind < ACCURACY_NORMAL_COUNT; kind++) {
            accuracy_normal_at(&flat, &hit, (accuracy_normal)kind, ours);
            check(apart(ours, right) < 1e-14, "normal %d of a plane", kind);
        }
        /* On the diagonal and at the vertices weights differ, but at vertices both take one normal. */
        hit.u = k % 3 == 1 ? 1 : 0;
        hit.v = k % 3 == 2 ? 1 : 0;
        accuracy_normal_at(&on, &hit, ACCURACY_BARYCENTRIC, ours);
        accuracy_normal_at(&on, &hit, ACCURACY_BILINEAR, theirs);
        check(apart(ours, theirs) < 1e-14, "vertex %u has two normals", k);
        /* There central differences are those of the four neighbours. */
        const size_t corner[2][3] = {{0, 1, SIDE + 1}, {0, SIDE + 1, SIDE}};
        const float *c = z + hit.j * SIDE + hit.i + corner[hit.triangle][k % 3];
        const double x = ((double)c[-1] - (double)c[1]) / 2, y = ((double)c[-SIDE] - (double)c[SIDE]) / 2;
        const double length = sqrt(x * x + y * y + 1), central[3] = {x / length, y / length, 1 / length};
        for (int kind = ACCURACY_CENTRAL_BARYCENTRIC; kind <= ACCURACY_CENTRAL_BILINEAR; kind++) {
            accuracy_normal_at(&on, &hit, (accuracy_normal)kind, ours);
            check(apart(ours, central) < 1e-14, "central normal %d of vertex %u is off by %g", kind, k,
                  apart(ours, central));
        }
    }
    /* Half way along an edge both mean the two normals at its ends; in the middle of a cell they need not. */
    const cw_hit edge = {.u = 0.5f, .i = 3, .j = 3, .triangle = CW_TRIANGLE_A};
    const cw_hit middle = {.u = 0, .v = 0.5f, .i = 3, .j = 3, .triangle = CW_TRIANGLE_A};
    double a[3], b[3];
    accuracy_normal_at(&on, &edge, ACCURACY_BARYCENTRIC, a);
    accuracy_normal_at(&on, &edge, ACCURACY_BILINEAR, b);
    check(apart(a, b) < 1e-14, "an edge has two normals");
    accuracy_normal_at(&on, &middle, ACCURACY_BARYCENTRIC, a);
    accuracy_normal_at(&on, &middle, ACCURACY_BILINEAR, b);
    check(apart(a, b) > 1e-3, "the middle has one normal");
    cw_field_destroy(field);
}

/* ---- pictures ---- */

static void pictures_are_compared(void **state) {
    (void)state;
    float a[12] = {0, 0, 0, 0.5f, 0.5f, 0.5f, 1, 1, 1, 9, 9, 9}, b[12];
    memcpy(b, a, sizeof a);
    b[3] = 0.25f;    /* pixel (1, 0) */
    b[6] = 1 + 0.5f; /* white already: another number, but the same to see */
    b[0] = 0x1p-12f; /* to be seen by no eye */
    const io_image first = {.width = 2, .height = 2, .rgb = a}, second = {.width = 2, .height = 2, .rgb = b};
    const picture_difference p = picture_compare(&first, &second);
    check(p.worst == 0.25 && p.worst_x == 1 && p.worst_y == 0, "worst %g at (%zu, %zu)", p.worst, p.worst_x, p.worst_y);
    check(p.pixels == 4 && p.differ == 3 && p.visible == 1, "%zu pixels differ, %zu visibly", p.differ, p.visible);
    check(fabs(p.rmse - sqrt((0.0625 + 0x1p-24) / 12)) < 1e-12, "RMSE %g", p.rmse);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_exact),
        cmocka_unit_test(places_are_exact),
        cmocka_unit_test(errors_have_units),
        cmocka_unit_test(verdicts_are_right),
        cmocka_unit_test(all_crossings_are_looked_at),
        cmocka_unit_test(errors_are_counted),
        cmocka_unit_test(quantising_keeps_its_claim),
        cmocka_unit_test(aimed_rays_have_to_hit),
        cmocka_unit_test(normals_are_known),
        cmocka_unit_test(pictures_are_compared),
    };
    return cmocka_run_group_tests_name("bench_accuracy", tests, NULL, NULL);
}
