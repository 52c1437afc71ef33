/* SPDX-License-Identifier: Apache-2.0 */
/* Places, directions and metres of a terrain's map, and the sun, against numbers that are known. */

#include "check.h"
#include "sun.h"
#include "terrain.h"

#include <math.h>

static const float flat[6];

static terrain make(const double map[3][4], bool geographic, double unit) {
    terrain t;
    const terrain_desc d = {.nx = 3, .ny = 2, .z = flat, .map = map, .geographic = geographic, .unit = unit};
    assert_true(cw_terrain_init(&t, &d));
    return t;
}

/* Lengths of a degree on WGS 84, from the formulas of its radii: National Geospatial-Intelligence Agency, TR8350.2. */
static void metres_in_a_degree(void **state) {
    (void)state;
    static const double known[][3] = {
        {0, 111319.491, 110574.276}, {45, 78846.806, 111131.778}, {-45, 78846.806, 111131.778}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        const double map[3][4] = {{0.5, 0, 0, 10}, {0, -0.5, 0, known[k][0]}, {0, 0, 1, 0}};
        const terrain t = make(map, true, 0);
        double metres[2], dir[2];
        cw_terrain_metres(&t, 1, 0, metres);
        check(fabs(metres[0] - known[k][1]) < 0.05 && fabs(metres[1] - known[k][2]) < 0.05, "%g: %.3f, %.3f",
              known[k][0], metres[0], metres[1]);
        /* North-east by the compass is more columns than rows, where a column is shorter. */
        const double length = cw_terrain_direction(&t, 1, 0, 45, dir);
        check(fabs(dir[0] / -dir[1] - metres[1] / metres[0]) < 1e-9, "%g: %g, %g", known[k][0], dir[0], dir[1]);
        check(fabs(length - hypot(dir[0] * 0.5 * metres[0], dir[1] * 0.5 * metres[1])) < 1e-6, "%g metres", length);
    }
}

static void units_of_a_map(void **state) {
    (void)state;
    const double foot = 0.3048, map[3][4] = {{30, 0, 0, 1000}, {0, -30, 0, 2000}, {0, 0, 1, 0}};
    const terrain t = make(map, false, foot);
    double metres[2], xy[2], ij[2];
    cw_terrain_metres(&t, 1, 1, metres);
    assert_true(metres[0] == foot && metres[1] == foot && terrain_metres_of_height(&t) == foot);
    terrain_to_map(&t, 2, 1, xy);
    assert_true(xy[0] == 1060 && xy[1] == 1970);
    terrain_from_map(&t, xy[0], xy[1], ij);
    assert_true(fabs(ij[0] - 2) < 1e-12 && fabs(ij[1] - 1) < 1e-12);
    terrain u;
    const double line[3][4] = {{1, 2, 0, 0}, {2, 4, 0, 0}, {0, 0, 1, 0}};
    assert_false(cw_terrain_init(&u, &(terrain_desc){.nx = 3, .ny = 2, .z = flat, .map = line}));
}

/* Multiples of 45 degrees go through samples exactly. */
static void exact_directions(void **state) {
    (void)state;
    for (int k = -16; k <= 16; k++) {
        double s, c;
        cw_terrain_sine_cosine(45 * k, &s, &c);
        if (k % 4 == 0) assert_true(s == 0 && fabs(c) == 1);
        if (k % 4 != 0 && k % 2 == 0) assert_true(fabs(s) == 1 && c == 0);
        if (k % 2 != 0) assert_true(fabs(s) == fabs(c));
        assert_true(fabs(s - sin(45 * k * 0.017453292519943295)) < 1e-15 &&
                    fabs(c - cos(45 * k * 0.017453292519943295)) < 1e-15);
    }
}

/* Meeus, Astronomical Algorithms, example 25.a: 1992 October 13, 0h, declination -7.78507. Over the pole that is the altitude;
 * less the parallax of 0.00243; in a minute, by which his time differs from the clock's, it changes by less than 0.0003. */
static void sun_of_an_almanac(void **state) {
    (void)state;
    double seconds;
    assert_true(cw_sun_parse_time("1992-10-13T00:00:00Z", &seconds));
    const sun_position p = cw_sun_at(seconds, 0, 90);
    check(fabs(p.altitude - p.refraction + 7.78507 + 0.00243) < 0.0005, "%.5f", p.altitude - p.refraction);
    check(fabs(p.radius - 0.26734) < 1e-3, "radius %.5f", p.radius); /* 959.63 arc seconds over 0.99766 units */
}

static void times(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double seconds;
    } good[] = {{"1970-01-01T00:00:00Z", 0},
                {"2000-02-29T00:00:00Z", 951782400},
                {"2000-03-01T00:00:00Z", 951868800},
                {"2024-06-21T12:00:00+02:00", 1718964000},
                {"2024-06-21T12:00Z", 1718971200}};
    static const char *const bad[] = {"",
                                      "noon",
                                      "2024-06-21T12:00:00",
                                      "2024-13-01T00:00Z",
                                      "2024-02-30T00:00Z",
                                      "1900-02-29T00:00Z",
                                      "2023-02-29T00:00Z",
                                      "2024-06-21T25:00Z",
                                      "2024-06-21T12:00:00Zx"};
    double seconds;
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++)
        check(cw_sun_parse_time(good[k].text, &seconds) && seconds == good[k].seconds, "%s: %.0f", good[k].text,
              seconds);
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++)
        check(!cw_sun_parse_time(bad[k], &seconds), "'%s' is accepted as a time", bad[k]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(metres_in_a_degree), cmocka_unit_test(units_of_a_map),
                                       cmocka_unit_test(exact_directions), cmocka_unit_test(sun_of_an_almanac),
                                       cmocka_unit_test(times)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
