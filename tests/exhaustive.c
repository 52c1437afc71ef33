/* SPDX-License-Identifier: Apache-2.0 */
/* Every field of 2 × 2 samples with heights 0, 1, 2 or a hole, and fields of 3 × 3 with heights 0, 1, 2, against every
 * ray from a lattice of origins and directions: all the ways in which rays and small fields can touch. Whole numbers
 * and halves make most of it exact in float, so the watertight kernel has to name the exact answer but for few ties.
 *
 * CELLWALK_TEST_ROUNDS = n takes n times as many of the 3 × 3 fields; 1000 takes all. */

#include "check.h"
#include "tally.h"

#include <math.h>
#include <stdio.h>

#ifndef TEST_SCALE_DOWN
#define TEST_SCALE_DOWN 1
#endif

/* Origins from -1 to the field's side and beyond in steps of a half, heights from -1 to 3; directions of -2 … 2. */
typedef struct lattice {
    size_t places, heights; /* a side */
    size_t rays;
    cw_ray *ray;
} lattice;

static lattice make_lattice(size_t side) {
    lattice l = {.places = 2 * side + 1, .heights = 5};
    l.ray = malloc(l.places * l.places * l.heights * 124 * 2 * sizeof *l.ray);
    check(l.ray != NULL, "out of memory");
    for (size_t p = 0; p < l.places * l.places * l.heights; p++)
        for (int d = 0; d < 125; d++) {
            if (d == 62) continue; /* no direction */
            const float x = 0.5f * (float)(p % l.places) - 0.5f, y = 0.5f * (float)(p / l.places % l.places) - 0.5f;
            cw_ray ray = {.org = {x, y, (float)(p / l.places / l.places) - 1},
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
static void numbered_field(test_field *f, size_t side, size_t number, const float *heights, size_t count) {
    f->shape = FIELD_INTEGERS;
    f->nx = f->ny = side;
    for (size_t k = 0; k < side * side; k++, number /= count) f->z[k] = heights[number % count];
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

/* Every ray against one field; the number judged wrong or tied without an excuse. */
static size_t judge_all(const test_field *f, const lattice *l, tally *t, excuses *e) {
    size_t wrong = 0;
    cw_field *field = field_open(f);
    oracle *o = oracle_create(f->z, f->nx, f->ny);
    cw_hit *hits = malloc(l->rays * sizeof *hits);
    check(o != NULL && hits != NULL, "out of memory");
    const cw_query query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    check_status(cw_closest(field, &query, l->ray, l->rays, hits), CW_OK);
    for (size_t k = 0; k < l->rays; k++) {
        const oracle_truth *truth = oracle_trace(o, &l->ray[k]);
        const judgement j = oracle_judge(o, &hits[k]);
        tally_add(t, &hits[k], truth, &j);
        if (j.verdict == VERDICT_RIGHT) continue;
        if (j.verdict == VERDICT_TIE && excused(&l->ray[k], truth, e)) continue;
        if (wrong++ < 2) tally_explain(f, &l->ray[k], &hits[k], truth, &j);
    }
    free(hits);
    oracle_destroy(o);
    cw_field_destroy(field);
    return wrong;
}

static const float heights[] = {0, 1, 2, NAN};

static void judge_fields(size_t side, size_t count, size_t step) {
    static test_field f;
    size_t fields = 1, wrong = 0;
    for (size_t k = 0; k < side * side; k++) fields *= count;
    const lattice l = make_lattice(side);
    tally t = {.rays = 0};
    excuses e = {0, 0};
    for (size_t number = 0; number < fields && wrong < 10; number += step) {
        numbered_field(&f, side, number, heights, count);
        wrong += judge_all(&f, &l, &t, &e);
    }
    free(l.ray);
    tally_print(side == 2 ? "2 x 2" : "3 x 3", &t);
    printf("  ties: %zu on the rim of a hole or of the field, %zu because a third is no float\n", e.rims, e.thirds);
    check(wrong == 0, "%zu rays judged wrong, or tied without an excuse", wrong);
    check(t.hits > t.rays / 50, "too few hits for the test to mean anything");
}

static void test_2x2(void **state) {
    (void)state;
    judge_fields(2, 4, TEST_SCALE_DOWN);
}

static void test_3x3(void **state) {
    (void)state;
    const size_t every = 1001 * TEST_SCALE_DOWN, rounds = test_rounds();
    judge_fields(3, 3, rounds < every ? every / rounds : 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_2x2), cmocka_unit_test(test_3x3)};
    return cmocka_run_group_tests_name("exhaustive", tests, NULL, NULL);
}
