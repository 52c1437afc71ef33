/* SPDX-License-Identifier: Apache-2.0 */
/* Viewsheds and lines of sight against all edges of the field one by one, against shapes whose answers are known, and with
 * any number of threads. */

#include "brute_sight.h"
#include "ground.h"
#include "viewshed.h"
#include "workload/random.h"

#include <string.h>
#include <unistd.h>

/* Of all maps and sizes one in that many. */
static size_t step(void) { return test_step(4); }

enum { SAMPLES_MOST = 330 * 250 };
static uint16_t seen[SAMPLES_MOST];
static float heights[SAMPLES_MOST];

static viewshed *view(const ground *g, const viewshed_desc *d) {
    viewshed *v = NULL;
    check_status(cw_viewshed_create(&g->terrain, g->bounds, d, &v), CW_OK);
    return v;
}

static void count(viewshed *v, const cw_run *query) {
    memset(seen, 0, sizeof seen);
    check_status(cw_viewshed_see(v, query, (cw_area){0}, &(cw_view){.seen = seen}), CW_OK);
    check_status(cw_viewshed_see(v, query, (cw_area){0}, &(cw_view){.needed = heights}), CW_OK);
}

typedef struct tally {
    size_t seen, hidden;
} tally;

static void check_sample(const ground *g, const viewshed_desc *d, const viewshed *v, size_t i, size_t j, tally *sum) {
    const terrain *t = &g->terrain;
    const size_t k = j * t->nx + i;
    const sight *s = cw_viewshed_sight(v);
    if (isnan(t->z[k])) {
        check(seen[k] == 0 && isnan(heights[k]), "a hole is seen");
        return;
    }
    double east = 0, north = 0;
    for (int c = 0; c < 2; c++) {
        east += t->map[0][c] * ((c ? (double)j : (double)i) - s->eye[c]);
        north += t->map[1][c] * ((c ? (double)j : (double)i) - s->eye[c]);
    }
    if (d->limits.farthest > 0 && fabs(hypot(east, north) - d->limits.farthest) < 1e-6) return;
    if (d->limits.farthest > 0 && hypot(east, north) > d->limits.farthest) {
        check(seen[k] == 0 && isnan(heights[k]), "(%zu, %zu) is seen beyond the greatest distance", i, j);
        return;
    }
    const double base = cw_sight_sample(s, i, j), metres = terrain_metres_of_height(t);
    const double top = base + d->target_height / metres;
    const double steepest = brute_steepest(s, (double)i, (double)j), room = 1e-9 * (1 + fabs(steepest));
    const bool own = (double)i == s->eye[0] && (double)j == s->eye[1], open = steepest == -INFINITY;
    if (own || open || fabs(steepest - top) > room) {
        const bool wanted = own || steepest < top;
        check(seen[k] == wanted, "(%zu, %zu) from (%.17g, %.17g, %.17g) is %s: something on the way rises %.9g over it",
              i, j, s->eye[0], s->eye[1], s->eye[2], seen[k] ? "seen" : "not seen", steepest - top);
        sum->seen += wanted;
        sum->hidden += !wanted;
    }
    const double needed = own ? 0 : metres * fmax(0, steepest - base);
    check(fabs((double)heights[k] - needed) <= 1e-6 * (1 + needed), "(%zu, %zu): %.9g m are needed, not %.9g", i, j,
          needed, (double)heights[k]);
}

/* All samples of a small field, some of a larger one. */
static void check_view(const ground *g, const viewshed_desc *d, random_state *r, tally *sum) {
    const size_t nx = g->terrain.nx, all = nx * g->terrain.ny, some = all > 80 ? 80 : all;
    const cw_run query = (cw_run){0};
    viewshed *v = view(g, d);
    count(v, &query);
    for (size_t n = 0; n < some; n++) {
        const size_t k = some == all ? n : random_below(r, all);
        check_sample(g, d, v, k % nx, k / nx, sum);
    }
    cw_viewshed_destroy(v);
}

/* WRONG: numbers for no data that are taken for heights. */
typedef enum roughness { SMOOTH, ROUGH, HOLES, SPIKES, WHOLE, WRONG, ROUGHNESSES } roughness;

static void make_land(ground *g, size_t nx, size_t ny, roughness rough, random_state *r, const double map[3][4]) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    const double a = random_between(r, 3, 9), b = random_between(r, 3, 9);
    for (size_t k = 0; k < nx * ny; k++) {
        const double x = (double)(k % nx), y = (double)(k / nx), wave = 20 * sin(x / a) * cos(y / b);
        z[k] = (float)(rough == SPIKES ? (random_below(r, 40) == 0 ? random_between(r, 0, 90) : 0)
                                       : wave + random_between(r, 0, rough == SMOOTH ? 1 : 15));
        if (rough == HOLES && random_below(r, 12) == 0) z[k] = NAN;
        if (rough == WHOLE) z[k] = rintf(0.2F * z[k]);
        if (rough == WRONG && random_below(r, 50) == 0) z[k] = random_below(r, 2) ? -32768 : -9999;
    }
    ground_take(g, nx, ny, z, map);
}

/* Maps that are as usual, not square, turned, and mirrored. */
static const double maps[4][3][4] = {
    {{10, 0, 0, 500}, {0, -10, 0, 900}, {0, 0, 1, 0}},
    {{10, 0, 0, 0}, {0, -25, 0, 0}, {0, 0, 0.3048, 0}},
    {{8, 6, 0, 100}, {6, -8, 0, 100}, {0, 0, 1, 0}},
    {{-5, 0, 0, 0}, {1, 5, 0, 0}, {0, 0, 1, 0}},
};

static void every_edge_counts(void **state) {
    (void)state;
    static const size_t sizes[][2] = {{2, 2}, {3, 17}, {23, 9}, {41, 38}};
    random_state r = {2024};
    tally sum = {0, 0};
    for (size_t round = 0; round < test_rounds(); round++)
        for (roughness rough = 0; rough < ROUGHNESSES; rough++)
            for (size_t n = 0; n < 16; n += step()) {
                const size_t size = (n + n / 4) % 4, nx = sizes[size][0],
                             ny = sizes[size][1]; /* all sizes, whatever the step */
                ground g;
                make_land(&g, nx, ny, rough, &r, maps[n / 4]);
                for (int place = 0; place < 6; place++) {
                    viewshed_desc d = {.height = random_between(&r, 0.5, 30),
                                       .target_height = place % 2 ? random_between(&r, 0, 10) : 0,
                                       .limits.farthest = place == 4 ? random_between(&r, 20, 200) : 0,
                                       .curvature = place == 5   ? 3000
                                                    : place == 3 ? 6.0 / 7
                                                                 : 0};
                    /* On a sample, on a border, anywhere, outside. */
                    d.place[0] = random_between(&r, 0, (double)(nx - 1));
                    d.place[1] = random_between(&r, 0, (double)(ny - 1));
                    if (place < 2) d.place[0] = floor(d.place[0]);
                    if (place == 0 || place == 5) d.place[1] = floor(d.place[1]);
                    if (place == 3) {
                        d.place[0] = random_between(&r, -30, 60);
                        d.place[1] = random_between(&r, -30, 60);
                    }
                    d.absolute = place == 3 || isnan(cw_terrain_height(&g.terrain, d.place[0], d.place[1]));
                    if (d.absolute) d.height += 20;
                    /* Curvature of 3000 earths, that it be seen on a few hundred metres. */
                    if (test_takes(n + (size_t)place, 3)) check_view(&g, &d, &r, &sum);
                }
                ground_free(&g);
            }
    const size_t least = 3000 / step() / test_step(3);
    check(sum.seen > least && sum.hidden > least, "%zu seen, %zu hidden", sum.seen, sum.hidden);
}

/* shape: sample (i, j) stands out by 1000 m. */
static double spike(const double *shape, double x, double y) {
    return x == 10 * shape[0] && y == -10 * shape[1] ? 1000 : 0;
}

/* A spike next to the eye hides what its edges cross, though they end at the eye's own row or column or behind it. */
static void next_to_the_eye(void **state) {
    (void)state;
    static const double eyes[][2] = {{20.2, 20}, {20, 20.2}, {19.8, 20}, {20, 19.8}, {20.3, 20.6}};
    tally sum = {0, 0};
    const size_t apart = test_step(7);
    for (size_t n = 0; n < 9 * 5; n += apart) {
        const double shape[2] = {19 + (double)(n % 3), 19 + (double)(n / 3 % 3)};
        ground g;
        ground_make(&g, 41, 41, spike, shape);
        const viewshed_desc d = {.place = {eyes[n / 9][0], eyes[n / 9][1]}, .height = 5, .absolute = true};
        viewshed *v = view(&g, &d);
        count(v, NULL);
        for (size_t j = 0; j < 41; j += 2)
            for (size_t i = 0; i < 41; i += 3) check_sample(&g, &d, v, i, j, &sum);
        cw_viewshed_destroy(v);
        ground_free(&g);
    }
    check(sum.seen > 1000 / apart && sum.hidden > 1000 / apart, "%zu seen, %zu hidden", sum.seen, sum.hidden);
}

/* A bowl around the eye at shape, ever steeper outward, and a spike of 100 m close by, at (21, 20). */
static double spike_in_a_bowl(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, ring = fmax(fabs(i - shape[0]), fabs(j - shape[1]));
    if (ring < 2.5) return i == 21 && j == 20 ? 100 : -1000;
    return ring * (100 / 0.7 - 0.1 + 0.001 * ring);
}

/* The tip of the spike alone hides what is behind it: its flanks, a hair to the side, do not. */
static void behind_a_tip(void **state) {
    (void)state;
    static const double eye[2] = {20.3, 20.2};
    tally sum = {0, 0};
    ground g;
    ground_make(&g, 41, 41, spike_in_a_bowl, eye);
    const viewshed_desc d = {.place = {eye[0], eye[1]}, .absolute = true};
    viewshed *v = view(&g, &d);
    count(v, NULL);
    for (size_t j = 0; j < 41; j++)
        for (size_t i = 0; i < 41; i++) check_sample(&g, &d, v, i, j, &sum);
    assert_true(seen[18 * 41 + 28] == 0 && seen[18 * 41 + 27] == 1 && seen[18 * 41 + 29] == 1);
    cw_viewshed_destroy(v);
    ground_free(&g);
}

/* Larger, with everything that bounds pass over; a part of the samples is looked at. */
static void large_views(void **state) {
    (void)state;
    random_state r = {77};
    tally sum = {0, 0};
    ground g;
    make_land(&g, 200, 197, SMOOTH, &r, maps[0]);
    for (size_t n = 0; n < 4; n++) {
        const cw_run query = (cw_run){0};
        const viewshed_desc d = {.place = {random_between(&r, 0, 199), random_between(&r, 0, 196)},
                                 .height = random_between(&r, 1, 40),
                                 .curvature = (double)n};
        if (!test_takes(n, 2)) continue;
        viewshed *v = view(&g, &d);
        count(v, &query);
        for (size_t m = 0; m < test_share(1000, 50); m++)
            check_sample(&g, &d, v, random_below(&r, 200), random_below(&r, 197), &sum);
        cw_viewshed_destroy(v);
    }
    check(sum.seen > test_share(100, 5) && sum.hidden > test_share(100, 5), "%zu seen, %zu hidden", sum.seen,
          sum.hidden);
    ground_free(&g);
}

/* What the sweep says of samples without looking at their lines is what their lines say: of one in so many. Returns how many of all
 * are seen. */
static size_t lines_seen(const ground *g, const viewshed_desc *d, size_t first, size_t one_in) {
    const size_t nx = g->terrain.nx, all = nx * g->terrain.ny;
    viewshed *v = view(g, d);
    const sight *s = cw_viewshed_sight(v);
    size_t total = 0;
    memset(seen, 0, sizeof seen);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = seen}), CW_OK);
    for (size_t k = 0; k < all; k++) total += seen[k] == 1;
    for (size_t k = first; k < all; k += one_in) {
        const double x = (double)(k % nx), y = (double)(k / nx);
        if (isnan(g->z[k]) || (x == d->place[0] && y == d->place[1])) continue;
        const bool wanted = cw_sight_sees(s, x, y, (double)g->z[k], d->target_height, (sight_parts){INFINITY, true});
        check(seen[k] == wanted, "(%g, %g) from (%.17g, %.17g, %.17g): %s by its line", x, y, s->eye[0], s->eye[1],
              s->eye[2], wanted ? "seen" : "hidden");
    }
    cw_viewshed_destroy(v);
    return total;
}

/* Also from under the ground, and with targets in it. */
static void lines_decide(void **state) {
    (void)state;
    enum { NX = 330, NY = 250, PLACES = 5 };
    static const double eyes[PLACES] = {50, 60, 70, 80, -3}, targets[PLACES] = {0, 0, 3, -1, 0};
    const size_t one_in = 12 * test_divisor();
    random_state r = {31};
    for (roughness rough = 0; rough < ROUGHNESSES; rough++) {
        ground g;
        make_land(&g, NX, NY, rough, &r, maps[0]);
        for (int n = 0; n < PLACES; n++) {
            viewshed_desc d = {.place = {random_between(&r, 0, NX - 1), random_between(&r, 0, 12)},
                               .height = eyes[n],
                               .absolute = true,
                               .target_height = targets[n],
                               .curvature = n == 2 ? 100 : 0};
            if (n % 2 == 1)
                for (int c = 0; c < 2; c++) d.place[c] = floor(d.place[c]);
            const size_t first = random_below(&r, one_in);
            if (!test_takes((size_t)rough * PLACES + (size_t)n, 3)) continue;
            const size_t total = lines_seen(&g, &d, first, one_in);
            check(n == 4 || (total > 300 && total < NX * NY - 300), "land %d: %zu are seen", (int)rough, total);
        }
        ground_free(&g);
    }
}

/* Steps and lakes: many edges on one line, whose pieces of the skyline become one. */
static void make_steps(ground *g, size_t nx, size_t ny, double high, random_state *r) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    double waves[12][3];
    for (int k = 0; k < 12; k++) {
        const double size = random_between(r, 0.02, k < 4 ? 0.06 : 0.4), angle = random_between(r, 0, 6.3);
        waves[k][0] = size * cos(angle);
        waves[k][1] = size * sin(angle);
        waves[k][2] = random_between(r, 0, 6.3);
    }
    for (size_t k = 0; k < nx * ny; k++) {
        double height = 0;
        for (int w = 0; w < 12; w++)
            height += sin(waves[w][0] * (double)(k % nx) + waves[w][1] * (double)(k / nx) + waves[w][2]) /
                      (1 + 20 * hypot(waves[w][0], waves[w][1]));
        z[k] = (float)(high * fmax(height, -0.4));
    }
    ground_take(g, nx, ny, z, maps[0]);
}

/* Heights that are read off the skyline are those of the lines to 2^-17 m, and the same floats where those are coarser: also among
 * lakes. */
static void needs_are_those_of_lines(void **state) {
    (void)state;
    enum { NX = 330, NY = 250 };
    const size_t rounds = 24 / test_step(24) + 1, one_in = 7 * test_divisor();
    random_state r = {5};
    size_t large = 0;
    for (size_t round = 0; round < rounds; round++) {
        ground g;
        make_steps(&g, NX, NY, round % 3 == 0 ? 2000 : 100, &r);
        viewshed_desc d = {.place = {random_between(&r, 0, NX - 1), random_between(&r, 0, NY - 1)},
                           .height = round % 2 == 0 ? 2 : 0.5};
        for (int c = 0; c < 2 && round % 4 != 0; c++) d.place[c] = floor(d.place[c]);
        viewshed *v = view(&g, &d);
        const sight *s = cw_viewshed_sight(v);
        check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.needed = heights}), CW_OK);
        for (size_t k = round % one_in; k < (size_t)NX * NY; k += one_in) {
            const double x = (double)(k % NX), y = (double)(k / NX);
            if (x == d.place[0] && y == d.place[1]) continue;
            const float wanted = (float)cw_sight_need(s, x, y, (double)g.z[k], -INFINITY);
            large += wanted > 1024;
            check(fabs((double)heights[k] - (double)wanted) <= 0x1p-17,
                  "(%g, %g) from (%.17g, %.17g): %.9g m are needed, not %.9g", x, y, d.place[0], d.place[1],
                  (double)wanted, (double)heights[k]);
        }
        cw_viewshed_destroy(v);
        ground_free(&g);
    }
    check(large > 1000 / one_in, "%zu needs are large", large);
}

/* For an eye at (9.75, 0) and height 0: from shape on, a dam at that height in row 16, then a cliff, and a shore at that height again
 * in the last two rows, whose end is a tower before the cliff. */
static double dam_and_shore(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10;
    if (j == 16 && i >= shape[0]) return i < 12 ? 0 : 500;
    return j < 257 ? -100 : i < 15 ? 0 : i < 38 ? -100 : 3000;
}

/* An edge of the shore joins an edge of the dam, as both are on one line as seen from the eye, and the dam's piece of the skyline is gone.
 * Bins of directions farther right must not look for the cliff from that piece. There are enough bins from row 257 on. */
static void behind_a_joined_piece(void **state) {
    (void)state;
    enum { NX = 43, NY = 259 };
    const double shape[1] = {10};
    ground g;
    ground_make(&g, NX, NY, dam_and_shore, shape);
    const viewshed_desc d = {.place = {9.75, 0}, .absolute = true};
    const size_t total = lines_seen(&g, &d, 0, 1);
    check(total > 100, "%zu are seen", total);
    viewshed *v = view(&g, &d);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.needed = heights}), CW_OK);
    for (size_t k = 0; k < (size_t)NX * NY; k++) {
        const double x = (double)(k % NX), y = (double)(k / NX);
        const float wanted = (float)cw_sight_need(cw_viewshed_sight(v), x, y, (double)g.z[k], -INFINITY);
        check(heights[k] == wanted, "(%g, %g): %.9g m are needed, not %.9g", x, y, (double)wanted, (double)heights[k]);
    }
    cw_viewshed_destroy(v);
    ground_free(&g);
}

/* shape: in the plane 0.5 x - 0.25 y, or ridges that come up to it. */
static double touched(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, z = 0.5 * i + 0.25 * j;
    const bool ridge = fmod(shape[0] == 1 ? i : shape[0] == 2 ? j : i + 2 * j, 4) == 0;
    return shape[0] == 0 || ridge ? z : z - 10;
}

/* With the eye in a plane that everything comes up to and nothing exceeds, but for rounding, all are ties. */
static void ties(void **state) {
    (void)state;
    const size_t one_in = test_step(32);
    random_state r = {8};
    for (double kind = 0; kind < 4; kind++) {
        ground g;
        ground_make(&g, 150, 90, touched, &kind);
        for (size_t n = 0; n < 4; n++) {
            viewshed_desc d = {.place = {random_between(&r, 40, 80), random_between(&r, 30, 60)}, .absolute = true};
            d.height = 0.5 * d.place[0] + 0.25 * d.place[1];
            const size_t first = random_below(&r, one_in);
            if (test_takes((size_t)kind + n, 4)) lines_seen(&g, &d, first, one_in);
        }
        ground_free(&g);
    }
}

/* shape: 1 if the spike at (12, 10) stands among holes. */
static double lone_spike(const double *shape, double x, double y) {
    const double i = x / 10, j = -y / 10, away = fmax(fabs(i - 12), fabs(j - 10));
    return away == 0 ? 100 : away == 1 && shape[0] == 1 ? NAN : 0;
}

/* A sample without edges hides what is exactly behind it. */
static void behind_a_lone_sample(void **state) {
    (void)state;
    const double shape[1] = {1};
    ground g;
    ground_make(&g, 41, 31, lone_spike, shape);
    static const double eyes[][2] = {{4, 10}, {8, 8}, {12, 2}, {9, 7}, {16, 12}, {15, 13}};
    for (size_t n = 0; n < sizeof eyes / sizeof *eyes; n++) {
        const viewshed_desc d = {.place = {eyes[n][0], eyes[n][1]}, .height = 5, .absolute = true};
        const size_t i = (size_t)(24 - eyes[n][0]), j = (size_t)(20 - eyes[n][1]);
        lines_seen(&g, &d, 0, 1);
        check(seen[j * 41 + i] == 0 && seen[(j + 2) * 41 + i + 1] == 1, "from (%g, %g)", eyes[n][0], eyes[n][1]);
    }
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
        ground_make(&g, along ? length : 2, along ? 2 : length, strip, shape);
        viewshed *v = view(&g, &(viewshed_desc){.height = eye, .absolute = true});
        check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.needed = heights}), CW_OK);
        double steepest = -(double)INFINITY;
        for (size_t k = 1; k < length; k++) {
            const size_t at = along ? k : 2 * k;
            const double z = (double)g.z[at], needed = fmax(steepest * (double)k + eye - z, 0);
            check(fabs((double)heights[at] - needed) <= 1e-6 * (1 + needed), "sample %zu: %.9g m, not %.9g", k,
                  (double)heights[at], needed);
            steepest = fmax(steepest, (z - eye) / (double)k);
        }
        cw_viewshed_destroy(v);
        ground_free(&g);
    }
    alarm(0);
}

static double level(const double *shape, double x, double y) {
    (void)x;
    (void)y;
    return shape[0];
}

/* On a sphere an eye at height h sees the ground up to sqrt(2 R h), in the parabola that stands for it here. Between samples
 * the ground is lower than the parabola by at most a diagonal squared over 8 R, and something d beyond the farthest visible
 * place is hidden by d² / 2 R, so that nothing is seen from d = 7.1 m on. */
static void horizon_of_the_sea(void **state) {
    (void)state;
    const double shape[1] = {0}, eye = 0.03, curvature = 6.0 / 7;
    ground g;
    ground_make(&g, 200, 200, level, shape);
    const viewshed_desc d = {.place = {100, 100}, .height = eye, .curvature = curvature};
    const double far = sqrt(2 * g.terrain.radius / curvature * eye);
    viewshed *v = view(&g, &d);
    count(v, NULL);
    assert_true(far > 500 && far < 900);
    for (size_t j = 0; j < 200; j++)
        for (size_t i = 0; i < 200; i++) {
            const double away = 10 * hypot((double)i - 100, (double)j - 100);
            const bool got = seen[j * 200 + i];
            if (away < far) check(got, "%g m away is not seen; the horizon is at %g m", away, far);
            if (away > far + 7.2) check(!got, "%g m away is seen; the horizon is at %g m", away, far);
        }
    cw_viewshed_destroy(v);
    ground_free(&g);
}

/* shape: rise eastward and northward. */
static double plane(const double *shape, double x, double y) { return shape[0] * x + shape[1] * y; }

/* From above a plane all of it is seen; from below nothing but the observer's surroundings. */
static void views_of_a_plane(void **state) {
    (void)state;
    const double shape[2] = {0.25, -0.5};
    ground g;
    ground_make(&g, 90, 80, plane, shape);
    for (int below = 0; below < 2; below++) {
        const viewshed_desc d = {.place = {41.25, 37.5}, .height = below ? -0.5 : 0.5};
        viewshed *v = view(&g, &d);
        count(v, NULL);
        for (size_t j = 0; j < 80; j++)
            for (size_t i = 0; i < 90; i++) {
                const bool near = fabs((double)i - 41.25) < 2 && fabs((double)j - 37.5) < 2;
                if (!near) check(seen[j * 90 + i] == !below, "(%zu, %zu): %d", i, j, seen[j * 90 + i]);
            }
        cw_viewshed_destroy(v);
    }
    ground_free(&g);
}

/* shape: x of a wall from north to south, its height. */
static double wall(const double *shape, double x, double y) {
    (void)y;
    return x == shape[0] ? shape[1] : 0;
}

static void first_block(void **state) {
    (void)state;
    const double shape[2] = {500, 40};
    ground g;
    sight s;
    ground_make(&g, 100, 20, wall, shape);
    cw_sight_init(&s, &g.terrain, g.bounds, (double[3]){10, 7.5, 20}, 0);
    /* The wall's flank rises from 0 at column 49 to 40 at column 50: the line at 20 m meets it halfway, the one at 41 m
     * passes. */
    const double level_line = cw_sight_first_block(&s, 90, 7.5, 20);
    check(fabs(level_line - 39.5 / 80) < 1e-12, "blocked at %.17g of the way", level_line);
    assert_true(cw_sight_first_block(&s, 90, 7.5, 20 + 2 * 20 + 2 + 1) == INFINITY);
    const double down = cw_sight_first_block(&s, 30, 7.5, -20);
    check(fabs(down - 0.5) < 1e-12, "the ground is met at %.17g of the way", down);
    ground_free(&g);
}

static void same_bits_in_threads(void **state) {
    (void)state;
    static uint16_t seen_alone[SAMPLES_MOST];
    static float heights_alone[SAMPLES_MOST];
    random_state r = {5};
    ground g;
    cw_pool *pool = NULL;
    make_land(&g, 150, 170, ROUGH, &r, maps[0]);
    check_status(cw_pool_create(3, &pool), CW_OK);
    viewshed *v = view(&g, &(viewshed_desc){.place = {60, 77.25}, .height = 12, .curvature = 1});
    cw_run query = (cw_run){0};
    count(v, &query);
    memcpy(seen_alone, seen, sizeof seen);
    memcpy(heights_alone, heights, sizeof heights);
    query.pool = pool;
    count(v, &query);
    assert_memory_equal(seen, seen_alone, sizeof seen);
    assert_memory_equal(heights, heights_alone, sizeof(float) * 150 * 170);
    cw_viewshed_destroy(v);
    cw_pool_destroy(pool);
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_edge_counts),     cmocka_unit_test(next_to_the_eye),
        cmocka_unit_test(behind_a_tip),          cmocka_unit_test(large_views),
        cmocka_unit_test(horizon_of_the_sea),    cmocka_unit_test(views_of_a_plane),
        cmocka_unit_test(first_block),           cmocka_unit_test(same_bits_in_threads),
        cmocka_unit_test(lines_decide),          cmocka_unit_test(needs_are_those_of_lines),
        cmocka_unit_test(behind_a_joined_piece), cmocka_unit_test(ties),
        cmocka_unit_test(behind_a_lone_sample),  cmocka_unit_test(a_strip_is_no_square),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
