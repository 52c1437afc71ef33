/* SPDX-License-Identifier: Apache-2.0 */
/* Extremes, each a test by name, for every kernel that this machine runs and every leaf test.
 *
 * What is expected. Watertight: by the exact oracle, no leak, no phantom, no wrong surface. Möller-Trumbore: the same, but
 * that rounding may let a ray slip through at an edge, and decides about triangles that the ray is all but parallel to
 * (judged as in brute.c); it never hits a triangle whose plane the ray lies in. Where an item has more to say, it says
 * so. grid3d-early may hit wrong surfaces: that is what its name says. */

#include "check.h"
#include "tally.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#ifndef TEST_SCALE_DOWN
#define TEST_SCALE_DOWN 1
#endif
enum { RAYS = 200 / TEST_SCALE_DOWN, PATHS = 64 };

/* ---- every kernel and leaf test ---------------------------------------------------------------------------------- */

typedef struct path {
    cw_query query;
    const char *name;
    cw_leaf leaf;
} path;

static path paths[PATHS];
static size_t path_count;

static int find_paths(void **state) {
    (void)state;
    for (size_t k = 0; k < cw_kernel_count(); k++)
        for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
            if (!info.available || (leaf == CW_LEAF_WATERTIGHT && info.default_leaf != CW_LEAF_WATERTIGHT)) continue;
            check(path_count < PATHS, "too many kernels");
            paths[path_count++] = (path){{.kernel = cw_kernel_at(k), .leaf = (cw_leaf)leaf}, info.name, (cw_leaf)leaf};
        }
    return 0;
}

static bool is_early(const path *p) { return strcmp(p->name, "grid3d-early") == 0; }

static bool excused(const path *p, const oracle_truth *truth, const judgement *j) {
    if (j->verdict <= VERDICT_TIE) return true;
    if (p->leaf != CW_LEAF_MOLLER_TRUMBORE) return false;
    if (j->verdict == VERDICT_WRONG_SURFACE && is_early(p)) return true;
    return j->verdict == VERDICT_PHANTOM ? j->apart <= j->blur : truth->pass_edge <= truth->pass_blur;
}

/* Brute force is for small fields, and so is a grid of 64 voxels an axis where all heights but a few are the same. */
static bool left_out(const path *p, const test_field *f) {
    return (strcmp(p->name, "brute") == 0 || strncmp(p->name, "grid3d", 6) == 0) && f->nx * f->ny > 400;
}

/* The same answer to the same ray, from a path of which no less is expected. */
static bool judged_before(cw_hit hits[PATHS][RAYS], size_t p, size_t k) {
    for (size_t first = 0; first < p; first++)
        if (paths[first].leaf == paths[p].leaf && !is_early(&paths[first]) && hit_same(&hits[first][k], &hits[p][k]))
            return true;
    return false;
}

/* Judges all paths on n <= RAYS rays; returns how many of the rays meet the field exactly. */
static size_t judge_rays(const test_field *f, const cw_ray *rays, size_t n) {
    static cw_hit hits[PATHS][RAYS];
    static uint8_t occluded[RAYS];
    cw_field *field = field_open(f);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    assert_non_null(o);
    for (size_t p = 0; p < path_count; p++) {
        memset(hits[p], 0xff, sizeof hits[p]);
        if (left_out(&paths[p], f)) continue;
        check_status(cw_closest(field, &paths[p].query, rays, n, hits[p]), CW_OK);
        check_status(cw_any(field, &paths[p].query, rays, n, occluded), CW_OK);
        for (size_t k = 0; k < n; k++)
            check(occluded[k] == (hits[p][k].i >= 0), "%s: any and closest hit differ", paths[p].name);
    }
    size_t met = 0;
    for (size_t k = 0; k < n; k++) {
        const oracle_truth *truth = oracle_trace(o, &rays[k]);
        met += truth->hit;
        for (size_t p = 0; p < path_count; p++) {
            if (left_out(&paths[p], f) || judged_before(hits, p, k)) continue;
            const judgement j = oracle_judge(o, &hits[p][k]);
            if (excused(&paths[p], truth, &j)) continue;
            tally_explain(f, &rays[k], &hits[p][k], truth, &j);
            check(false, "%s with %s: %s", paths[p].name, cw_leaf_name(paths[p].leaf), verdict_name(j.verdict));
        }
    }
    oracle_destroy(o);
    cw_field_destroy(field);
    return met;
}

/* Rays of a class on a shape in all sizes. */
static void judge_class(ray_class kind, field_shape shape) {
    static test_field f;
    static cw_ray rays[RAYS];
    random_state r = {(uint64_t)kind * 1000 + (uint64_t)shape};
    size_t met = 0;
    for (size_t s = 0; s < FIELD_SIZES; s++) {
        field_make(&f, shape, field_sizes[s].nx, field_sizes[s].ny, s);
        for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make(kind, &f, &r);
        met += judge_rays(&f, rays, RAYS);
    }
    check(met > 0 || kind == RAY_NOT_FINITE || kind == RAY_LATTICE, "no ray of class %s meets the field",
          ray_class_name(kind));
}

static void judge_class_on_all(ray_class kind) {
    for (int shape = 0; shape < FIELD_SHAPES; shape++) judge_class(kind, (field_shape)shape);
}

static void judge_all_on(field_shape shape) {
    for (int kind = 0; kind < RAY_CLASSES; kind++) judge_class((ray_class)kind, shape);
}

/* One ray on a small field given by its samples, with what each path has to find: t (infinity for a miss). */
static void expect(size_t nx, size_t ny, const float *z, cw_ray ray, float watertight, float moller_trumbore,
                   const char *what) {
    test_field f = {.shape = FIELD_INTEGERS, .nx = nx, .ny = ny};
    memcpy(f.z, z, nx * ny * sizeof *z);
    cw_field *field = field_open(&f);
    for (size_t p = 0; p < path_count; p++) {
        const float wanted = paths[p].leaf == CW_LEAF_WATERTIGHT ? watertight : moller_trumbore;
        cw_hit hit;
        check_status(cw_closest(field, &paths[p].query, &ray, 1, &hit), CW_OK);
        check(hit.t == wanted && (hit.i >= 0) == (wanted < INFINITY), "%s with %s, %s: t = %g instead of %g",
              paths[p].name, cw_leaf_name(paths[p].leaf), what, (double)hit.t, (double)wanted);
    }
    cw_field_destroy(field);
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

static void test_axis_parallel(void **state) {
    (void)state;
    judge_class_on_all(RAY_AXIS);
}

static void test_vertical(void **state) {
    (void)state;
    judge_class_on_all(RAY_VERTICAL);
    /* On every sample, edge and diagonal of a 3 × 3 field: exact, and for Möller-Trumbore too, since all is whole. */
    const float z[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    const float ends[][2] = {{0, INFINITY}, {-INFINITY, INFINITY}, {-INFINITY, 2}, {2, 2}};
    for (int place = 0; place < 25; place++)
        for (int range = 0; range < 4; range++)
            for (int down = 0; down < 2; down++) {
                const cw_ray ray = {.org = {0.5f * (float)(place % 5), 0.5f * (float)(place / 5), down ? 3 : -1},
                                    .dir = {0, 0, down ? -1 : 1},
                                    .tmin = ends[range][0],
                                    .tmax = ends[range][1]};
                expect(3, 3, z, ray, 2, 2, "vertical");
            }
}

static void test_zero_and_denormal_components(void **state) {
    (void)state;
    judge_class_on_all(RAY_ZEROS);
    const float z[4] = {0, 0, 0, 0};
    cw_ray ray = {.org = {0.25f, 0.5f, 1}, .dir = {0, 0, 0}, .tmin = -INFINITY, .tmax = INFINITY};
    expect(2, 2, z, ray, INFINITY, INFINITY, "no direction");
    ray.dir[2] = -0x1p-128f;
    expect(2, 2, z, ray, INFINITY, INFINITY, "a direction that counts as none");
    ray.dir[2] = -1;
    ray.dir[0] = -0.0f;
    ray.dir[1] = 0x1p-149f;
    expect(2, 2, z, ray, 1, 1, "zeros of both signs and a denormal");
    ray.dir[1] = -0x1p-128f;
    expect(2, 2, z, ray, 1, 1, "a component that counts as zero");
}

/* Up to 2^126, beyond which a reciprocal is denormal and a difference of two components may overflow. */
static void test_long_directions(void **state) {
    (void)state;
    const float z[4] = {0, 0, 0, 0}, longest = 0x1p126f, beyond = nextafterf(longest, INFINITY);
    cw_ray ray = {.org = {0.25f, 0.5f, 1}, .dir = {0, 0, -longest}, .tmin = -INFINITY, .tmax = INFINITY};
    expect(2, 2, z, ray, 0x1p-126f, 0x1p-126f, "the longest direction that counts");
    ray.dir[2] = -beyond;
    expect(2, 2, z, ray, INFINITY, INFINITY, "too long in z");
    ray.dir[2] = -1;
    ray.dir[0] = beyond;
    expect(2, 2, z, ray, INFINITY, INFINITY, "too long in x");
    ray.dir[0] = 0;
    ray.dir[1] = -FLT_MAX;
    expect(2, 2, z, ray, INFINITY, INFINITY, "too long in y");
}

static void test_through_vertices(void **state) {
    (void)state;
    judge_class_on_all(RAY_VERTEX);
}

static void test_through_and_along_edges(void **state) {
    (void)state;
    judge_class_on_all(RAY_EDGE);
    judge_class_on_all(RAY_DIAGONAL);
    judge_class_on_all(RAY_ALONG);
}

/* A ray in the plane of a flat field hits where it enters the field or where its t-range begins. Möller-Trumbore's
 * determinant is zero: it misses. */
static void test_in_plane(void **state) {
    (void)state;
    judge_class_on_all(RAY_IN_PLANE);
    const float flat[9] = {2, 2, 2, 2, 2, 2, 2, 2, 2};
    cw_ray ray = {.org = {-1, 0.5f, 2}, .dir = {1, 0, 0}, .tmax = INFINITY};
    expect(3, 3, flat, ray, 1, INFINITY, "in the plane along x");
    ray.tmin = 1.5f;
    expect(3, 3, flat, ray, 1.5f, INFINITY, "in the plane, from inside");
    ray.tmax = 1.5f;
    expect(3, 3, flat, ray, 1.5f, INFINITY, "in the plane, a point");
    ray = (cw_ray){.org = {-1, -1, 2}, .dir = {1, 1, 0}, .tmax = INFINITY};
    expect(3, 3, flat, ray, 1, INFINITY, "in the plane along the diagonal");
    ray.org[2] = nextafterf(2, 3);
    expect(3, 3, flat, ray, INFINITY, INFINITY, "just above the plane");
}

/* Between 1 and 10^-6 degrees to the triangle that is aimed at. The shallower, the more of the answer is rounding; the
 * bound on t grows with 1 / d', and the oracle holds the hits to it. */
static void test_grazing(void **state) {
    (void)state;
    judge_class_on_all(RAY_GRAZING);
    /* Down on a flat field, 10^-6 degrees and 2^-25: exact in float, so the crossing is where it has to be. */
    static test_field f;
    field_make(&f, FIELD_FLAT, 65, 65, 1);
    cw_ray ray = {.org = {-10, 31.5f, 0.375f + 0x1p-20f}, .dir = {1, 0, -0x1p-25f}, .tmax = INFINITY};
    assert_int_equal(judge_rays(&f, &ray, 1), 1);
}

/* ---- fields ------------------------------------------------------------------------------------------------------ */

static void test_flat(void **state) {
    (void)state;
    judge_all_on(FIELD_FLAT);
    judge_all_on(FIELD_PLANE);
}

static void test_cliffs(void **state) {
    (void)state;
    judge_all_on(FIELD_CLIFF);
}

static void test_spikes_and_checkerboards(void **state) {
    (void)state;
    judge_all_on(FIELD_SPIKES);
    judge_all_on(FIELD_CHECKER);
}

/* Heights 1e-30, 1e30, and all between in one field. */
static void test_tiny_and_huge_heights(void **state) {
    (void)state;
    judge_all_on(FIELD_TINY);
    judge_all_on(FIELD_HUGE);
    judge_all_on(FIELD_MIXED);
}

/* Heights and rays times 2^60 or 2^-60: nothing rounds differently, so all but z is the same in every bit. */
static void test_scaled_heights_change_nothing(void **state) {
    (void)state;
    static test_field f, scaled;
    static cw_ray rays[RAYS], scaled_rays[RAYS];
    static cw_hit hits[RAYS], scaled_hits[RAYS];
    random_state r = {60};
    for (int power = -60; power <= 60; power += 120) {
        field_make(&f, FIELD_RANDOM, 31, 12, 60);
        scaled = f;
        for (size_t k = 0; k < f.nx * f.ny; k++) scaled.z[k] = ldexpf(f.z[k], power);
        for (size_t k = 0; k < RAYS; k++) {
            static const ray_class kinds[] = {RAY_RANDOM, RAY_VERTEX, RAY_EDGE, RAY_GRAZING, RAY_VERTICAL, RAY_OUTSIDE};
            rays[k] = scaled_rays[k] = ray_make(kinds[k % 6], &f, &r);
            scaled_rays[k].org[2] = ldexpf(rays[k].org[2], power);
            scaled_rays[k].dir[2] = ldexpf(rays[k].dir[2], power);
        }
        cw_field *a = field_open(&f), *b = field_open(&scaled);
        for (size_t p = 0; p < path_count; p++) {
            if (strncmp(paths[p].name, "grid3d", 6) == 0) continue; /* its voxels depend on the field's proportions */
            check_status(cw_closest(a, &paths[p].query, rays, RAYS, hits), CW_OK);
            check_status(cw_closest(b, &paths[p].query, scaled_rays, RAYS, scaled_hits), CW_OK);
            for (size_t k = 0; k < RAYS; k++) {
                if (hit_same(&hits[k], &scaled_hits[k])) continue;
                ray_print(&rays[k]);
                hit_print("as is", &hits[k]);
                hit_print("scaled", &scaled_hits[k]);
                check(false, "%s with %s: other hit with heights times 2^%d", paths[p].name,
                      cw_leaf_name(paths[p].leaf), power);
            }
        }
        cw_field_destroy(a);
        cw_field_destroy(b);
    }
}

static void test_sizes(void **state) {
    (void)state; /* every size is in judge_class: 2 × 2, one cell wide, one cell long, square, neither */
    judge_all_on(FIELD_RANDOM);
    judge_all_on(FIELD_INTEGERS);
}

/* A triangle with a hole at a vertex does not exist: rays pass through it, and through nothing else. */
static void test_holes(void **state) {
    (void)state;
    judge_all_on(FIELD_HOLES);
    const float no = NAN;
    for (int hole = 0; hole < 4; hole++) {
        float z[4] = {1, 1, 1, 1};
        z[hole] = no;
        const bool in_a = hole != 2, in_b = hole != 1; /* samples (0,0) and (1,1) belong to both */
        const cw_ray a = {.org = {0.75f, 0.25f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
        const cw_ray b = {.org = {0.25f, 0.75f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
        expect(2, 2, z, a, in_a ? INFINITY : 2, in_a ? INFINITY : 2, "a hole under triangle A");
        expect(2, 2, z, b, in_b ? INFINITY : 2, in_b ? INFINITY : 2, "a hole under triangle B");
    }
    /* Behind a hole there is a surface. */
    const float z[8] = {0, no, 0, 0, 0, no, 0, 0};
    const cw_ray ray = {.org = {0.5f, 0.5f, 1}, .dir = {1, 0, 0}, .tmax = INFINITY};
    expect(4, 2, z, ray, INFINITY, INFINITY, "above all that there is");
    const cw_ray steep = {.org = {0, 0.5f, 2.5f}, .dir = {1, 0, -1}, .tmax = INFINITY};
    expect(4, 2, z, steep, 2.5f, 2.5f, "through holes onto what lies behind");
}

/* Infinite samples, of both signs, are holes as NaN is: the same bits in every path, and whoever copied them. */
static void test_infinite_samples(void **state) {
    (void)state;
    static test_field f, infinite;
    static cw_ray rays[RAYS];
    static cw_hit hits[RAYS], same[RAYS];
    random_state r = {17};
    size_t through = 0;
    for (size_t s = 0; s < FIELD_SIZES; s++) {
        field_make(&f, FIELD_HOLES, field_sizes[s].nx, field_sizes[s].ny, s);
        infinite = f;
        for (size_t k = 0, n = 0; k < f.nx * f.ny; k++)
            if (isnan(f.z[k])) infinite.z[k] = n++ % 2 ? INFINITY : -INFINITY;
        cw_field *a = field_open(&f), *b = field_open_copied(&infinite);
        for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &f, &r);
        for (size_t p = 0; p < path_count; p++) {
            check_status(cw_closest(a, &paths[p].query, rays, RAYS, hits), CW_OK);
            check_status(cw_closest(b, &paths[p].query, rays, RAYS, same), CW_OK);
            for (size_t k = 0; k < RAYS; k++) {
                through += hits[k].i < 0;
                check(hit_same(&hits[k], &same[k]), "%s with %s: other hits with infinite samples than with NaN",
                      paths[p].name, cw_leaf_name(paths[p].leaf));
            }
        }
        cw_field_destroy(a);
        cw_field_destroy(b);
    }
    check(through > 0, "no ray goes through a hole");
}

/* ---- origins and t-ranges ---------------------------------------------------------------------------------------- */

static void test_far_origins(void **state) {
    (void)state;
    judge_class_on_all(RAY_OUTSIDE);
    judge_class_on_all(RAY_FAR);
}

static void test_not_finite(void **state) {
    (void)state;
    judge_class_on_all(RAY_NOT_FINITE);
    judge_class_on_all(RAY_SCALED);
}

/* A t-range is closed: a hit at its very ends counts, one float beyond does not. */
static void test_ranges_that_end_on_the_surface(void **state) {
    (void)state;
    judge_class_on_all(RAY_RANGE);
    judge_class_on_all(RAY_LATTICE);
    const float z[4] = {1, 1, 1, 1}, up = nextafterf(2, 3), below = nextafterf(2, 1);
    const float ends[][2] = {{2, 2}, {2, 9}, {0, 2}, {-1, up}, {below, 5}, {up, 9}, {0, below}, {3, 1}};
    for (int k = 0; k < 8; k++) {
        const float t = k < 5 ? 2 : INFINITY;
        cw_ray ray = {.org = {0.75f, 0.25f, 3}, .dir = {0, 0, -1}, .tmin = ends[k][0], .tmax = ends[k][1]};
        expect(2, 2, z, ray, t, t, "vertical");
        ray = (cw_ray){.org = {-1.5f, 0.5f, 3}, .dir = {1, 0, -1}, .tmin = ends[k][0], .tmax = ends[k][1]};
        expect(2, 2, z, ray, t, t, "slanted");
    }
}

#if defined(__SSE__)
/* Whether the caller flushes denormals or not, each path gives the same bits. */
static void test_flush_to_zero(void **state) {
    (void)state;
    static test_field f;
    static cw_ray rays[RAYS];
    static cw_hit plain[RAYS], flushed[RAYS];
    random_state r = {16};
    field_make(&f, FIELD_MIXED, 17, 17, 16);
    for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make(k % 2 ? RAY_ZEROS : (ray_class)(k / 2 % RAY_CLASSES), &f, &r);
    cw_field *field = field_open(&f);
    const unsigned before = _mm_getcsr();
    for (size_t p = 0; p < path_count; p++) {
        check_status(cw_closest(field, &paths[p].query, rays, RAYS, plain), CW_OK);
        _mm_setcsr(before | 0x8040u);
        const cw_status status = cw_closest(field, &paths[p].query, rays, RAYS, flushed);
        const unsigned after = _mm_getcsr();
        _mm_setcsr(before);
        check_status(status, CW_OK);
        check(after == (before | 0x8040u), "%s: the caller's environment became %#x", paths[p].name, after);
        for (size_t k = 0; k < RAYS; k++)
            check(hit_same(&plain[k], &flushed[k]), "%s: other hits with FTZ and DAZ", paths[p].name);
    }
    cw_field_destroy(field);
}
#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axis_parallel),
        cmocka_unit_test(test_vertical),
        cmocka_unit_test(test_zero_and_denormal_components),
        cmocka_unit_test(test_long_directions),
        cmocka_unit_test(test_through_vertices),
        cmocka_unit_test(test_through_and_along_edges),
        cmocka_unit_test(test_in_plane),
        cmocka_unit_test(test_grazing),
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_cliffs),
        cmocka_unit_test(test_spikes_and_checkerboards),
        cmocka_unit_test(test_tiny_and_huge_heights),
        cmocka_unit_test(test_scaled_heights_change_nothing),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_holes),
        cmocka_unit_test(test_infinite_samples),
        cmocka_unit_test(test_far_origins),
        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_ranges_that_end_on_the_surface),
#if defined(__SSE__)
        cmocka_unit_test(test_flush_to_zero),
#endif
    };
    return cmocka_run_group_tests_name("extremes", tests, find_paths, NULL);
}
