/* SPDX-License-Identifier: Apache-2.0 */
/* Named extremes, each a row, for every kernel that this machine runs and every leaf test. */

#include "exact.h"

#include <float.h>
#include <math.h>

enum { RAYS = 200 };
static test_field f;
static cw_ray rays[RAYS];

/* ---- single rays with known answers ------------------------------------------------------------------------------ */

static const float level[9] = {0}, one[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1}, two[9] = {2, 2, 2, 2, 2, 2, 2, 2, 2};
static const float ridge[9] = {0, 1, 0, 0, 1, 0, 0, 1, 0}, crest[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                   slope[4] = {0, 2, 0, 2};

#define MISS    INFINITY
#define LONGEST 0x1p126f
#define BEYOND  0x1.000002p126f
#define END_T   (3e38f / LONGEST)
#define BACK    -0x1.ep126f /* 0.9375 of the limit of t */

static const exact_case zeros[] = {
    {"no direction", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {0, 0, 0}, INFINITY}, MISS, MISS},
    {"as good as none", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {0, 0, -0x1p-128f}, INFINITY}, MISS, MISS},
    {"-0, a denormal", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {-0.0f, 0x1p-149f, -1}, INFINITY}, 1, 1},
    {"counts as zero", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {-0.0f, -0x1p-128f, -1}, INFINITY}, 1, 1},
};

/* Up to 2^126, beyond which a reciprocal is denormal and a difference of two components may overflow. */
static const exact_case lengths[] = {
    {"the longest", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {0, 0, -LONGEST}, INFINITY}, 0x1p-126f, 0x1p-126f},
    {"too long in z", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {0, 0, -BEYOND}, INFINITY}, MISS, MISS},
    {"too long in x", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {BEYOND, 0, -1}, INFINITY}, MISS, MISS},
    {"too long in y", 2, 2, level, {{0.25f, 0.5f, 1}, -INFINITY, {0, -FLT_MAX, -1}, INFINITY}, MISS, MISS},
};

/* A ray exactly above an edge is over both of its triangles; one within it touches both all along, in both planes. */
static const exact_case edges[] = {
    {"down onto a ridge", 3, 3, ridge, {{1, -1, 2}, 0, {0, 1, -0.5f}, INFINITY}, 2, 2},
    {"down onto diagonals", 3, 3, crest, {{-1, -1, 2}, 0, {1, 1, -0.5f}, INFINITY}, 2, 2},
    {"along a ridge", 3, 3, ridge, {{1, -1, 1}, 0, {0, 1, 0}, INFINITY}, 1, MISS},
};

/* A ray in the plane of a flat field hits where it enters the field or where its t-range begins. Möller-Trumbore's
 * determinant is zero: it misses. */
static const exact_case planes[] = {
    {"in the plane along x", 3, 3, two, {{-1, 0.5f, 2}, 0, {1, 0, 0}, INFINITY}, 1, MISS},
    {"in the plane, from inside", 3, 3, two, {{-1, 0.5f, 2}, 1.5f, {1, 0, 0}, INFINITY}, 1.5f, MISS},
    {"in the plane, a point", 3, 3, two, {{-1, 0.5f, 2}, 1.5f, {1, 0, 0}, 1.5f}, 1.5f, MISS},
    {"in the plane along the diagonal", 3, 3, two, {{-1, -1, 2}, 0, {1, 1, 0}, INFINITY}, 1, MISS},
    {"just above the plane", 3, 3, two, {{-1, -1, 0x1.000002p1f}, 0, {1, 1, 0}, INFINITY}, MISS, MISS},
};

/* FAST FOOT is a float and 1: from 2^45 cells away a range begins or ends at y = 1, where the ground begins to rise to the
 * ray. The t by which the ray is moved, in double, is off by 2^-9 cells. */
static const float bank[] = {0, 0, 0, 0, 1, 1};
#define FOOT 0x300001p23f
#define FAST 0xd00001p-23f
#define FROM -0x270001p24f
static const exact_case far[] = {
    {"begins at the foot", 2, 3, bank, {{0.5f, FROM, 0x1p-10f}, FOOT, {0, FAST, 0}, INFINITY}, FOOT, FOOT},
    {"ends at the foot", 2, 3, bank, {{0.5f, FROM, 0x1p-10f}, 0, {0, FAST, 0}, FOOT}, MISS, MISS},
    {"from far above", 2, 2, level, {{0.25f, 0.5f, 1e8f}, 0, {0, 0, -1}, INFINITY}, 1e8f, 1e8f},
    {"from far away", 2, 2, level, {{-1e8f, 0.5f, 1e8f}, 0, {1, 0, -1}, INFINITY}, 1e8f, 1e8f},
    {"from the end", 2, 2, level, {{0.25f, 0.5f, 3e38f}, 0, {0, 0, -LONGEST}, INFINITY}, END_T, END_T},
    {"a t that is clamped", 2, 2, level, {{0.25f, 0.5f, 3e38f}, 0, {0, 0, -1}, INFINITY}, MISS, MISS},
    /* The ray comes into the field at -1.75 times the limit of t, and meets the surface at x = 0.8125. */
    {"far behind", 2, 2, slope, {{1.75f, 0.25f, 1.625f}, -INFINITY, {0x1p-127f, 0, 0}, INFINITY}, BACK, BACK},
};

/* A triangle with a hole at a vertex is absent: rays pass there and nowhere else. Samples (0,0), (1,1) are in both. */
#define DOWN_A                                                                                                         \
    { {0.75f, 0.25f, 3}, 0, {0, 0, -1}, INFINITY }
#define DOWN_B                                                                                                         \
    { {0.25f, 0.75f, 3}, 0, {0, 0, -1}, INFINITY }
static const float no00[4] = {NAN, 1, 1, 1}, no10[4] = {1, NAN, 1, 1}, no01[4] = {1, 1, NAN, 1},
                   no11[4] = {1, 1, 1, NAN}, gap[8] = {0, NAN, 0, 0, 0, NAN, 0, 0};
static const exact_case holes[] = {
    {"(0, 0) under A", 2, 2, no00, DOWN_A, MISS, MISS},
    {"(0, 0) under B", 2, 2, no00, DOWN_B, MISS, MISS},
    {"(1, 0) under A", 2, 2, no10, DOWN_A, MISS, MISS},
    {"(1, 0) beside B", 2, 2, no10, DOWN_B, 2, 2},
    {"(0, 1) beside A", 2, 2, no01, DOWN_A, 2, 2},
    {"(0, 1) under B", 2, 2, no01, DOWN_B, MISS, MISS},
    {"(1, 1) under A", 2, 2, no11, DOWN_A, MISS, MISS},
    {"(1, 1) under B", 2, 2, no11, DOWN_B, MISS, MISS},
    {"above all that there is", 4, 2, gap, {{0.5f, 0.5f, 1}, 0, {1, 0, 0}, INFINITY}, MISS, MISS},
    {"through holes onto what lies behind", 4, 2, gap, {{0, 0.5f, 2.5f}, 0, {1, 0, -1}, INFINITY}, 2.5f, 2.5f},
};

/* A t-range is closed: a hit at its very ends counts, one float beyond does not. */
static void test_ends(const exact_row *row) {
    const float up = nextafterf(2, 3), below = nextafterf(2, 1);
    const float ends[][2] = {{2, 2}, {2, 9}, {0, 2}, {-1, up}, {below, 5}, {up, 9}, {0, below}, {3, 1}};
    for (int k = 0; k < 8; k++) {
        const float t = k < 5 ? 2 : INFINITY;
        exact_expect(
            &(exact_case){"vertical", 2, 2, one, {{0.75f, 0.25f, 3}, ends[k][0], {0, 0, -1}, ends[k][1]}, t, t});
        exact_expect(&(exact_case){"slanted", 2, 2, one, {{-1.5f, 0.5f, 3}, ends[k][0], {1, 0, -1}, ends[k][1]}, t, t});
    }
}

/* The same where heights, and rays in z, are larger and smaller. */
static void test_scaled(const exact_row *row) {
    for (int exponent = -60; exponent <= 60; exponent += 40)
        for (size_t k = 0; k < sizeof edges / sizeof edges[0]; k++) {
            exact_case c = edges[k];
            float z[9];
            for (size_t m = 0; m < c.nx * c.ny; m++) z[m] = ldexpf(c.z[m], exponent);
            c.z = z;
            c.ray.org[2] = ldexpf(c.ray.org[2], exponent);
            c.ray.dir[2] = ldexpf(c.ray.dir[2], exponent);
            exact_expect(&c);
        }
}

/* ---- many rays --------------------------------------------------------------------------------------------------- */

static void judge(size_t n, exact_counts *counts) { exact_judge(&f, rays, n, EVERY_PATH, NULL, counts); }

/* A ray whose t at a place on the surface or near it is up to 1.3 times the limit, on either side of the origin. */
static cw_ray ray_to_the_limit(random_state *r) {
    const size_t i = random_below(r, f.nx), j = random_below(r, f.ny);
    const double height = (double)f.z[j * f.nx + i], side = (double)(f.nx + f.ny);
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

static void test_limit_of_t(const exact_row *row) {
    random_state r = {20261124};
    exact_counts counts = {0};
    const size_t n = test_share(RAYS, 15);
    for (int shape = 0; shape < FIELD_SHAPES; shape++)
        for (size_t s = (size_t)shape % 3; s < FIELD_SIZES; s += 3) {
            field_make(&f, (field_shape)shape, field_sizes[s].nx, field_sizes[s].ny, s);
            for (size_t k = 0; k < n; k++) rays[k] = ray_to_the_limit(&r);
            judge(n, &counts);
        }
    check(counts.hits > 0, "no ray meets a field");
}

/* Up to CW_HEIGHT_MAX; fields with larger samples are refused. */
static void test_largest_heights(const exact_row *row) {
    const size_t n = test_share(RAYS, 15);
    random_state r = {100};
    exact_counts counts = {0};
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
            judge(n, &counts);
        }
    }
}

#define TABLE(list) .cases = list, .case_count = sizeof list / sizeof list[0]
const exact_row exact_extremes[] = {
    {"extreme: zero, negative-zero and denormal components",
     "up to 2^-128 one counts as zero: its reciprocal is no float", TABLE(zeros)},
    {"extreme: directions of length 2^126 and beyond", "beyond it a component counts as infinite", TABLE(lengths)},
    {"extreme: along edges", "a hit in one of the two triangles; a touch is a hit", TABLE(edges)},
    {"extreme: along edges at heights of 2^-60 to 2^60", "the same", test_scaled, .number = 0},
    {"extreme: in the plane of flat triangles",
     "a hit where field or range begins; Möller-Trumbore: a miss, its determinant is 0", TABLE(planes)},
    {"extreme: from the end of the float range", "exact where the numbers are", TABLE(far)},
    {"extreme: ranges that begin or end exactly on the surface", "a hit at either end, a miss one float beyond",
     test_ends, .number = 0},
    {"extreme: NaN samples", "holes: rays pass through the triangles at them, and through nothing else", TABLE(holes)},
    {"extreme: t up to half of the largest float and beyond", "the exact answer within that limit; beyond it a miss",
     test_limit_of_t, .number = 0},
    {"extreme: samples of 2^100 and -2^100", "the exact answer; larger ones are refused", test_largest_heights,
     .number = 0},
};
const size_t exact_extremes_count = sizeof exact_extremes / sizeof exact_extremes[0];
