/* SPDX-License-Identifier: Apache-2.0 */
/* Viewsheds and lines of sight against rational arithmetic over all edges, sample by sample, on land of many kinds: also where a line
 * touches the surface, or passes it by less than doubles can tell. On larger land most samples are held to their own lines, which the
 * judge has judged elsewhere. A row of sight_cases.c is a test; then closed forms of what the judge takes as given. */

#include "sight_cases.h"

#include <string.h>
#include <unistd.h>

enum { SIDE = 24, SAMPLES_MOST = 330 * 250 };
static uint16_t seen[SAMPLES_MOST];
static float needs[SAMPLES_MOST];

/* ---- two ways to check ----------------------------------------------------------------------------------------------- */

/* A sample or the target above it, as seen in a viewshed. Heights are in the samples' numbers. */
typedef struct target {
    const sight *sight;
    double x, y, z, above;
    bool seen;
    float need; /* metres */
} target;

typedef void checker(const target *t, tally *sum);

#define WHERE       "(%g, %g) from (%.17g, %.17g, %.17g)"
#define WHERE_IS(t) (t)->x, (t)->y, (t)->sight->eye[0], (t)->sight->eye[1], (t)->sight->eye[2]

/* Nothing is above the line to so much over the ground, and something is above that to less; both by more than floats and
 * the search's rounding leave open. */
static void check_need(const target *t, double need) {
    const double slack = 1e-5 + 1e-6 * need;
    if (need > 1e6) return; /* an edge so near to the eye that its share of the way, known to 2^-49, is far below 1 */
    check(judge_line(t->sight, t->x, t->y, t->z, need + slack) <= 0, WHERE ": %g are not enough", WHERE_IS(t), need);
    check(!(need > slack) || judge_line(t->sight, t->x, t->y, t->z, need - slack) >= 0, WHERE ": %g are too much",
          WHERE_IS(t), need);
}

static void by_judge(const target *t, tally *sum) {
    const sight *s = t->sight;
    const int highest = judge_line(s, t->x, t->y, t->z, t->above);
    check(t->seen == (highest < 0), WHERE " is %s, verdict %d", WHERE_IS(t), t->seen ? "seen" : "hidden", highest);
    const int bare = t->above == 0 ? highest : judge_line(s, t->x, t->y, t->z, 0);
    check((t->need > 0) == (bare > 0), WHERE ": %g m are needed, verdict %d", WHERE_IS(t), (double)t->need, bare);
    if ((size_t)(t->x + t->y) % 4 == 0) check_need(t, (double)t->need / terrain_metres_of_height(s->terrain));
    const double block = cw_sight_first_block(s, t->x, t->y, t->z);
    check((block < INFINITY) == (bare >= 0), WHERE " is %s", WHERE_IS(t), block < INFINITY ? "blocked" : "free");
    sum->seen += highest < 0;
    sum->touched += highest == 0;
    sum->hidden += highest > 0;
    sum->high += t->need > 1024;
}

/* Needs that are read off the skyline are those of the lines to 2^-17 m, and the same floats where those are coarser. */
static void by_lines(const target *t, tally *sum) {
    const double metres = terrain_metres_of_height(t->sight->terrain);
    const bool sees = cw_sight_sees(t->sight, t->x, t->y, t->z, t->above, (sight_parts){INFINITY, true});
    const double need = (double)(float)(metres * cw_sight_need(t->sight, t->x, t->y, t->z, -INFINITY));
    check(t->seen == sees, WHERE ": %s by its line", WHERE_IS(t), sees ? "seen" : "hidden");
    check(fabs((double)t->need - need) <= 0x1p-17, WHERE ": %.9g m are needed, not %.9g", WHERE_IS(t), need,
          (double)t->need);
    const double steepest = cw_sight_steepest(t->sight, t->x, t->y, -INFINITY).steepest;
    const double base = t->z - t->sight->eye[2] - sight_fall(t->sight, t->x, t->y);
    check(fabs(metres * fmax(steepest - base, 0) - need) <= 0x1p-17 + 1e-6 * need,
          WHERE ": something rises by %.9g, and %.9g m are needed", WHERE_IS(t), steepest - base, need);
    sum->seen += sees;
    sum->hidden += !sees;
    sum->high += need > 1024;
}

/* About so many samples of a viewshed, evenly; all if that is 0. */
static void check_view(const ground *g, const viewshed_desc *d, size_t some, random_state *r, checker *by, tally *sum) {
    const terrain *t = &g->terrain;
    const size_t one_in = some > 0 ? t->nx * t->ny / some + 1 : 1;
    viewshed *v = NULL;
    check_status(cw_viewshed_create(t, g->bounds, d, &v), CW_OK);
    const sight *s = cw_viewshed_sight(v);
    memset(seen, 0, sizeof seen);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = seen, .needed = needs}), CW_OK);
    for (size_t k = random_below(r, one_in); k < t->nx * t->ny; k += one_in) {
        const double x = (double)(k % t->nx), y = (double)(k / t->nx), off[2] = {x - s->eye[0], y - s->eye[1]};
        double away = 0, most = d->limits.farthest;
        for (int c = 0; c < 2; c++) away = hypot(away, t->map[c][0] * off[0] + t->map[c][1] * off[1]);
        if (most > 0 && fabs(away - most) < 1e-6) continue;
        if (isnan(g->z[k]) || (most > 0 && away > most)) {
            check(seen[k] == 0 && isnan(needs[k]), "(%g, %g) is a hole or too far away, and seen", x, y);
        } else if (off[0] == 0 && off[1] == 0) {
            check(seen[k] == 1 && needs[k] == 0, "the eye's own sample (%g, %g) is hidden", x, y);
        } else {
            const double above = d->target_height / terrain_metres_of_height(t);
            by(&(target){s, x, y, (double)g->z[k], above, seen[k] == 1, needs[k]}, sum);
        }
    }
    cw_viewshed_destroy(v);
}

/* ---- the rows -------------------------------------------------------------------------------------------------------- */

static void test_row(void **state) {
    const row *of = *state;
    random_state r = {2024};
    tally sum = {0, 0, 0, 0};
    const size_t fewer = of->cases > 1 && of->samples > 0 ? test_step(5) : 1, share = 2 * fewer * test_step(of->step);
    for (size_t k = 0; k < of->cases * test_rounds(); k++) {
        if (!test_takes(k, of->step)) continue;
        ground g;
        viewshed_desc d;
        of->make(k % of->cases, &g, &d, &r);
        check_view(&g, &d, of->samples / fewer, &r, of->exact ? by_judge : by_lines, &sum);
        ground_free(&g);
    }
    print_message("%zu seen, %zu touched, %zu hidden, %zu need much\n", sum.seen, sum.touched, sum.hidden, sum.high);
    check(sum.seen * share >= of->least.seen && sum.touched * share >= of->least.touched &&
              sum.hidden * share >= of->least.hidden && sum.high * share >= of->least.high,
          "too few of a kind for the test to mean anything");
}

/* ---- lines ----------------------------------------------------------------------------------------------------------- */

/* Between any two places. */
static void lines_between_places(void **state) {
    (void)state;
    random_state r = {13};
    size_t count[3] = {0, 0, 0};
    for (size_t land_number = 0; land_number < 40 / test_step(4) * test_rounds(); land_number++) {
        ground g;
        double slope[3];
        slope_of_whole_numbers(&g, SIDE, SIDE, &r, slope);
        for (int n = 0; n < 60; n++) {
            double ends[2][3];
            for (int e = 0; e < 2; e++) {
                for (int c = 0; c < 2; c++) {
                    const double at = n % 3 == 0   ? random_between(&r, 0, SIDE - 1)
                                      : n % 3 == 1 ? 0.25 * (double)random_below(&r, 4 * SIDE - 4)
                                                   : floor(random_between(&r, 0, SIDE - 1)) + 0x1p-43 * (double)e;
                    ends[e][c] = rint(at * 0x1p44) * 0x1p-44; /* see sight.h */
                }
                if (n % 6 == 5) ends[e][1] = ends[e][0] + (e ? 0x1p-40 : -0x1p-40); /* all but along a diagonal */
                ends[e][2] = slope[2] + slope[0] * ends[e][0] + slope[1] * ends[e][1];
            }
            sight s;
            cw_sight_init(&s, &g.terrain, NULL, ends[0], 0);
            const double *to = ends[1];
            if (to[0] == s.eye[0] && to[1] == s.eye[1]) continue;
            const int highest = judge_line(&s, to[0], to[1], to[2], 0);
            const double block = cw_sight_first_block(&s, to[0], to[1], to[2]);
            check((block < INFINITY) == (highest >= 0), "(%.17g, %.17g, %g) to (%.17g, %.17g, %g) is %s, verdict %d",
                  s.eye[0], s.eye[1], s.eye[2], to[0], to[1], to[2], block < INFINITY ? "blocked" : "free", highest);
            count[highest + 1]++;
        }
        ground_free(&g);
    }
    const size_t least = 40 / test_step(4);
    check(count[0] > least && count[1] > least && count[2] > least, "%zu free, %zu touched, %zu blocked", count[0],
          count[1], count[2]);
}

/* shape: y, height: a wall from west to east on level ground. */
static double wall(const double *shape, double x, double y) {
    (void)x;
    return y == shape[0] ? shape[1] : 0;
}

/* A wall's flank rises from 0 at row 9 to 40 at row 10: the line at 20 m meets it halfway, the one at 41 m passes. */
static void first_block(void **state) {
    (void)state;
    const double shape[2] = {-100, 40};
    ground g;
    sight s;
    ground_make(&g, 20, 100, wall, shape);
    cw_sight_init(&s, &g.terrain, g.bounds, (double[3]){7.5, 2, 20}, 0);
    const double level_line = cw_sight_first_block(&s, 7.5, 82, 20), down = cw_sight_first_block(&s, 7.5, 8, -20);
    check(fabs(level_line - 7.5 / 80) < 1e-12, "blocked at %.17g of the way", level_line);
    check(fabs(down - 0.5) < 1e-12, "the ground is met at %.17g of the way", down);
    assert_true(cw_sight_first_block(&s, 7.5, 82, 20 + 20 * 10 + 11) == INFINITY);
    ground_free(&g);
}

/* ---- closed forms ---------------------------------------------------------------------------------------------------- */

/* On a sphere an eye at height h sees the ground up to sqrt(2 R h), in the parabola that stands for it here. Between samples
 * the ground is lower than the parabola by at most a diagonal squared over 8 R, and something d beyond the farthest visible
 * place is hidden by d² / 2 R, so that nothing is seen from d = 7.1 m on. */
static void horizon_of_the_sea(void **state) {
    (void)state;
    const double shape[3] = {0}, eye = 0.03, curvature = 6.0 / 7;
    ground g;
    viewshed *v = NULL;
    ground_make(&g, 200, 200, plane, shape);
    const viewshed_desc d = {.place = {100, 100}, .height = eye, .curvature = curvature};
    const double far = sqrt(2 * g.terrain.radius / curvature * eye);
    assert_true(far > 500 && far < 900);
    memset(seen, 0, sizeof seen);
    check_status(cw_viewshed_create(&g.terrain, g.bounds, &d, &v), CW_OK);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = seen}), CW_OK);
    for (size_t k = 0; k < 200 * 200; k++) {
        const double away = 10 * hypot((double)(k % 200) - 100, (double)(k / 200) - 100);
        check(away >= far || seen[k], "%g m away is not seen; the horizon is at %g m", away, far);
        check(away <= far + 7.2 || !seen[k], "%g m away is seen; the horizon is at %g m", away, far);
    }
    cw_viewshed_destroy(v);
    ground_free(&g);
}

/* Land along one axis, one sample wide. */
static double strip(const double *shape, double x, double y) {
    const double along = (shape[0] > 0 ? x : -y) / GROUND_CELL, beside = (shape[0] > 0 ? -y : x) / GROUND_CELL;
    return beside == 0 ? 5 * random_unit(&(random_state){(uint64_t)along}) : (double)NAN;
}

/* Where every sample stands beside a hole, one way after the other to the eye would take the square of the length: ten minutes
 * here, and half a second now. */
static void a_strip_is_no_square(void **state) {
    (void)state;
    const size_t length = 40000 / test_step(8);
    alarm(120);
    for (int along = 0; along < 2; along++) {
        const double shape[1] = {along}, eye = 7;
        ground g;
        viewshed *v = NULL;
        ground_make(&g, along ? length : 2, along ? 2 : length, strip, shape);
        const viewshed_desc d = {.height = eye, .absolute = true};
        check_status(cw_viewshed_create(&g.terrain, g.bounds, &d, &v), CW_OK);
        check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.needed = needs}), CW_OK);
        double steepest = -(double)INFINITY;
        for (size_t k = 1; k < length; k++) {
            const size_t at = along ? k : 2 * k;
            const double z = (double)g.z[at], needed = fmax(steepest * (double)k + eye - z, 0);
            check(fabs((double)needs[at] - needed) <= 1e-6 * (1 + needed), "sample %zu: %.9g m, not %.9g", k,
                  (double)needs[at], needed);
            steepest = fmax(steepest, (z - eye) / (double)k);
        }
        cw_viewshed_destroy(v);
        ground_free(&g);
    }
    alarm(0);
}

int main(void) {
    struct CMUnitTest tests[ROWS + 4] = {
        cmocka_unit_test(lines_between_places),
        cmocka_unit_test(first_block),
        cmocka_unit_test(horizon_of_the_sea),
        cmocka_unit_test(a_strip_is_no_square),
    };
    for (size_t k = 0; k < ROWS; k++)
        tests[k + 4] = (struct CMUnitTest){
            .name = sight_rows[k].name, .test_func = test_row, .initial_state = (void *)&sight_rows[k]};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
