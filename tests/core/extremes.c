/* SPDX-License-Identifier: Apache-2.0 */
/* Extremes, each a test by name, for every kernel that this machine runs and every leaf test.
 *
 * What is expected. Watertight: by the exact oracle, no leak, no phantom, no wrong surface. Möller-Trumbore: the same, but
 * that rounding may let a ray slip through at an edge, and decides about triangles that the ray is all but parallel to;
 * it never hits a triangle whose plane the ray lies in. Where an item has more to say, it says so. */

#include "check.h"
#include "extremes_judge.h"
#include "fp_register.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { RAYS = EXTREME_RAYS };

/* Rays of a class on a shape in one size. */
static size_t judge_size(ray_class kind, field_shape shape, size_t size, random_state *r) {
    static test_field f;
    static cw_ray rays[RAYS];
    const size_t n = test_share(RAYS, 15);
    field_make(&f, shape, field_sizes[size].nx, field_sizes[size].ny, size);
    for (size_t k = 0; k < n; k++) rays[k] = ray_make(kind, &f, r);
    return extreme_judge(&f, rays, n);
}

/* In all sizes; where time is short in one of three, so that a class sees all of them on the one shape or the other. */
static void judge_class(ray_class kind, field_shape shape) {
    const size_t step = test_step(3);
    random_state r = {(uint64_t)kind * 1000 + (uint64_t)shape};
    size_t met = 0;
    for (size_t s = (size_t)shape % step; s < FIELD_SIZES; s += step) met += judge_size(kind, shape, s, &r);
    check(met > 0 || kind == RAY_NOT_FINITE || kind == RAY_LATTICE, "no ray of class %s meets the field",
          ray_class_name(kind));
}

static void judge_class_on_all(ray_class kind) {
    for (int shape = 0; shape < FIELD_SHAPES; shape++) judge_class(kind, (field_shape)shape);
}

static void judge_all_on(field_shape shape) {
    for (int kind = 0; kind < RAY_CLASSES; kind++) judge_class((ray_class)kind, shape);
}

/* ---- directions -------------------------------------------------------------------------------------------------- */

static void test_axis_parallel(void **state) {
    (void)state;
    extreme_item("axis-parallel rays", "the exact answer; a crossing that never comes decides nothing");
    judge_class_on_all(RAY_AXIS);
}

static void test_vertical(void **state) {
    (void)state;
    extreme_item("vertical rays", "the exact answer, on samples, edges and diagonals too: no crossing is rounded");
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
                extreme_expect(3, 3, z, ray, 2, 2, "vertical");
            }
}

static void test_zero_and_denormal_components(void **state) {
    (void)state;
    extreme_item("zero, negative-zero and denormal direction components",
                 "up to 2^-128 a component counts as zero, because its reciprocal is no float");
    judge_class_on_all(RAY_ZEROS);
    const float z[4] = {0, 0, 0, 0};
    cw_ray ray = {.org = {0.25f, 0.5f, 1}, .dir = {0, 0, 0}, .tmin = -INFINITY, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "no direction");
    ray.dir[2] = -0x1p-128f;
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "a direction that counts as none");
    ray.dir[2] = -1;
    ray.dir[0] = -0.0f;
    ray.dir[1] = 0x1p-149f;
    extreme_expect(2, 2, z, ray, 1, 1, "zeros of both signs and a denormal");
    ray.dir[1] = -0x1p-128f;
    extreme_expect(2, 2, z, ray, 1, 1, "a component that counts as zero");
}

/* Up to 2^126, beyond which a reciprocal is denormal and a difference of two components may overflow. */
static void test_long_directions(void **state) {
    (void)state;
    extreme_item("directions of any length, up to 2^126 and beyond",
                 "beyond 2^126 a component counts as infinite, because its reciprocal is denormal");
    judge_class_on_all(RAY_SCALED);
    const float z[4] = {0, 0, 0, 0}, longest = 0x1p126f, beyond = nextafterf(longest, INFINITY);
    cw_ray ray = {.org = {0.25f, 0.5f, 1}, .dir = {0, 0, -longest}, .tmin = -INFINITY, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, 0x1p-126f, 0x1p-126f, "the longest direction that counts");
    ray.dir[2] = -beyond;
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "too long in z");
    ray.dir[2] = -1;
    ray.dir[0] = beyond;
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "too long in x");
    ray.dir[0] = 0;
    ray.dir[1] = -FLT_MAX;
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "too long in y");
}

static void test_through_vertices(void **state) {
    (void)state;
    extreme_item("rays through vertices", "a hit: all six triangles see the same sign");
    judge_class_on_all(RAY_VERTEX);
}

static void test_through_edges(void **state) {
    (void)state;
    extreme_item("rays through cell borders and diagonals", "a hit: both triangles see the same sign");
    judge_class_on_all(RAY_EDGE);
    judge_class_on_all(RAY_DIAGONAL);
}

/* A ray exactly above an edge is over both of its triangles; one within the edge touches both all along. */
static void test_along_edges(void **state) {
    (void)state;
    extreme_item("rays along edges, cell borders and diagonals",
                 "a hit in one of the two triangles, the first on the walk; a touch is a hit");
    judge_class_on_all(RAY_ALONG);
    const float ridge[9] = {0, 1, 0, 0, 1, 0, 0, 1, 0}, crest[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    cw_ray ray = {.org = {1, -1, 2}, .dir = {0, 1, -0.5f}, .tmax = INFINITY};
    extreme_expect(3, 3, ridge, ray, 2, 2, "down onto a ridge");
    ray = (cw_ray){.org = {-1, -1, 2}, .dir = {1, 1, -0.5f}, .tmax = INFINITY};
    extreme_expect(3, 3, crest, ray, 2, 2, "down onto diagonals");
    ray = (cw_ray){.org = {1, -1, 1}, .dir = {0, 1, 0}, .tmax = INFINITY};
    extreme_expect(3, 3, ridge, ray, 1, INFINITY, "along a ridge"); /* in the planes of both triangles */
}

/* A ray in the plane of a flat field hits where it enters the field or where its t-range begins. Möller-Trumbore's
 * determinant is zero: it misses. */
static void test_in_plane(void **state) {
    (void)state;
    extreme_item("rays in the plane of flat triangles",
                 "a hit where the field or the range begins; Möller-Trumbore: a miss, since its determinant is 0");
    judge_class_on_all(RAY_IN_PLANE);
    const float flat[9] = {2, 2, 2, 2, 2, 2, 2, 2, 2};
    cw_ray ray = {.org = {-1, 0.5f, 2}, .dir = {1, 0, 0}, .tmax = INFINITY};
    extreme_expect(3, 3, flat, ray, 1, INFINITY, "in the plane along x");
    ray.tmin = 1.5f;
    extreme_expect(3, 3, flat, ray, 1.5f, INFINITY, "in the plane, from inside");
    ray.tmax = 1.5f;
    extreme_expect(3, 3, flat, ray, 1.5f, INFINITY, "in the plane, a point");
    ray = (cw_ray){.org = {-1, -1, 2}, .dir = {1, 1, 0}, .tmax = INFINITY};
    extreme_expect(3, 3, flat, ray, 1, INFINITY, "in the plane along the diagonal");
    ray.org[2] = nextafterf(2, 3);
    extreme_expect(3, 3, flat, ray, INFINITY, INFINITY, "just above the plane");
}

/* Between 1 and 10^-6 degrees to the triangle that is aimed at. The shallower, the more of the answer is rounding; the
 * bound on t grows with 1 / d', and the oracle holds the hits to it. */
static void test_grazing(void **state) {
    (void)state;
    extreme_item("grazing angles from 1 to 10^-6 degrees",
                 "a hit within the bound on t, which grows as the angle shrinks");
    judge_class_on_all(RAY_GRAZING);
    /* Down on a flat field, 10^-6 degrees and 2^-25: exact in float, so the crossing is where it has to be. */
    static test_field f;
    field_make(&f, FIELD_FLAT, 65, 65, 1);
    cw_ray ray = {.org = {-10, 31.5f, 0.375f + 0x1p-20f}, .dir = {1, 0, -0x1p-25f}, .tmax = INFINITY};
    assert_int_equal(extreme_judge(&f, &ray, 1), 1);
}

/* ---- fields ------------------------------------------------------------------------------------------------------ */

static void test_flat(void **state) {
    (void)state;
    extreme_item("flat fields", "the exact answer; all heights the same, so a block is its surface");
    judge_all_on(FIELD_FLAT);
    judge_all_on(FIELD_PLANE);
}

static void test_cliffs(void **state) {
    (void)state;
    extreme_item("cliffs, 10^6 : 1", "the exact answer; the bounds grow with the slope");
    judge_all_on(FIELD_CLIFF);
}

static void test_spikes(void **state) {
    (void)state;
    extreme_item("spikes", "the exact answer; no spike is skipped with the flat land around it");
    judge_all_on(FIELD_SPIKES);
}

static void test_checkerboards(void **state) {
    (void)state;
    extreme_item("checkerboards", "the exact answer; no block is above or below all of a ray");
    judge_all_on(FIELD_CHECKER);
}

/* Heights 1e-30, 1e30, and all between in one field. */
static void test_tiny_and_huge_heights(void **state) {
    (void)state;
    extreme_item("heights from 1e-30 to 1e30", "the exact answer; no product of heights overflows or vanishes");
    judge_all_on(FIELD_TINY);
    judge_all_on(FIELD_HUGE);
    judge_all_on(FIELD_MIXED);
}

/* Heights and rays times 2^60 or 2^-60: nothing rounds differently, so all but z is the same in every bit. */
static void test_scaled_heights_change_nothing(void **state) {
    (void)state;
    extreme_item("heights and rays times 2^60 and 2^-60",
                 "the same bits as without: nothing but z changes, and that exactly");
    static test_field f, scaled;
    static cw_ray rays[RAYS], scaled_rays[RAYS];
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
        /* The 3D grid's voxels depend on the field's proportions. */
        const size_t hits =
            extreme_compare(a, rays, b, scaled_rays, RAYS, true, power < 0 ? "heights / 2^60" : "heights * 2^60");
        check(hits > 0, "no ray hits");
        cw_field_destroy(a);
        cw_field_destroy(b);
    }
}

/* All rays on fields of certain sizes. */
static void judge_sizes(size_t first, size_t last) {
    static const field_shape shapes[] = {FIELD_RANDOM, FIELD_INTEGERS, FIELD_CHECKER, FIELD_HOLES};
    random_state r = {first};
    for (size_t size = first; size <= last; size++)
        for (size_t shape = 0; shape < 4; shape++)
            for (int kind = 0; kind < RAY_CLASSES; kind++) judge_size((ray_class)kind, shapes[shape], size, &r);
}

static void test_smallest_fields(void **state) {
    (void)state;
    extreme_item("fields of 2 x 2 samples", "the exact answer; the one cell is block, pyramid and field");
    judge_sizes(0, 0);
}

static void test_narrow_fields(void **state) {
    (void)state;
    extreme_item("fields one cell wide or long", "the exact answer; blocks stick out on one side");
    judge_sizes(1, 2);
}

static void test_odd_sizes(void **state) {
    (void)state;
    extreme_item("fields neither square nor a power of two", "the exact answer; blocks stick out on both sides");
    judge_sizes(5, 5);
}

/* A triangle with a hole at a vertex does not exist: rays pass through it, and through nothing else. */
static void expect_holes(float no) {
    for (int hole = 0; hole < 4; hole++) {
        float z[4] = {1, 1, 1, 1};
        z[hole] = no;
        const bool in_a = hole != 2, in_b = hole != 1; /* samples (0,0) and (1,1) belong to both */
        const cw_ray a = {.org = {0.75f, 0.25f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
        const cw_ray b = {.org = {0.25f, 0.75f, 3}, .dir = {0, 0, -1}, .tmax = INFINITY};
        extreme_expect(2, 2, z, a, in_a ? INFINITY : 2, in_a ? INFINITY : 2, "a hole under triangle A");
        extreme_expect(2, 2, z, b, in_b ? INFINITY : 2, in_b ? INFINITY : 2, "a hole under triangle B");
    }
    /* Behind a hole there is a surface. */
    const float z[8] = {0, no, 0, 0, 0, no, 0, 0};
    const cw_ray ray = {.org = {0.5f, 0.5f, 1}, .dir = {1, 0, 0}, .tmax = INFINITY};
    extreme_expect(4, 2, z, ray, INFINITY, INFINITY, "above all that there is");
    const cw_ray steep = {.org = {0, 0.5f, 2.5f}, .dir = {1, 0, -1}, .tmax = INFINITY};
    extreme_expect(4, 2, z, steep, 2.5f, 2.5f, "through holes onto what lies behind");
}

static void test_nan_samples(void **state) {
    (void)state;
    extreme_item("NaN samples", "holes: rays pass through the triangles at them, and through nothing else");
    judge_all_on(FIELD_HOLES);
    expect_holes(NAN);
}

/* The same by the oracle, which reads the infinities as they are, and bit for bit. */
static void test_infinite_samples(void **state) {
    (void)state;
    extreme_item("infinite samples of both signs", "holes as NaN is: the same bits, whatever the walk or leaf test");
    expect_holes(INFINITY);
    expect_holes(-INFINITY);
    static test_field f, infinite;
    static cw_ray rays[RAYS];
    random_state r = {17};
    size_t hits = 0;
    for (size_t s = 0; s < FIELD_SIZES; s++) {
        field_make(&f, FIELD_HOLES, field_sizes[s].nx, field_sizes[s].ny, s);
        infinite = f;
        for (size_t k = 0, n = 0; k < f.nx * f.ny; k++)
            if (isnan(f.z[k])) infinite.z[k] = n++ % 2 ? INFINITY : -INFINITY;
        cw_field *a = field_open(&f), *b = field_open_copied(&infinite);
        for (size_t k = 0; k < RAYS; k++) rays[k] = ray_make((ray_class)(k % RAY_CLASSES), &f, &r);
        extreme_judge(&infinite, rays, RAYS);
        hits += extreme_compare(a, rays, b, rays, RAYS, false, "infinite samples instead of NaN");
        cw_field_destroy(a);
        cw_field_destroy(b);
    }
    check(hits > 0, "no ray hits");
}

/* ---- origins and t-ranges ---------------------------------------------------------------------------------------- */

static void test_far_origins(void **state) {
    (void)state;
    extreme_item("origins from 10 to 10^31 cells away",
                 "a hit within the bounds, which do not grow with the distance; exact where the numbers are");
    judge_class_on_all(RAY_OUTSIDE);
    judge_class_on_all(RAY_FAR);
    judge_class_on_all(RAY_AFAR);
    const float z[4] = {0, 0, 0, 0}, far = 1e8f;
    cw_ray ray = {.org = {0.25f, 0.5f, far}, .dir = {0, 0, -1}, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, far, far, "from far above");
    ray = (cw_ray){.org = {-far, 0.5f, far}, .dir = {1, 0, -1}, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, far, far, "from far away");
    const float end = 3e38f, t = (float)((double)end / 0x1p126);
    ray = (cw_ray){.org = {0.25f, 0.5f, end}, .dir = {0, 0, -0x1p126f}, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, t, t, "from the end of the float range, with the longest direction");
    ray.dir[2] = -1;
    extreme_expect(2, 2, z, ray, INFINITY, INFINITY, "a t that is clamped");
}

/* A ray whose t at a place on the surface or near it is up to 1.3 times the limit, on either side of the origin. */
static cw_ray ray_to_the_limit(const test_field *f, random_state *r) {
    const size_t i = random_below(r, f->nx), j = random_below(r, f->ny);
    const double height = (double)f->z[j * f->nx + i], side = (double)(f->nx + f->ny);
    const double at[3] = {(double)i + random_unit(r) - 0.5, (double)j + random_unit(r) - 0.5,
                          isfinite(height) ? height : 0};
    const double away = side * exp2(4 * random_unit(r) - 2), limit = (double)FLT_MAX / 2;
    const double t = (0.05 + 1.25 * random_unit(r)) * (random_below(r, 2) ? limit : -limit);
    cw_ray ray = {.tmin = -INFINITY, .tmax = INFINITY};
    for (int c = 0; c < 3; c++) {
        const double part = random_below(r, 4) == 0 ? 0 : 2 * random_unit(r) - 1;
        ray.org[c] = (float)(at[c] - away * part);
        ray.dir[c] = (float)(away * part / t);
    }
    return ray;
}

static void test_limit_of_t(void **state) {
    (void)state;
    extreme_item("hits at t up to half of the largest float and beyond, before and behind",
                 "the exact answer within that limit; beyond it a miss");
    static test_field f;
    static cw_ray rays[RAYS];
    random_state r = {20261124};
    size_t met = 0;
    const size_t n = test_share(RAYS, 15);
    for (int shape = 0; shape < FIELD_SHAPES; shape++)
        for (size_t s = (size_t)shape % 3; s < FIELD_SIZES; s += 3) {
            field_make(&f, (field_shape)shape, field_sizes[s].nx, field_sizes[s].ny, s);
            for (size_t k = 0; k < n; k++) rays[k] = ray_to_the_limit(&f, &r);
            met += extreme_judge(&f, rays, n);
        }
    check(met > 0, "no ray meets a field");
    /* The ray comes into the field at -1.75 times the limit, and meets the surface at x = 0.8125. */
    const float z[4] = {0, 2, 0, 2}, t = -0.9375f * 0x1p127f;
    const cw_ray ray = {.org = {1.75f, 0.25f, 1.625f}, .dir = {0x1p-127f, 0, 0}, .tmin = -INFINITY, .tmax = INFINITY};
    extreme_expect(2, 2, z, ray, t, t, "a hit far behind, in a field that begins beyond the limit");
}

static void test_near_hits(void **state) {
    (void)state;
    extreme_item("hits 10^-4 to 2 cells from the origin", "t to half a unit in the last place, and u and v");
    judge_class_on_all(RAY_NEAR);
}

static void test_tiny_components(void **state) {
    (void)state;
    extreme_item("direction components 2^-10 to 2^-70 of others", "the exact answer; all walks find the same");
    judge_class_on_all(RAY_TINY);
}

/* Up to CW_HEIGHT_MAX; fields with larger samples are refused. */
static void test_largest_heights(void **state) {
    (void)state;
    extreme_item("samples of 2^100 and -2^100", "the exact answer; larger ones are refused when the field is made");
    static test_field f;
    static cw_ray rays[RAYS];
    const size_t n = test_share(RAYS, 15);
    random_state r = {100};
    for (int kind = 0; kind < 3; kind++) {
        field_make(&f, FIELD_FLAT, 9, 9, 1);
        for (size_t k = 0; k < 81; k++) {
            const bool up = kind == 0 ? k % 2 == 0 : random_below(&r, 2);
            f.z[k] = kind == 2 ? (k == 40 ? CW_HEIGHT_MAX : 0) : up ? CW_HEIGHT_MAX : -CW_HEIGHT_MAX;
        }
        f.low = kind == 2 ? 0 : -CW_HEIGHT_MAX;
        f.high = CW_HEIGHT_MAX;
        for (int c = 0; c < RAY_CLASSES; c++) {
            for (size_t k = 0; k < n; k++) rays[k] = ray_make((ray_class)c, &f, &r);
            extreme_judge(&f, rays, n);
        }
    }
}

/* Centimetre cells at 5 * 10^6 m: the difference to the field's origin is exact, so the rays are the same in field space,
 * bit for bit, and the hits with them. */
static void test_far_user_space(void **state) {
    (void)state;
    extreme_item("cells of 1 cm at 5*10^6 m",
                 "the same bits as at the origin: the translation comes off first, exactly");
    enum { TURNS = 10 };
    static test_field shape;
    static cw_user_ray near_rays[RAYS], far_rays[RAYS];
    static cw_ray a[RAYS], b[RAYS];
    static cw_hit hits[RAYS];
    const double cell = 0.01, away = 5000000;
    field_make(&shape, FIELD_RANDOM, 17, 17, 7);
    cw_field *here = field_open_at(&shape, cell, 0), *there = field_open_at(&shape, cell, away);
    random_state r = {11};
    size_t met = 0;
    for (int turn = 0; turn < TURNS; turn++) {
        for (size_t k = 0; k < RAYS; k++) {
            near_rays[k] = (cw_user_ray){.tmax = (double)INFINITY};
            for (int c = 0; c < 3; c++) { /* multiples of 2^-27 m, so that adding the origin is exact too */
                near_rays[k].org[c] = ldexp(floor(random_between(&r, -0x1p18, 0x1p20) * (c < 2 ? 16 : 2)), -27);
                near_rays[k].dir[c] = random_between(&r, -1, 1);
            }
            far_rays[k] = near_rays[k];
            for (int c = 0; c < 2; c++) far_rays[k].org[c] += away;
        }
        cw_rays_to_field(here, NULL, near_rays, RAYS, a);
        cw_rays_to_field(there, NULL, far_rays, RAYS, b);
        check(memcmp(a, b, sizeof a) == 0, "other rays in field space");
        extreme_compare(here, a, there, b, RAYS, false, "a far origin");
        check_status(cw_closest(there, NULL, b, RAYS, hits), CW_OK);
        for (size_t k = 0; k < RAYS; k++) {
            if (hits[k].i < 0) continue;
            met++;
            double p[3], q[3];
            cw_hit_points(here, NULL, &hits[k], 1, p);
            cw_hit_points(there, NULL, &hits[k], 1, q);
            for (int c = 0; c < 3; c++) {
                check(fabs(q[c] - (c < 2 ? away : 0) - p[c]) < 2e-9, "the point is elsewhere far from the origin");
                const double on_ray = near_rays[k].org[c] + (double)hits[k].t * near_rays[k].dir[c];
                check(fabs(on_ray - p[c]) < 1e-4 * cell * 16, "a hit off the ray by %g", on_ray - p[c]);
            }
        }
    }
    check(met > RAYS * TURNS / 20, "only %zu hits", met);
    cw_field_destroy(here);
    cw_field_destroy(there);
}

static void test_not_finite(void **state) {
    (void)state;
    extreme_item("NaN and infinite rays and t-ranges",
                 "a miss with a NaN anywhere or an infinite origin or direction; infinite t-ranges are ranges");
    judge_class_on_all(RAY_NOT_FINITE);
    const float z[4] = {1, 1, 1, 1};
    const cw_ray good = {.org = {0.25f, 0.5f, 3}, .tmin = 0, .dir = {0.125f, -0.125f, -1}, .tmax = 100};
    extreme_expect(2, 2, z, good, 2, 2, "an ordinary ray");
    for (size_t part = 0; part < 8; part++)
        for (int kind = 0; kind < 3; kind++) {
            const float odd[] = {NAN, INFINITY, -INFINITY};
            float parts[8];
            memcpy(parts, &good, sizeof parts);
            parts[part] = odd[kind];
            cw_ray ray;
            memcpy(&ray, parts, sizeof ray);
            const bool hits = (part == 3 && kind == 2) || (part == 7 && kind == 1); /* tmin = -inf, tmax = inf */
            extreme_expect(2, 2, z, ray, hits ? 2 : INFINITY, hits ? 2 : INFINITY, "one number that is not finite");
        }
}

/* A t-range is closed: a hit at its very ends counts, one float beyond does not. */
static void test_ranges_that_end_on_the_surface(void **state) {
    (void)state;
    extreme_item("t-ranges that begin or end exactly on the surface",
                 "closed: a hit at either end, a miss one float beyond");
    judge_class_on_all(RAY_RANGE);
    judge_class_on_all(RAY_LATTICE);
    const float z[4] = {1, 1, 1, 1}, up = nextafterf(2, 3), below = nextafterf(2, 1);
    const float ends[][2] = {{2, 2}, {2, 9}, {0, 2}, {-1, up}, {below, 5}, {up, 9}, {0, below}, {3, 1}};
    for (int k = 0; k < 8; k++) {
        const float t = k < 5 ? 2 : INFINITY;
        cw_ray ray = {.org = {0.75f, 0.25f, 3}, .dir = {0, 0, -1}, .tmin = ends[k][0], .tmax = ends[k][1]};
        extreme_expect(2, 2, z, ray, t, t, "vertical");
        ray = (cw_ray){.org = {-1.5f, 0.5f, 3}, .dir = {1, 0, -1}, .tmin = ends[k][0], .tmax = ends[k][1]};
        extreme_expect(2, 2, z, ray, t, t, "slanted");
    }
}

/* Whether the caller flushes denormals or not, each path gives the same bits. */
static void test_flush_to_zero(void **state) {
    (void)state;
    if (FP_MODES == 0) skip();
    extreme_item("FTZ and DAZ on", "the same bits as with both off, and the caller's flags as they were");
    static test_field f;
    static cw_ray rays[RAYS];
    static cw_hit plain[RAYS], flushed[RAYS];
    static uint8_t occluded[RAYS];
    random_state r = {16};
    const uint64_t before = fp_register(), flush = fp_register_mode(FP_FLUSHES);
    for (int shape = FIELD_TINY; shape <= FIELD_HOLES; shape++) {
        field_make(&f, (field_shape)shape, 17, 17, 16);
        for (size_t k = 0; k < RAYS; k++)
            rays[k] = ray_make(k % 2 ? RAY_ZEROS : (ray_class)(k / 2 % RAY_CLASSES), &f, &r);
        cw_field *field = field_open(&f);
        for (size_t p = 0; p < extreme_path_count; p++) {
            const path *q = &extreme_paths[p];
            check_status(cw_closest(field, &q->query, rays, RAYS, plain), CW_OK);
            fp_register_set(flush);
            const cw_status closest = cw_closest(field, &q->query, rays, RAYS, flushed);
            const cw_status any = cw_occluded(field, &q->query, rays, RAYS, occluded);
            const uint64_t after = fp_register();
            fp_register_set(before);
            check_status(closest, CW_OK);
            check_status(any, CW_OK);
            check(after == flush, "%s: the caller's environment became %#llx", q->name, (unsigned long long)after);
            for (size_t k = 0; k < RAYS; k++)
                check(hit_same(&plain[k], &flushed[k]) && occluded[k] == (plain[k].i >= 0),
                      "%s: other answers with FTZ and DAZ", q->name);
            extreme_count(p, RAYS);
        }
        cw_field_destroy(field);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axis_parallel),
        cmocka_unit_test(test_vertical),
        cmocka_unit_test(test_zero_and_denormal_components),
        cmocka_unit_test(test_long_directions),
        cmocka_unit_test(test_through_vertices),
        cmocka_unit_test(test_through_edges),
        cmocka_unit_test(test_along_edges),
        cmocka_unit_test(test_in_plane),
        cmocka_unit_test(test_grazing),
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_cliffs),
        cmocka_unit_test(test_spikes),
        cmocka_unit_test(test_checkerboards),
        cmocka_unit_test(test_tiny_and_huge_heights),
        cmocka_unit_test(test_scaled_heights_change_nothing),
        cmocka_unit_test(test_far_origins),
        cmocka_unit_test(test_limit_of_t),
        cmocka_unit_test(test_near_hits),
        cmocka_unit_test(test_tiny_components),
        cmocka_unit_test(test_largest_heights),
        cmocka_unit_test(test_far_user_space),
        cmocka_unit_test(test_smallest_fields),
        cmocka_unit_test(test_narrow_fields),
        cmocka_unit_test(test_odd_sizes),
        cmocka_unit_test(test_nan_samples),
        cmocka_unit_test(test_infinite_samples),
        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_ranges_that_end_on_the_surface),
        cmocka_unit_test(test_flush_to_zero),
    };
    return cmocka_run_group_tests_name("extremes", tests, extremes_begin, extremes_end);
}
