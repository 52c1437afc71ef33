/* SPDX-License-Identifier: Apache-2.0 */
/* Every field of 2 × 2, 2 × 3 and 3 × 2 samples with heights 0, 1, 2 or a hole, and of 3 × 3 with heights 0, 1, 2, against
 * every ray from a lattice of origins and directions: all the ways in which rays and small fields can touch. Whole numbers
 * and halves make most of it exact in float, so the watertight kernels have to name the exact answer but for few ties.
 *
 * The test takes all of 2 × 2 and a share of the rest; CELLWALK_TEST_ROUNDS = n takes n times as many of the larger
 * fields, 1001 takes all. With CELLWALK_TEST_COUNTS = FILE the counts are kept for papers/robustness.md. */

#include "check.h"
#include "paths.h"
#include "tally.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Origins from -1/2 to half a cell beyond the field in steps of a half, heights from -1 to 3; directions of -2 … 2. */
typedef struct lattice {
    size_t rays;
    cw_ray *ray;
} lattice;

static lattice make_lattice(size_t nx, size_t ny) {
    const size_t along_x = 2 * nx + 1, along_y = 2 * ny + 1, places = along_x * along_y * 5;
    lattice l = {.ray = malloc(places * 124 * 2 * sizeof *l.ray)};
    check(l.ray != NULL, "out of memory");
    for (size_t p = 0; p < places; p++)
        for (int d = 0; d < 125; d++) {
            if (d == 62) continue; /* no direction */
            const float x = 0.5f * (float)(p % along_x) - 0.5f, y = 0.5f * (float)(p / along_x % along_y) - 0.5f;
            cw_ray ray = {.org = {x, y, (float)(p / along_x / along_y) - 1},
                          .dir = {(float)(d % 5 - 2), (float)(d / 5 % 5 - 2), (float)(d / 25 - 2)},
                          .tmax = INFINITY};
            l.ray[l.rays++] = ray;
            ray.tmin = -0.5f;
            ray.tmax = 0.5f;
            l.ray[l.rays++] = ray;
        }
    return l;
}

/* Field number in the numeral system of the heights. */
static void numbered_field(test_field *f, size_t nx, size_t ny, size_t number, const float *heights, size_t count) {
    f->shape = FIELD_INTEGERS;
    f->nx = nx;
    f->ny = ny;
    for (size_t k = 0; k < nx * ny; k++, number /= count) f->z[k] = heights[number % count];
}

/* Ties that are allowed, each for a reason. */
typedef struct excuses {
    size_t rims;   /* the exact hit lies on an edge or vertex that holes or the outside share: see papers/numerics.md */
    size_t thirds; /* dx - dy is 3 or -3, so a diagonal is crossed at a t that is no float */
} excuses;

static bool whole(double x) { return fabs(x - rint(x)) < 1e-9; }

static bool on_rim(const cw_ray *ray, const oracle_truth *truth) {
    const double x = (double)ray->org[0] + truth->t * (double)ray->dir[0];
    const double y = (double)ray->org[1] + truth->t * (double)ray->dir[1];
    const unsigned all = whole(x) && whole(y) ? 6 : whole(x) || whole(y) || whole(x - y) ? 2 : 1;
    return truth->hit && truth->at < all;
}

static bool excused(const cw_ray *ray, const oracle_truth *truth, excuses *e) {
    if (on_rim(ray, truth)) {
        e->rims++;
        return true;
    }
    if (fabsf(ray->dir[0] - ray->dir[1]) == 3) {
        e->thirds++;
        return true;
    }
    return false;
}

/* What one size of fields came to. */
typedef struct outcome {
    size_t fields, all_fields, answers; /* answers: bit for bit the judged ones, of all other kernels */
    tally tally;
    excuses excuses;
} outcome;

/* All kernels with this leaf test against the hits that were judged. */
static void compare_paths(const cw_field *field, const lattice *l, const cw_hit *hits, outcome *o) {
    static path paths[PATHS_MAX];
    static size_t count;
    if (count == 0) count = paths_find(paths);
    cw_hit *same = malloc(l->rays * sizeof *same);
    uint8_t *occluded = malloc(l->rays);
    check(same != NULL && occluded != NULL, "out of memory");
    for (size_t p = 0; p < count; p++) {
        if (paths[p].leaf != CW_LEAF_WATERTIGHT) continue;
        check_status(cw_closest(field, &paths[p].query, l->ray, l->rays, same), CW_OK);
        check_status(cw_occluded(field, &paths[p].query, l->ray, l->rays, occluded), CW_OK);
        for (size_t k = 0; k < l->rays; k++)
            if (!hit_same(&same[k], &hits[k]) || occluded[k] != (hits[k].i >= 0)) {
                ray_print(&l->ray[k]);
                hit_print("judged", &hits[k]);
                hit_print(paths[p].name, &same[k]);
                check(false, "%s: other answers", paths[p].name);
            }
        o->answers += l->rays;
    }
    free(same);
    free(occluded);
}

/* Every ray against one field; the number judged wrong or tied without an excuse. */
static size_t judge_all(const test_field *f, const lattice *l, bool every_path, outcome *out) {
    size_t wrong = 0;
    cw_field *field = field_open(f);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    cw_hit *hits = malloc(l->rays * sizeof *hits);
    check(o != NULL && hits != NULL, "out of memory");
    const cw_run query = {.expert.kernel = cw_kernel_find("cell"), .expert.leaf = CW_LEAF_WATERTIGHT};
    check_status(cw_closest(field, &query, l->ray, l->rays, hits), CW_OK);
    for (size_t k = 0; k < l->rays; k++) {
        const oracle_truth *truth = oracle_trace(o, &l->ray[k]);
        const judgement j = oracle_judge(o, &hits[k]);
        tally_add(&out->tally, &hits[k], truth, &j);
        if (j.verdict == VERDICT_RIGHT && digits_hold(&j)) continue;
        if (j.verdict == VERDICT_TIE && excused(&l->ray[k], truth, &out->excuses)) continue;
        if (wrong++ < 2) tally_explain(f, &l->ray[k], &hits[k], truth, &j);
    }
    if (every_path) compare_paths(field, l, hits, out);
    free(hits);
    oracle_destroy(o);
    cw_field_destroy(field);
    return wrong;
}

static const float heights[] = {0, 1, 2, NAN};

static FILE *counts; /* NULL: not requested */

static void write_counts(size_t nx, size_t ny, size_t height_count, const outcome *o) {
    const size_t *v = o->tally.verdict;
    if (counts == NULL) return;
    fprintf(
        counts,
        "{\"kind\": \"exhaustive\", \"field\": \"%zu x %zu\", \"heights\": \"%s\", \"fields\": %zu, \"all_fields\": "
        "%zu, \"rays\": %zu, \"hits\": %zu, \"pass\": %zu, \"right\": %zu, \"tie\": %zu, \"rims\": %zu, "
        "\"thirds\": %zu, \"leak\": %zu, \"phantom\": %zu, \"wrong_surface\": %zu, \"same_bits\": %zu}\n",
        nx, ny, height_count == 4 ? "0, 1, 2, hole" : "0, 1, 2", o->fields, o->all_fields, o->tally.rays, o->tally.hits,
        o->tally.passes, v[VERDICT_RIGHT], v[VERDICT_TIE], o->excuses.rims, o->excuses.thirds, v[VERDICT_LEAK],
        v[VERDICT_PHANTOM], v[VERDICT_WRONG_SURFACE], o->answers);
    fflush(counts);
}

static void judge_fields(size_t nx, size_t ny, size_t height_count, size_t step) {
    static test_field f;
    size_t wrong = 0;
    outcome o = {.all_fields = 1};
    for (size_t k = 0; k < nx * ny; k++) o.all_fields *= height_count;
    const lattice l = make_lattice(nx, ny);
    for (size_t number = 0; number < o.all_fields && wrong < 10; number += step) {
        numbered_field(&f, nx, ny, number, heights, height_count);
        const bool every_path = o.fields < 256 || o.fields % 16 == 0; /* they take as long as the oracle */
        wrong += judge_all(&f, &l, every_path, &o);
        o.fields++;
    }
    free(l.ray);
    char what[32];
    snprintf(what, sizeof what, "%zu x %zu", nx, ny);
    tally_print(what, &o.tally);
    printf("  %zu of %zu fields; ties: %zu on the rim of a hole or of the field, %zu because a third is no float\n",
           o.fields, o.all_fields, o.excuses.rims, o.excuses.thirds);
    write_counts(nx, ny, height_count, &o);
    check(wrong == 0, "%zu rays judged wrong, or tied without an excuse", wrong);
    check(o.tally.hits > o.tally.rays / 50, "too few hits for the test to mean anything");
    check(o.answers > o.tally.rays / o.fields, "no kernel was compared with the one that was judged");
}

/* One field in so many, that of a test of CELLWALK_TEST_ROUNDS = 1 being least. CELLWALK_TEST_DIVIDE is heeded too. */
static size_t one_in(size_t least) {
    const size_t every = least * test_divisor(), rounds = test_rounds();
    return rounds < every ? every / rounds : 1;
}

static void test_2x2(void **state) {
    (void)state;
    judge_fields(2, 2, 4, one_in(1));
}

static void test_2x3(void **state) {
    (void)state;
    judge_fields(2, 3, 4, one_in(211));
    judge_fields(3, 2, 4, one_in(211));
}

static void test_3x3(void **state) {
    (void)state;
    judge_fields(3, 3, 3, one_in(1001));
}

static int open_counts(void **state) {
    (void)state;
    const char *where = getenv("CELLWALK_TEST_COUNTS");
    if (where == NULL) return 0;
    counts = fopen(where, "w");
    if (counts && fputs("{\"kind\": \"run\", \"command\": \"exhaustive\"}\n", counts) >= 0) return 0;
    print_error("%s: %s\n", where, strerror(errno));
    return -1;
}

static int close_counts(void **state) {
    (void)state;
    return counts && fclose(counts) != 0 ? -1 : 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_2x2), cmocka_unit_test(test_2x3),
                                       cmocka_unit_test(test_3x3)};
    return cmocka_run_group_tests_name("exhaustive", tests, open_counts, close_counts);
}
