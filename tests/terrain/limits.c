/* SPDX-License-Identifier: Apache-2.0 */
/* Limits of a viewshed against a look at each sample by atan2, ends of limits in closed form, sums of weights, angles of view; and
 * profiles of lines against the surface between their points. */

#include "ground.h"
#include "profile.h"
#include "viewshed.h"
#include "workload/random.h"

#include <string.h>

enum { NX = 61, NY = 47, SAMPLES = NX * NY };

static void make_land(ground *g, random_state *r, size_t n) {
    ground_rough(g, NX, NY, n % 3 == 0 ? HOLES : ROUGH, r, ground_maps[n % GROUND_MAPS]);
}

typedef struct eye {
    double x, y, height, target, curvature;
} eye;

typedef struct views {
    uint16_t seen[SAMPLES];
    float angles[SAMPLES];
    double sums[SAMPLES];
} views;

/* All that is computed with these limits. */
static void look(const ground *g, const eye *e, const sight_limits *limits, views *to) {
    const viewshed_desc d = {.place = {e->x, e->y},
                             .height = e->height,
                             .absolute = true,
                             .target_height = e->target,
                             .curvature = e->curvature,
                             .limits = *limits};
    viewshed *v = NULL;
    check_status(cw_viewshed_create(&g->terrain, g->bounds, &d, &v), CW_OK);
    memset(to, 0, sizeof *to);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = to->seen}), CW_OK);
    check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.angle = to->angles}), CW_OK);
    for (int n = 1; n <= 3; n++) {
        check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.sum = to->sums, .weight = n}), CW_OK);
    }
    cw_viewshed_destroy(v);
}

/* Distance, azimuth and vertical angle of a sample's target, in degrees. */
static void measure(const ground *g, const eye *e, size_t i, size_t j, double to[3]) {
    const terrain *t = &g->terrain;
    double metres[2], at[2], from[2];
    cw_terrain_metres(t, e->x, e->y, metres);
    terrain_to_map(t, (double)i, (double)j, at);
    terrain_to_map(t, e->x, e->y, from);
    const double east = (at[0] - from[0]) * metres[0], north = (at[1] - from[1]) * metres[1];
    to[0] = hypot(east, north);
    to[1] = atan2(east, north) / degree;
    const double fall = e->curvature * to[0] * to[0] / (2 * t->radius);
    const double high = (double)t->z[j * NX + i] * terrain_metres_of_height(t) + e->target - e->height - fall;
    to[2] = atan2(high, to[0]) / degree;
}

static bool is_within(const sight_limits *l, const double m[3]) {
    if (m[0] < l->nearest || (l->farthest > 0 && m[0] > l->farthest)) return false;
    const double width = l->azimuths[1] - l->azimuths[0];
    const double turn = fmod(fmod(m[1] - l->azimuths[0], 360) + 360, 360);
    const double wide = width < 0 ? width + 360 : width;
    if (l->has_sector && m[0] > 0 && turn > wide) return false;
    return !l->has_verticals || (m[2] >= l->verticals[0] && m[2] <= l->verticals[1]);
}

static sight_limits random_limits(random_state *r) {
    sight_limits l = {0};
    if (random_below(r, 2)) l.nearest = random_between(r, 0, 150);
    if (random_below(r, 2)) l.farthest = random_between(r, 150, 400);
    l.has_sector = random_below(r, 4) > 0;
    const double width = random_below(r, 2) ? random_between(r, 0, 20) : random_between(r, 0, 359);
    l.azimuths[0] = random_between(r, -180, 180);
    l.azimuths[1] = l.azimuths[0] + width;
    if (random_below(r, 2) && l.azimuths[1] > 180) l.azimuths[1] -= 360;
    l.has_verticals = random_below(r, 2) != 0;
    l.verticals[0] = random_between(r, -20, 0);
    l.verticals[1] = l.verticals[0] + random_between(r, 0, 15);
    return l;
}

/* The seed is such that no sample is within 10^-9 of an end, where atan2 and cross products may differ by rounding: of either that is
 * less than 2^-45 degrees, and of distances of a few hundred metres as much. */
static void limits_sample_by_sample(void **state) {
    (void)state;
    static views all, some;
    random_state r = {2311};
    size_t seen = 0, left_out = 0;
    for (size_t n = 0; n < 160; n += test_step(7)) {
        ground g;
        make_land(&g, &r, n);
        eye e = {random_between(&r, -5, NX + 5), random_between(&r, -5, NY + 5), random_between(&r, 20, 60),
                 random_between(&r, 0, 5), random_below(&r, 2) ? 0 : 200};
        if (n % 2) e.x = rint(e.x), e.y = rint(e.y);
        const sight_limits none = {0}, l = random_limits(&r);
        look(&g, &e, &none, &all);
        look(&g, &e, &l, &some);
        for (size_t k = 0; k < SAMPLES; k++) {
            if (isnan(g.z[k])) {
                assert_true(some.seen[k] == 0 && isnan(some.angles[k]) && some.sums[k] == 0);
                continue;
            }
            double m[3];
            measure(&g, &e, k % NX, k / NX, m);
            const bool wanted = all.seen[k] && is_within(&l, m);
            check(some.seen[k] == wanted, "(%zu, %zu), %g m away at azimuth %.12g and angle %.12g, is %sseen", k % NX,
                  k / NX, m[0], m[1], m[2], wanted ? "not " : "");
            check(some.sums[k] == (wanted ? 6 : 0), "(%zu, %zu): a sum of %g", k % NX, k / NX, some.sums[k]);
            /* A float has 24 bits; what the two ways differ by is far less than their last one. */
            check(wanted ? fabs((double)some.angles[k] - m[2]) <= 0x1p-23 * (fabs(m[2]) + 1e-6) : isnan(some.angles[k]),
                  "(%zu, %zu): an angle of %.9g, not %.9g", k % NX, k / NX, (double)some.angles[k], m[2]);
            seen += wanted;
            left_out += all.seen[k] && !wanted;
        }
        ground_free(&g);
    }
    print_message("%zu seen, %zu left out\n", seen, left_out);
    assert_true(seen > 1000 && left_out > 1000);
}

/* Level ground and an eye over sample (20, 20), 30 m high: limits include their ends, and so does the eye's own sample those that are
 * about directions. */
static void ends_of_limits(void **state) {
    (void)state;
    enum { SIDE = 41, AT = 20 };
    ground g;
    ground_make(&g, SIDE, SIDE, plane, (double[3]){0});
    const eye e = {AT, AT, 30, 0, 0};
    static const struct {
        sight_limits limits;
        int number;
    } cases[] = {
        {{.has_sector = true, .azimuths = {0, 90}}, 0},
        {{.has_sector = true, .azimuths = {45, 45}}, 1},
        {{.has_sector = true, .azimuths = {270, 90}}, 2},
        {{.has_sector = true, .azimuths = {90, 45}}, 3},
        {{.has_sector = true, .azimuths = {0, 360}}, 4},
        {{.has_sector = true, .azimuths = {360, 0}}, 5},
        {{.nearest = 50, .farthest = 130}, 6},
        {{.has_verticals = true, .verticals = {-45, 90}}, 7},
        {{.has_verticals = true, .verticals = {-90, -45}}, 8},
        {{.has_verticals = true, .verticals = {0, 90}}, 9},
        {{.has_sector = true, .azimuths = {-45, 45}}, 10},
        {{.has_sector = true, .azimuths = {225, 135}}, 11},
    };
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        const viewshed_desc d = {.place = {e.x, e.y}, .height = e.height, .absolute = true, .limits = cases[c].limits};
        uint16_t seen[SIDE * SIDE] = {0};
        viewshed *v;
        check_status(cw_viewshed_create(&g.terrain, g.bounds, &d, &v), CW_OK);
        check_status(cw_viewshed_see(v, NULL, (cw_area){0}, &(cw_view){.seen = seen}), CW_OK);
        cw_viewshed_destroy(v);
        for (long k = 0; k < SIDE * SIDE; k++) {
            const long x = k % SIDE - AT, y = AT - k / SIDE, square = x * x + y * y; /* east, north */
            const bool own = square == 0;
            const bool wanted[] = {own || (x >= 0 && y >= 0),
                                   own || (x == y && x > 0),
                                   own || y >= 0,
                                   own || !(x > 0 && y > 0 && x > y),
                                   true,
                                   own || (x == 0 && y > 0),
                                   square >= 25 && square <= 169,
                                   square >= 9,
                                   square <= 9,
                                   false,
                                   own || y >= labs(x),
                                   own || !(-y > labs(x))};
            check(seen[k] == wanted[cases[c].number], "case %zu: (%ld, %ld) is %sseen", c, x, y, seen[k] ? "" : "not ");
        }
    }
    ground_free(&g);
}

/* All points of a profile are on the surface. Between two points the surface is straight, so none is missing. A point is seen if it
 * rises more steeply than all before it. */
static void profiles(void **state) {
    (void)state;
    random_state r = {77};
    profile p = {0};
    size_t seen = 0, hidden = 0, holes = 0;
    for (size_t n = 0; n < 120; n += test_step(5)) {
        ground g;
        make_land(&g, &r, n);
        const terrain *t = &g.terrain;
        const double metres = terrain_metres_of_height(t);
        double ends[2][3];
        for (int e = 0; e < 2; e++) {
            ends[e][0] = random_between(&r, 0, NX - 1);
            ends[e][1] = random_between(&r, 0, NY - 1);
            ends[e][2] = random_between(&r, 20, 40);
            if (n % 2) ends[e][0] = rint(ends[e][0]), ends[e][1] = rint(ends[e][1]);
        }
        if (n % 5 == 0) ends[1][0] = ends[0][0]; /* along a column */
        if (ends[1][0] == ends[0][0] && ends[1][1] == ends[0][1]) ends[1][1] = ends[0][1] < 20 ? 30 : 3;
        sight s;
        cw_sight_init(&s, t, g.bounds, ends[0], n % 4 == 1 ? 50 : 0);
        check_status(cw_profile_make(&p, &s, ends[1][0], ends[1][1], ends[1][2]), CW_OK);
        check(p.count >= 2 && p.points[0].share == 0 && p.points[p.count - 1].share == 1,
              "line %zu: %zu points from %.17g to %.17g", n, p.count, p.points[0].share, p.points[p.count - 1].share);
        /* Within an edge the lowering bends by a quarter of its value at the edge's length. */
        const double bend = 0.25 * (fabs(s.fall[0]) + fabs(s.fall[1]) + fabs(s.fall[2]));
        assert_true(fabs(p.points[0].line - ends[0][2]) < 1e-9 && fabs(p.points[p.count - 1].line - ends[1][2]) < 1e-9);
        for (size_t k = 0; k < p.count; k++) {
            const profile_point *a = &p.points[k], *b = a + 1;
            double at[2];
            for (int c = 0; c < 2; c++) at[c] = ends[0][c] + a->share * (ends[1][c] - ends[0][c]);
            holes += isnan(a->ground) ? 1 : 0;
            if (k > 0 && k + 1 < p.count && !isnan(a->ground)) {
                const double rise = (a->ground - s.eye[2] - sight_fall(&s, at[0], at[1])) / a->share;
                const double before =
                    cw_sight_steepest(&s, at[0], at[1], -INFINITY).steepest / a->share; /* of all of the way */
                if (fabs(rise - before) > 1e-6) {
                    check(a->seen == (rise > before), "line %zu at %.17g, %.17g: %sseen, rising %.12g after %.12g", n,
                          at[0], at[1], a->seen ? "" : "not ", rise, before);
                    seen += a->seen;
                    hidden += !a->seen;
                }
            }
            if (k + 1 == p.count) break;
            assert_true(b->share > a->share);
            /* Coordinates below 100 are off by 2^-46, on steps of 60 at most. */
            const double f = random_between(&r, 0, 1), share = a->share + f * (b->share - a->share);
            for (int c = 0; c < 2; c++) at[c] = ends[0][c] + share * (ends[1][c] - ends[0][c]);
            const double height = cw_terrain_height(t, at[0], at[1]) / metres;
            if (isnan(height) || isnan(a->ground + b->ground)) continue; /* an edge beside a hole is ground, too */
            check(fabs(a->ground + f * (b->ground - a->ground) - height) < 1e-9 + bend,
                  "between %.17g and %.17g of the way: %g, not %g", a->share, b->share,
                  a->ground + f * (b->ground - a->ground), height);
        }
        ground_free(&g);
    }
    cw_profile_free(&p);
    print_message("%zu seen, %zu hidden, %zu holes\n", seen, hidden, holes);
    assert_true(seen > 50 && hidden > 50 && holes > 10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_sample_by_sample),
        cmocka_unit_test(ends_of_limits),
        cmocka_unit_test(profiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
