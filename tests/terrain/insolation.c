/* SPDX-License-Identifier: Apache-2.0 */
/* Hours and energy of sunlight, and the sky over leaning ground, against an almanac, closed forms, numbers worked out by hand
 * from the published formulas, and sums of single shadows. */

#include "insolation.h"

#include "ground.h"
#include "normal.h"

#include <string.h>

static const double pi = 3.141592653589793;

enum { SIDE = 49, MIDDLE = SIDE / 2, SAMPLES = SIDE * SIDE, SUNS_MOST = 3 * 1440 };

/* The suns of some days from a midnight of UTC on, in the middle of steps of that many minutes. */
static size_t suns_of(const char *midnight, size_t days, size_t minutes, double longitude, double latitude,
                      sun_position *suns) {
    double start;
    assert_true(cw_sun_parse_time(midnight, &start));
    const size_t count = days * 1440 / minutes;
    assert_true(count <= SUNS_MOST);
    for (size_t k = 0; k < count; k++)
        suns[k] = cw_sun_at(start + ((double)k + 0.5) * 60 * (double)minutes, longitude, latitude);
    return count;
}

static insolation *sum_of(ground *g, const insolation_desc *desc) {
    insolation *s = NULL;
    check_status(cw_insolation_create(&g->terrain, desc, &s), CW_OK);
    return s;
}

static void hours_of(ground *g, const insolation_desc *desc, float *hours) {
    insolation *s = sum_of(g, desc);
    check_status(cw_insolation_hours(s, NULL, (cw_area){0}, hours), CW_OK);
    cw_insolation_destroy(s);
}

/* Level ground is lit from sunrise to sunset. The almanac's are those of the sun's upper rim, with a refraction of 34 minutes of
 * arc; ours of its middle, a radius of 16 minutes higher: later and earlier by that over the speed at which the sun rises,
 * 15 degrees an hour times cos(latitude) cos(declination) sin(hour angle). The almanac's times are rounded to a minute each,
 * so that its day is right to one; a sum over steps is right to one step; our refraction differs by 0.1 minutes of arc at the
 * horizon (28.98 at 0 degrees of true altitude, 34 at -0.57), hence 3 seconds, and the speed changes by less than 1 % on the
 * way. */
static void day_of_an_almanac(void **state) {
    (void)state;
    static const struct {
        const char *midnight;
        double longitude, latitude, declination, hours;
    } days[] = {
        /* London, longest and shortest day; Quito at the equinox. */
        {"2024-06-21T00:00:00Z", -0.1257, 51.5085, 23.44, 16 + 38 / 60.0},
        {"2024-12-21T00:00:00Z", -0.1257, 51.5085, -23.44, 7 + 50 / 60.0},
        {"2024-03-20T05:00:00Z", -78.52, -0.23, 0, 12 + 7 / 60.0},
    };
    static sun_position suns[SUNS_MOST];
    static float hours[SAMPLES];
    const double shape[3] = {0, 0, 0};
    ground g;
    ground_make(&g, SIDE, SIDE, plane, shape);
    for (size_t d = 0; d < sizeof days / sizeof *days; d++)
        for (size_t minutes = 1; minutes <= 15; minutes += 14) {
            const size_t count = suns_of(days[d].midnight, 1, minutes, days[d].longitude, days[d].latitude, suns);
            const double step = (double)minutes / 60, half_turn = days[d].hours * 7.5 * degree;
            const double speed =
                15 * cos(days[d].latitude * degree) * cos(days[d].declination * degree) * sin(half_turn);
            const double wanted = days[d].hours - 2 * SUN_RADIUS / speed;
            hours_of(&g, &(insolation_desc){.suns = suns, .count = count, .hours = step, .linke = 3}, hours);
            for (size_t k = 0; k < SAMPLES; k++)
                check(fabs((double)hours[k] - wanted) <= step + 1 / 60.0 + 2 * 0.01, "%s by %zu min: %g h, not %g",
                      days[d].midnight, minutes, (double)hours[k], wanted);
        }
    ground_free(&g);
}

/* The cosine of the angle between the sun and the surface's normal, from slopes eastward and northward; 0 behind the surface. */
static double facing(const sun_position *sun, double east, double north) {
    const double level = cos(sun->altitude * degree), a = sun->azimuth * degree;
    const double up = sin(sun->altitude * degree) - east * sin(a) * level - north * cos(a) * level;
    return fmax(up, 0) / sqrt(1 + east * east + north * north);
}

/* Exact sums are those of single shadows; suns that share a direction get what single shadows of suns in that direction get,
 * bit for bit. Hence the horizon between two suns decides as the shadow does. Energy is the sum of the light of suns that are seen,
 * times the cosine. It is off by 0.006 W/m² of each sun for the heights between levels, and by rounding: cosines by 2^-21, the light
 * and its product with them by eight roundings, 2^-21. The diffuse light is the sum of the formula. */
static void sums_of_shadows(void **state) {
    (void)state;
    enum { DAYS = 3, MINUTES = 20, HOLE = 7 * SIDE + 9 };
    static sun_position suns[SUNS_MOST];
    static float hours[SAMPLES], direct[SAMPLES], east[SIDE], north[SIDE];
    static double wanted[SAMPLES], energy[SAMPLES], slack[SAMPLES];
    static uint8_t lit[SAMPLES];
    const double shape[1] = {400};
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    for (size_t k = 0; k < SAMPLES; k++) g.z[k] += 900;
    g.z[HOLE] = NAN;
    ground_change(&g);
    const size_t count = suns_of("2024-05-01T00:00:00Z", DAYS, MINUTES, 7, 47, suns);
    double diffuse = 0;
    for (size_t k = 0; k < count; k++)
        diffuse += 0.5 * cw_clear_sky_diffuse(3, suns[k].distance, suns[k].altitude - suns[k].refraction);
    for (size_t directions = 0; directions <= 90; directions += 45) {
        for (size_t m = 0; m < SAMPLES; m++) wanted[m] = energy[m] = slack[m] = 0;
        for (size_t k = 0; k < count; k++) {
            if (suns[k].altitude <= 0) continue;
            const double turn = directions > 0 ? 360 / (double)directions : 0;
            const cw_light desc = {.azimuth = turn > 0
                                                  ? fmod(nearbyint(suns[k].azimuth / turn), (double)directions) * turn
                                                  : suns[k].azimuth,
                                   .altitude = suns[k].altitude};
            check_status(cw_shadow(&g.terrain, NULL, &desc, (cw_area){0}, lit), CW_OK);
            for (size_t m = 0; m < SAMPLES; m++) {
                if (m % SIDE == 0) cw_terrain_slope_row(&g.terrain, m / SIDE, 0, SIDE, east, north);
                if (lit[m] != 1) continue;
                const double light = cw_clear_sky_direct(3, suns[k].distance, suns[k].altitude, (double)g.z[m]);
                wanted[m] += 0.5;
                energy[m] += 0.5 * light * facing(&suns[k], (double)east[m % SIDE], (double)north[m % SIDE]);
                slack[m] += 0.5 * (0.006 + 0x1p-20 * light);
            }
        }
        const insolation_desc desc = {.suns = suns, .count = count, .hours = 0.5, .linke = 3, .directions = directions};
        insolation *s = sum_of(&g, &desc);
        check_status(cw_insolation_direct(s, NULL, (cw_area){0}, direct), CW_OK);
        check_status(cw_insolation_hours(s, NULL, (cw_area){0}, hours), CW_OK);
        check(fabs(cw_insolation_diffuse(s) - diffuse) <= 1e-9 * diffuse && diffuse > 500, "%g, not %g",
              cw_insolation_diffuse(s), diffuse);
        cw_insolation_destroy(s);
        size_t differ = 0;
        for (size_t m = 0; m < SAMPLES; m++) {
            check(m == HOLE ? isnan(hours[m]) : (double)hours[m] == wanted[m], "%zu, %zu directions: %g h, not %g", m,
                  directions, (double)hours[m], wanted[m]);
            check(m == HOLE ? isnan(direct[m]) : fabs((double)direct[m] - energy[m]) <= slack[m],
                  "%zu, %zu directions: %.9g Wh, not %.9g by %g", m, directions, (double)direct[m], energy[m],
                  slack[m]);
            differ += wanted[m] != wanted[0];
        }
        check(differ > SAMPLES / 2, "%zu of %d samples differ", differ, SAMPLES);
    }
    ground_free(&g);
}

/* From the published formulas with a calculator of 30 digits: linke, astronomical units, altitude with refraction, height; air
 * mass, direct light; altitude without refraction, diffuse light. */
static void light_by_hand(void **state) {
    (void)state;
    static const struct {
        double linke, distance, altitude, height, mass, direct, diffuse;
    } cases[] = {
        {3, 1, 30, 0, 1.99429285253, 800.918095209, 89.7986187764},
        {2, 0.9833, 5.5, 2000, 7.51081678533, 605.462573656, 22.3460018542},
        {4.5, 1.0167, 62.3, 350, 1.08291796033, 799.776038047, 168.460596838},
        {6.8, 1, 1.5, 0, 22.4415126997, 9.34406617092, 15.2675348468},
        {3, 1, 0.4, 4000, 20.2446973911, 165.775115119, 13.2132600102},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double mass = cw_clear_sky_air_mass(cases[k].altitude, cases[k].height);
        const double direct =
            cw_clear_sky_direct(cases[k].linke, cases[k].distance, cases[k].altitude, cases[k].height);
        const double diffuse = cw_clear_sky_diffuse(cases[k].linke, cases[k].distance, cases[k].altitude);
        check(fabs(mass / cases[k].mass - 1) < 1e-9, "%zu: air mass %.12g", k, mass);
        check(fabs(direct / cases[k].direct - 1) < 1e-9, "%zu: direct %.12g", k, direct);
        check(fabs(diffuse / cases[k].diffuse - 1) < 1e-9, "%zu: diffuse %.12g", k, diffuse);
    }
    assert_true(cw_clear_sky_direct(3, 1, 0, 0) == 0 && cw_clear_sky_direct(3, 1, -5, 0) == 0);
    assert_true(cw_clear_sky_diffuse(3, 1, -0.01) == 0);
}

/* A plane sees (1 + cos tilt) / 2 of the sky. The sum over directions is the trapezoidal rule for a periodic function whose slope
 * jumps where the plane meets the level, twice: by at most 2 tan(tilt) there, so it is off by less than
 * 2 · jump · step² / 8 / (2 π). Samples at the border see as much, but for the corners that lack neighbours. */
static void sky_over_a_plane(void **state) {
    (void)state;
    static float share[SAMPLES], level[SAMPLES];
    enum { DIRECTIONS = 180 };
    const double step = 2 * pi / DIRECTIONS;
    for (int n = 0; n < 5; n++) {
        if (!test_takes((size_t)n, 3)) continue;
        const double tilt = 15 * n * degree, shape[3] = {tan(tilt) * cos(1), tan(tilt) * sin(1), 0};
        const double wanted = (1 + cos(tilt)) / 2;
        ground g;
        ground_make(&g, SIDE, SIDE, plane, shape);
        const cw_horizon h = {.start = 0.7, .count = DIRECTIONS};
        cw_horizon tilted = h;
        tilted.flags = CW_HORIZON_TILTED;
        check_status(cw_sky_view(&g.terrain, NULL, &tilted, (cw_area){0}, share), CW_OK);
        check_status(cw_sky_view(&g.terrain, NULL, &h, (cw_area){0}, level), CW_OK);
        const double slack = 2 * 2 * tan(tilt) * step * step / 8 / (2 * pi) + 1e-5;
        for (size_t k = 0; k < SAMPLES; k++)
            check(fabs((double)share[k] - wanted) <= slack, "%d degrees, (%zu, %zu): %.7g, not %.7g by %g", 15 * n,
                  k % SIDE, k / SIDE, (double)share[k], wanted, slack);
        if (n == 0) assert_memory_equal(share, level, sizeof share);
        ground_free(&g);
    }
}

/* Against the integral, summed up over the sky in small pieces from the horizon's angles, on land that leans; as on a level, in closed
 * form: the mean of the squared cosines of those angles. Pieces of angle e are off by e times the steepness of what is summed, which
 * is at most 2 in each direction. */
static void sky_over_land(void **state) {
    (void)state;
    enum { DIRECTIONS = 16, PIECES = 2000 };
    static float share[SAMPLES], flat[SAMPLES], angle[DIRECTIONS][SAMPLES], east[SIDE], north[SIDE];
    const double shape[1] = {0};
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    const cw_horizon h = {.count = DIRECTIONS};
    cw_horizon tilted = h;
    tilted.flags = CW_HORIZON_TILTED;
    check_status(cw_sky_view(&g.terrain, NULL, &tilted, (cw_area){0}, share), CW_OK);
    check_status(cw_sky_view(&g.terrain, NULL, &h, (cw_area){0}, flat), CW_OK);
    for (size_t d = 0; d < DIRECTIONS; d++)
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, angle[d], NULL), CW_OK);
    const double piece = pi / 2 / PIECES;
    double leaning = 0;
    for (size_t j = 4; j < SIDE; j += 13) {
        cw_terrain_slope_row(&g.terrain, j, 0, SIDE, east, north);
        for (size_t i = 4; i < SIDE; i += 13) {
            double sum = 0, squares = 0;
            const double up = 1 / sqrt(1 + (double)(east[i] * east[i] + north[i] * north[i]));
            for (size_t d = 0; d < DIRECTIONS; d++) {
                const double a = azimuth_of(&g, &h, d) * degree;
                const double slope = (double)east[i] * sin(a) + (double)north[i] * cos(a);
                squares += pow(cos(fmax((double)angle[d][j * SIDE + i], 0) * degree), 2) / DIRECTIONS;
                for (size_t k = 0; k < PIECES; k++) {
                    const double x = ((double)k + 0.5) * piece, cosine = up * (sin(x) - slope * cos(x));
                    if (x > (double)angle[d][j * SIDE + i] * degree && cosine > 0)
                        sum += cosine * cos(x) * piece * 2 / DIRECTIONS;
                }
            }
            check(fabs((double)share[j * SIDE + i] - sum) < 2 * piece + 1e-5, "(%zu, %zu): %g, not %g", i, j,
                  (double)share[j * SIDE + i], sum);
            check(fabs((double)flat[j * SIDE + i] - squares) < 1e-5, "(%zu, %zu): %g, not %g", i, j,
                  (double)flat[j * SIDE + i], squares);
            leaning = fmax(leaning, acos(up) / degree);
        }
    }
    check(leaning > 30, "the land leans by %g degrees", leaning);
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(day_of_an_almanac), cmocka_unit_test(sums_of_shadows), cmocka_unit_test(light_by_hand),
        cmocka_unit_test(sky_over_a_plane),  cmocka_unit_test(sky_over_land),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
