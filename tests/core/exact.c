/* SPDX-License-Identifier: Apache-2.0 */
/* Answers judged by the exact oracle: no leak, no phantom, no wrong surface. exact PATTERN…
 * runs the rows of the tables whose names match:
 *  - "rays …", a row a class of rays: every kernel and leaf test on fields of every shape and size.
 *  - "extreme …", named extremes (exact_extremes.c).
 *  - "all …": every field of 2 × 2, 2 × 3 and 3 × 2 samples with heights 0, 1, 2 or a hole, and of 3 × 3 with heights
 *    0, 1, 2, against every ray from a lattice of origins and directions: all the ways in which rays and small fields
 *    can touch. Whole numbers and halves make most of it exact in float, so the watertight kernels have to name the
 *    exact answer but for few ties. The test takes all of 2 × 2 and a share of the rest.
 *
 * CELLWALK_TEST_ROUNDS = n takes n times as many fields; 1001 takes all small ones. Lines of JSON are for
 * papers/robustness.md (support/counts.cmake). */

#include "exact.h"

#include "cellwalk_expert.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- judging -------------------------------------------------------------------------------------------------- */

enum { AT_A_TIME = 1024 };

/* Why an answer is what is expected. */
typedef enum outcome {
    AS_EXPECTED,
    SLIPPED,  /* Möller-Trumbore: missed a triangle, or went on to the next surface, within rounding of an edge */
    PARALLEL, /* Möller-Trumbore: off the triangle, which is so nearly parallel that rounding decides */
    OUTCOMES
} outcome;

static size_t outcomes[PATHS_MAX][OUTCOMES]; /* of the row that runs */

/* To stdout: all that is needed to repeat and to understand a verdict. */
static void explain(const test_field *f, const cw_ray *ray, const cw_hit *hit, const oracle_truth *truth,
                    const judgement *j) {
    printf("%s, |d|/E %g, %g off the triangle (%g), t off by %g (%g), u and v by %g (%g)\n", verdict_name(j->verdict),
           j->at.residual, j->at.apart, j->blur, j->t_error, j->t_bound, j->place_error, j->place_bound);
    field_print(f);
    ray_print(ray);
    hit_print("kernel", hit);
    printf("truth: %s, t %a, %u triangles, first (%d, %d) %u%s", truth->hit ? "hit" : "miss", truth->t, truth->at,
           (int)truth->triangle[0].i, (int)truth->triangle[0].j, (unsigned)truth->triangle[0].triangle,
           truth->coplanar ? ", coplanar" : "");
    if (truth->passes)
        printf(", has passed at t %a, through a triangle %g from its nearest edge (%g)", truth->pass_t,
               truth->pass_edge, truth->pass_blur);
    printf("\n");
}

static bool as_expected(const path *p, const oracle_truth *truth, const judgement *j, outcome *o) {
    *o = AS_EXPECTED;
    if (p->leaf == CW_LEAF_WATERTIGHT) return j->verdict <= VERDICT_TIE && digits_hold(j);
    if (j->verdict <= VERDICT_TIE) return true;
    *o = j->verdict == VERDICT_PHANTOM ? PARALLEL : SLIPPED;
    return j->verdict == VERDICT_PHANTOM ? j->at.apart <= j->blur : truth->pass_edge <= truth->pass_blur;
}

/* Brute force is for small fields, and so is a grid of 64 voxels an axis where all heights but a few are the same. */
static bool takes_part(const path *p, const test_field *f, exact_choice choice) {
    if (choice == EVERY_PATH) return p->strict || f->nx * f->ny <= 400;
    return p->leaf == CW_LEAF_WATERTIGHT && (choice == WATERTIGHT_PATHS || strcmp(p->name, "cell") == 0);
}

static void trace(const cw_field *field, const path *p, const cw_ray *rays, size_t n, cw_hit *hits) {
    static uint8_t occluded[AT_A_TIME];
    memset(hits, 0xff, n * sizeof *hits); /* no hit of any path */
    check_status(cw_closest(field, &p->query, rays, n, hits), CW_OK);
    check_status(cw_occluded(field, &p->query, rays, n, occluded), CW_OK);
    for (size_t k = 0; k < n; k++) {
        if (occluded[k] == (hits[k].i >= 0)) continue;
        ray_print(&rays[k]);
        check(false, "%s with %s: any hit says %d", p->name, cw_leaf_name(p->leaf), occluded[k]);
    }
}

/* A path that takes part, gave the same answer to ray k, and of which no less is expected; p if none is before it. */
static size_t judged_before(cw_hit hits[PATHS_MAX][AT_A_TIME], const bool part[PATHS_MAX], size_t p, size_t k) {
    size_t first = 0;
    while (first < p && !(part[first] && paths[first].leaf == paths[p].leaf && hit_same(&hits[first][k], &hits[p][k])))
        first++;
    return first;
}

void exact_judge(const test_field *f, const cw_ray *rays, size_t n, exact_choice choice, tie_rule *tie,
                 exact_counts *counts) {
    static cw_hit hits[PATHS_MAX][AT_A_TIME];
    cw_field *field = field_open(f);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    assert_non_null(o);
    bool part[PATHS_MAX];
    for (size_t p = 0; p < path_count; p++) part[p] = takes_part(&paths[p], f, choice);
    for (size_t first = 0; first < n; first += AT_A_TIME) {
        const size_t some = n - first < AT_A_TIME ? n - first : AT_A_TIME;
        for (size_t p = 0; p < path_count; p++)
            if (part[p]) trace(field, &paths[p], rays + first, some, hits[p]);
        for (size_t k = 0; k < some; k++) {
            outcome found[PATHS_MAX] = {AS_EXPECTED};
            const cw_ray *ray = &rays[first + k];
            const oracle_truth *truth = oracle_trace(o, ray);
            for (size_t p = 0; p < path_count; p++) {
                const path *q = &paths[p];
                if (!part[p]) continue;
                const size_t before = judged_before(hits, part, p, k);
                found[p] = found[before];
                if (before == p) {
                    const judgement j = oracle_judge(o, &hits[p][k]);
                    const bool good = as_expected(q, truth, &j, &found[p]) &&
                                      (j.verdict != VERDICT_TIE || tie == NULL || tie(ray, truth));
                    if (!good) explain(f, ray, &hits[p][k], truth, &j);
                    check(good, "%s with %s: %s", q->name, cw_leaf_name(q->leaf), verdict_name(j.verdict));
                    if (q->leaf == CW_LEAF_WATERTIGHT) {
                        counts->rays++;
                        counts->hits += hits[p][k].i >= 0;
                        counts->passes += truth->passes;
                        counts->verdict[j.verdict]++;
                    }
                } else {
                    counts->answers++;
                }
                outcomes[p][found[p]]++;
            }
        }
    }
    oracle_destroy(o);
    cw_field_destroy(field);
}

void exact_expect(const exact_case *c) {
    static test_field f;
    f.shape = FIELD_INTEGERS;
    f.nx = c->nx;
    f.ny = c->ny;
    memcpy(f.z, c->z, f.nx * f.ny * sizeof *f.z);
    cw_field *field = field_open(&f);
    for (size_t p = 0; p < path_count; p++) {
        const path *q = &paths[p];
        const float wanted = q->leaf == CW_LEAF_WATERTIGHT ? c->watertight : c->moller_trumbore;
        const cw_hit miss = {.t = INFINITY, .i = -1, .j = -1};
        cw_hit hit;
        trace(field, q, &c->ray, 1, &hit);
        check(hit.t == wanted && (hit.i >= 0) == (wanted < INFINITY), "%s with %s, %s: t = %g instead of %g", q->name,
              cw_leaf_name(q->leaf), c->what, (double)hit.t, (double)wanted);
        check(wanted < INFINITY || hit_same(&hit, &miss), "%s, %s: a miss with odd fields", q->name, c->what);
        outcomes[p][AS_EXPECTED]++;
    }
    cw_field_destroy(field);
}

/* ---- classes of rays --------------------------------------------------------------------------------------------- */

static void test_class(const exact_row *row) {
    enum { RAYS = 300, MORE = 4, SIZES = FIELD_SIZES + MORE, FIELDS = SIZES * FIELD_ALL_SHAPES };
    static const field_size more[MORE] = {{3, 9}, {12, 2}, {9, 9}, {17, 13}};
    static test_field shape;
    static cw_ray rays[RAYS];
    const ray_class kind = (ray_class)row->number;
    const size_t n = test_share(RAYS, 10);
    exact_counts counts = {0};
    for (size_t k = 0; k < test_rounds() * FIELDS; k++) {
        if (!test_takes(k + k / SIZES, 8)) continue;
        const field_size size = k % SIZES < MORE ? more[k % SIZES] : field_sizes[k % SIZES - MORE];
        random_state r = {(uint64_t)kind + RAY_CLASSES * k};
        field_make(&shape, (field_shape)(k % FIELDS / SIZES), size.nx, size.ny, 77 + k / FIELDS);
        for (size_t m = 0; m < n; m++) rays[m] = ray_make(kind, &shape, &r);
        exact_judge(&shape, rays, n, shape.shape < FIELD_SHAPES ? EVERY_PATH : WATERTIGHT_PATHS, NULL, &counts);
    }
    const bool aims = kind != RAY_IN_PLANE && kind != RAY_NOT_FINITE && kind != RAY_LATTICE && kind != RAY_AFAR;
    check(!aims || counts.passes > counts.rays / 10, "too few rays pass for the test to mean anything");
}

/* ---- all small fields -------------------------------------------------------------------------------------------- */

/* Origins from -1/2 to half a cell beyond the field in steps of a half, heights from -1 to 3; directions of -2 … 2. */
static cw_ray *make_lattice(field_size size, size_t *n) {
    const size_t along_x = 2 * size.nx + 1, along_y = 2 * size.ny + 1, places = along_x * along_y * 5;
    cw_ray *rays = malloc(places * 124 * 2 * sizeof *rays);
    assert_non_null(rays);
    *n = 0;
    for (size_t p = 0; p < places; p++)
        for (int d = 0; d < 125; d++) {
            if (d == 62) continue; /* no direction */
            const float x = 0.5f * (float)(p % along_x) - 0.5f, y = 0.5f * (float)(p / along_x % along_y) - 0.5f;
            cw_ray ray = {.org = {x, y, (float)(p / along_x / along_y) - 1},
                          .dir = {(float)(d % 5 - 2), (float)(d / 5 % 5 - 2), (float)(d / 25 - 2)},
                          .tmax = INFINITY};
            rays[(*n)++] = ray;
            ray.tmin = -0.5f;
            ray.tmax = 0.5f;
            rays[(*n)++] = ray;
        }
    return rays;
}

static bool whole(double x) { return fabs(x - rint(x)) < 1e-9; }

static size_t rims, thirds; /* of ties, by their excuse */

/* Ties are allowed for a reason: the exact hit lies on an edge or vertex that holes or the outside share
 * (papers/numerics.md), or dx - dy is 3 or -3, so a diagonal is crossed at a t that is no float. */
static bool excused_tie(const cw_ray *ray, const oracle_truth *truth) {
    const double x = (double)ray->org[0] + truth->t * (double)ray->dir[0];
    const double y = (double)ray->org[1] + truth->t * (double)ray->dir[1];
    const unsigned all = whole(x) && whole(y) ? 6 : whole(x) || whole(y) || whole(x - y) ? 2 : 1;
    const bool rim = truth->hit && truth->at < all, third = fabsf(ray->dir[0] - ray->dir[1]) == 3;
    rims += rim;
    thirds += !rim && third;
    return rim || third;
}

static const struct {
    field_size size;
    size_t heights; /* how many of them */
    size_t one_in;  /* fields, if CELLWALK_TEST_ROUNDS = 1. CELLWALK_TEST_DIVIDE is heeded too */
} small[] = {{{2, 2}, 4, 1}, {{2, 3}, 4, 421}, {{3, 2}, 4, 421}, {{3, 3}, 3, 1999}};

static void test_small_fields(const exact_row *row) {
    static const float heights[] = {0, 1, 2, NAN};
    static test_field f = {.shape = FIELD_INTEGERS};
    const field_size size = small[row->number].size;
    const size_t base = small[row->number].heights, every = small[row->number].one_in * test_divisor(),
                 rounds = test_rounds();
    size_t step = rounds < every ? every / rounds : 1;
    while (step % 2 == 0 || step % 3 == 0) step++; /* or all fields taken would share samples, which may be holes */
    exact_counts counts = {0};
    size_t fields = 0, all_fields = 1, n;
    for (size_t k = 0; k < size.nx * size.ny; k++) all_fields *= base;
    cw_ray *rays = make_lattice(size, &n);
    rims = thirds = 0;
    f.nx = size.nx;
    f.ny = size.ny;
    for (size_t number = test_turn() % (step < all_fields ? step : all_fields); number < all_fields;
         number += step, fields++) {
        size_t rest = number;
        for (size_t k = 0; k < size.nx * size.ny; k++, rest /= base) f.z[k] = heights[rest % base];
        const bool all = fields < 256 || fields % 16 == 0; /* they take as long as the oracle */
        exact_judge(&f, rays, n, all ? WATERTIGHT_PATHS : CELL_ALONE, excused_tie, &counts);
    }
    free(rays);
    const size_t *v = counts.verdict;
    printf("{\"kind\": \"exhaustive\", \"field\": \"%zu x %zu\", \"heights\": \"%s\", \"fields\": %zu, \"all_fields\": "
           "%zu, "
           "\"rays\": %zu, \"hits\": %zu, \"pass\": %zu, \"right\": %zu, \"tie\": %zu, \"rims\": %zu, \"thirds\": %zu, "
           "\"leak\": %zu, \"phantom\": %zu, \"wrong_surface\": %zu, \"same_bits\": %zu}\n",
           size.nx, size.ny, base == 4 ? "0, 1, 2, hole" : "0, 1, 2", fields, all_fields, counts.rays, counts.hits,
           counts.passes, v[VERDICT_RIGHT], v[VERDICT_TIE], rims, thirds, v[VERDICT_LEAK], v[VERDICT_PHANTOM],
           v[VERDICT_WRONG_SURFACE], counts.answers);
    check(counts.hits > counts.rays / 50 || fields < 8, "too few hits for the test to mean anything");
    check(counts.answers > counts.rays / fields || fields < 8, "no kernel was compared with the one that was judged");
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define CLASS(kind, name, expected)                                                                                    \
    { name, expected, test_class, .number = kind }
static const exact_row table[] = {
    CLASS(RAY_RANDOM, "rays random", "through the field's box: the exact answer"),
    CLASS(RAY_VERTEX, "rays through vertices", "a hit: all six triangles see the same sign"),
    CLASS(RAY_EDGE, "rays through cell borders", "a hit: both triangles see the same sign"),
    CLASS(RAY_DIAGONAL, "rays through diagonals", "a hit: both triangles see the same sign"),
    CLASS(RAY_ALONG, "rays along edges", "a hit in one of the two triangles, the first on the walk; a touch is a hit"),
    CLASS(RAY_AXIS, "rays parallel to an axis", "the exact answer; a crossing that never comes decides nothing"),
    CLASS(RAY_VERTICAL, "rays straight up and down",
          "the exact answer, on samples, edges and diagonals too: no crossing is rounded"),
    CLASS(RAY_GRAZING, "rays at 1 to 10^-6 degrees", "a hit within the bound on t, which grows as the angle shrinks"),
    CLASS(RAY_IN_PLANE, "rays within a triangle's plane",
          "a hit where the field or the range begins; Möller-Trumbore: a miss"),
    CLASS(RAY_OUTSIDE, "rays from up to 1000 cells", "a hit within the bounds, which do not grow with the distance"),
    CLASS(RAY_FAR, "rays from up to 10^8 cells", "a hit within the bounds, which do not grow with the distance"),
    CLASS(RAY_AFAR, "rays from 10^25 times the heights", "a hit within the bounds"),
    CLASS(RAY_NEAR, "rays from 10^-4 to 2 cells", "t to half a unit in the last place, and u and v"),
    CLASS(RAY_TINY, "rays with components of 2^-70 of others", "the exact answer; all walks find the same"),
    CLASS(RAY_ZEROS, "rays with zero and denormal components", "up to 2^-128 a component counts as zero"),
    CLASS(RAY_SCALED, "rays of any length", "beyond 2^126 a component counts as infinite"),
    CLASS(RAY_RANGE, "rays that begin or end on the surface", "closed ranges: a hit at either end"),
    CLASS(RAY_BEHIND, "rays with ranges from far behind", "the exact answer"),
    CLASS(RAY_MOVED, "rays that are moved", "the exact answer, with the range moved along"),
    CLASS(RAY_LATTICE, "rays of halves and whole numbers", "the exact answer; ties are exact"),
    CLASS(RAY_NOT_FINITE, "rays with NaN or infinity", "a miss with a NaN anywhere or an infinite origin or direction"),
    {"all 2 x 2", NULL, test_small_fields, .number = 0},
    {"all 2 x 3", NULL, test_small_fields, .number = 1},
    {"all 3 x 2", NULL, test_small_fields, .number = 2},
    {"all 3 x 3", NULL, test_small_fields, .number = 3},
};

/* Names and texts hold nothing that JSON would have to escape. */
static void print_counts(const exact_row *row) {
    for (size_t p = 0; p < path_count && row->expected; p++) {
        const size_t *c = outcomes[p], asked = c[AS_EXPECTED] + c[SLIPPED] + c[PARALLEL];
        printf("{\"kind\": \"extreme\", \"item\": \"%s\", \"expected\": \"%s\", \"kernel\": \"%s\", \"leaf\": \"%s\", "
               "\"asked\": %zu, \"as_expected\": %zu, \"slipped\": %zu, \"parallel\": %zu}\n",
               row->name, row->expected, paths[p].name, cw_leaf_name(paths[p].leaf), asked, c[AS_EXPECTED], c[SLIPPED],
               c[PARALLEL]);
    }
    memset(outcomes, 0, sizeof outcomes);
}

static void test_row(void **state) {
    const exact_row *row = *state;
    for (int k = 0; k < row->case_count; k++) exact_expect(&row->cases[k]);
    if (row->test) row->test(row);
    print_counts(row);
}

int main(int argc, char **argv) {
    enum { ROWS = sizeof table / sizeof table[0], ROWS_MAX = 64 };
    struct CMUnitTest tests[ROWS_MAX];
    const size_t n = ROWS + exact_extremes_count;
    for (size_t k = 0; k < n; k++) {
        const exact_row *row = k < ROWS ? &table[k] : &exact_extremes[k - ROWS];
        tests[k] = (struct CMUnitTest){.name = row->name, .test_func = test_row, .initial_state = (void *)row};
    }
    return paths_run("exact", tests, n, argc, argv);
}
