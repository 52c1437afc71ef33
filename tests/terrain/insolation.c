/* SPDX-License-Identifier: Apache-2.0 */
/* Hours and energy of sunlight, and the sky over leaning ground, against almanacs, closed forms, numbers worked out by hand
 * from the published formulas, and sums of single shadows. */

#include "insolation.h"
#include "cellwalk_expert.h"

#include "clear_sky.h"
#include "ground.h"
#include "normal.h"

#include <string.h>

static const double degree = 0.017453292519943295, pi = 3.141592653589793;

enum { SIDE = 49, MIDDLE = SIDE / 2, SAMPLES = SIDE * SIDE, SUNS_MOST = 3 * 1440 };

/* shape: rise eastward and northward, height in the south-west corner. */
static double plane(const double *shape, double x, double y) { return shape[0] * x + shape[1] * y + shape[2]; }

/* shape: y, height: a wall from west to east on level ground. */
static double wall(const double *shape, double x, double y) {
    (void)x;
    return y == shape[0] ? shape[1] : 0;
}

static double land(const double *shape, double x, double y) {
    return shape[0] + 90 * sin(x / 61 + 1) * cos(y / 47) + 9 * sin(x / 13 + y / 17);
}

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

/* Suns of a day that stand within 60 degrees of the south: those whose rays meet a wall at row MIDDLE from less than MIDDLE / tan
 * 60 degrees = 13.9 rows north of it. */
enum { BEHIND = 13 };
static size_t southern_suns(sun_position *suns) {
    const size_t count = suns_of("2024-03-20T00:00:00Z", 1, 15, 0, 50, suns);
    size_t kept = 0;
    for (size_t k = 0; k < count; k++)
        if (fabs(suns[k].azimuth - 180) < 60) suns[kept++] = suns[k];
    return kept;
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

static void direct_of(ground *g, const insolation_desc *desc, float *energy) {
    insolation *s = sum_of(g, desc);
    check_status(cw_insolation_direct(s, NULL, (cw_area){0}, energy), CW_OK);
    cw_insolation_destroy(s);
}

static double azimuth_of(const ground *g, const cw_horizon *h, size_t number) {
    static double azimuths[360];
    assert_true(h->count <= 360);
    check_status(cw_horizon_azimuths(&g->terrain, h, azimuths), CW_OK);
    return azimuths[number];
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
        /* London, longest and shortest day; Quito at the equinox; Reykjavik in midsummer. */
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

/* A wall of 55 m, and the altitude in degrees up to which it hides a sun from a sample so many rows north of it. */
static const double wall_shape[2] = {-10 * MIDDLE, 55};
static double wall_top(const sun_position *sun, size_t north) {
    return atan(wall_shape[1] * cos((sun->azimuth - 180) * degree) / (10 * (double)north)) / degree;
}

/* The wall in the south lets in the sun where that stands higher than its top. */
static void hours_behind_a_wall(void **state) {
    (void)state;
    static sun_position suns[SUNS_MOST];
    static float hours[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, wall, wall_shape);
    const size_t count = southern_suns(suns);
    hours_of(&g, &(insolation_desc){.suns = suns, .count = count, .hours = 0.25, .linke = 3}, hours);
    size_t shadows = 0;
    for (size_t north = 1; north <= BEHIND; north++) {
        double wanted = 0;
        for (size_t k = 0; k < count; k++) {
            const bool lit = suns[k].altitude > wall_top(&suns[k], north);
            wanted += lit;
            shadows += !lit;
        }
        const float got = hours[(MIDDLE - north) * SIDE + MIDDLE];
        check((double)got == wanted / 4, "%zu rows north: %g h, not %g", north, (double)got, wanted / 4);
    }
    check(shadows > 100, "%zu shadows", shadows);
    ground_free(&g);
}

/* Exact sums are those of single shadows; suns that share a direction get what single shadows of suns in that direction get,
 * bit for bit. Hence the horizon between two suns decides as the shadow does. */
static void sums_of_shadows(void **state) {
    (void)state;
    enum { DAYS = 3, MINUTES = 20 };
    static sun_position suns[SUNS_MOST];
    static float hours[SAMPLES];
    static uint8_t lit[SAMPLES];
    const double shape[1] = {400};
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    g.z[7 * SIDE + 9] = NAN;
    ground_change(&g);
    const size_t count = suns_of("2024-05-01T00:00:00Z", DAYS, MINUTES, 7, 47, suns);
    for (size_t directions = 0; directions <= 90; directions += 45) {
        static float wanted[SAMPLES];
        memset(wanted, 0, sizeof wanted);
        for (size_t k = 0; k < count; k++) {
            if (suns[k].altitude <= 0) continue;
            const double turn = directions > 0 ? 360 / (double)directions : 0;
            const cw_light desc = {.azimuth = turn > 0
                                                  ? fmod(nearbyint(suns[k].azimuth / turn), (double)directions) * turn
                                                  : suns[k].azimuth,
                                   .altitude = suns[k].altitude};
            check_status(cw_shadow(&g.terrain, NULL, &desc, (cw_area){0}, lit), CW_OK);
            for (size_t m = 0; m < SAMPLES; m++) wanted[m] += lit[m] == 1;
        }
        const insolation_desc desc = {.suns = suns, .count = count, .hours = 0.5, .linke = 3, .directions = directions};
        hours_of(&g, &desc, hours);
        size_t differ = 0;
        for (size_t m = 0; m < SAMPLES; m++) {
            const bool hole = m == 7 * SIDE + 9;
            check(hole ? isnan(hours[m]) : hours[m] == wanted[m] / 2, "%zu, %zu directions: %g, not %g", m, directions,
                  (double)hours[m], (double)wanted[m] / 2);
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

/* The direct light on a plane is that facing the sun times the cosine, for each sun that is before the plane. A sum is off by
 * 0.006 W/m² of each sun for the heights between levels, and by rounding: cosines by 2^-21, from slopes that are off by 6 10^-6
 * (heights of up to 3000 m are rounded by 1.2 10^-4, differences over 10 m so by 2.4 10^-5 before the mean of six). */
static void energy_on_a_plane(void **state) {
    (void)state;
    static const double shapes[3][3] = {{0, 0, 0}, {0.3, -0.4, 1234}, {-1, 0.5, 2500}};
    static sun_position suns[SUNS_MOST];
    static float energy[SAMPLES];
    const double hours = 0.25, linke = 2.7;
    const size_t count = suns_of("2024-04-10T00:00:00Z", 1, 15, 0, 46, suns);
    for (size_t n = 0; n < 3; n++) {
        const double *s = shapes[n];
        ground g;
        ground_make(&g, SIDE, SIDE, plane, s);
        const insolation_desc desc = {.suns = suns, .count = count, .hours = hours, .linke = linke};
        direct_of(&g, &desc, energy);
        for (size_t j = 1; j + 1 < SIDE; j += 5)
            for (size_t i = 1; i + 1 < SIDE; i += 5) {
                double wanted = 0, slack = 0;
                for (size_t k = 0; k < count; k++) {
                    if (suns[k].altitude <= 0) continue;
                    const double level = cos(suns[k].altitude * degree), a = suns[k].azimuth * degree;
                    const double cosine =
                        (sin(suns[k].altitude * degree) - s[0] * sin(a) * level - s[1] * cos(a) * level) /
                        sqrt(1 + s[0] * s[0] + s[1] * s[1]);
                    const double light =
                        cw_clear_sky_direct(linke, suns[k].distance, suns[k].altitude, (double)g.z[j * SIDE + i]);
                    if (cosine > 0) wanted += cosine * light * hours;
                    slack += (0.006 + 3e-5 * light) * hours;
                }
                const double got = (double)energy[j * SIDE + i];
                check(fabs(got - wanted) <= slack, "plane %zu at (%zu, %zu): %.9g, not %.9g, by %g", n, i, j, got,
                      wanted, slack);
            }
        ground_free(&g);
    }
}

/* Behind the wall the same suns are missing as in hours; on the level the diffuse light is the sum of the formula. */
static void energy_behind_a_wall(void **state) {
    (void)state;
    static sun_position suns[SUNS_MOST];
    static float energy[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, wall, wall_shape);
    const size_t count = southern_suns(suns);
    const insolation_desc desc = {.suns = suns, .count = count, .hours = 0.25, .linke = 3};
    direct_of(&g, &desc, energy);
    double diffuse = 0;
    for (size_t k = 0; k < count; k++)
        diffuse += cw_clear_sky_diffuse(3, suns[k].distance, suns[k].altitude - suns[k].refraction) / 4;
    for (size_t north = 2; north <= BEHIND; north++) {
        double wanted = 0;
        for (size_t k = 0; k < count; k++) {
            const double altitude = suns[k].altitude;
            if (altitude > wall_top(&suns[k], north))
                wanted += cw_clear_sky_direct(3, suns[k].distance, altitude, 0) * sin(altitude * degree) / 4;
        }
        const double got = (double)energy[(MIDDLE - north) * SIDE + MIDDLE];
        /* Level ground at a height in the table, so that nothing is interpolated. The light, the sun's height, their product and the
         * sum are rounded to floats, by 2^-24 each. */
        check(fabs(got - wanted) <= 0x1.01p-22 * wanted, "%zu rows north: %.9g Wh, not %.9g", north, got, wanted);
    }
    insolation *s = sum_of(&g, &desc);
    check(fabs(cw_insolation_diffuse(s) - diffuse) <= 1e-9 * diffuse && diffuse > 500, "%g, not %g",
          cw_insolation_diffuse(s), diffuse);
    cw_insolation_destroy(s);
    ground_free(&g);
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

/* On level ground behind a wall both sky views are the same; and against the integral, summed up over the sky in small pieces
 * from the horizon's angles, on land that leans. Pieces of angle e are off by e times the steepness of what is summed, which
 * is at most 2 in each direction. */
static void sky_over_land(void **state) {
    (void)state;
    enum { DIRECTIONS = 16, PIECES = 2000 };
    static float share[SAMPLES], angle[DIRECTIONS][SAMPLES], east[SIDE], north[SIDE];
    const double shape[1] = {0};
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    const cw_horizon h = {.count = DIRECTIONS};
    cw_horizon tilted = h;
    tilted.flags = CW_HORIZON_TILTED;
    check_status(cw_sky_view(&g.terrain, NULL, &tilted, (cw_area){0}, share), CW_OK);
    for (size_t d = 0; d < DIRECTIONS; d++)
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, angle[d], NULL), CW_OK);
    const double piece = pi / 2 / PIECES;
    double leaning = 0;
    for (size_t j = 4; j < SIDE; j += 13) {
        cw_terrain_slope_row(&g.terrain, j, 0, SIDE, east, north);
        for (size_t i = 4; i < SIDE; i += 13) {
            double sum = 0;
            const double up = 1 / sqrt(1 + (double)(east[i] * east[i] + north[i] * north[i]));
            for (size_t d = 0; d < DIRECTIONS; d++) {
                const double a = azimuth_of(&g, &h, d) * degree;
                const double slope = (double)east[i] * sin(a) + (double)north[i] * cos(a);
                for (size_t k = 0; k < PIECES; k++) {
                    const double x = ((double)k + 0.5) * piece, cosine = up * (sin(x) - slope * cos(x));
                    if (x > (double)angle[d][j * SIDE + i] * degree && cosine > 0)
                        sum += cosine * cos(x) * piece * 2 / DIRECTIONS;
                }
            }
            check(fabs((double)share[j * SIDE + i] - sum) < 2 * piece + 1e-5, "(%zu, %zu): %g, not %g", i, j,
                  (double)share[j * SIDE + i], sum);
            leaning = fmax(leaning, acos(up) / degree);
        }
    }
    check(leaning > 30, "the land leans by %g degrees", leaning);
    ground_free(&g);
}

/* In blocks, on threads and by every kernel: the same bits. */
static void same_bits(void **state) {
    (void)state;
    static sun_position suns[SUNS_MOST];
    static float want[3][SAMPLES], got[SAMPLES];
    const double shape[1] = {900};
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    cw_pool *pool = NULL;
    check_status(cw_pool_create(3, &pool), CW_OK);
    const size_t count = suns_of("2024-10-01T00:00:00Z", 2, 30, 11, 46, suns);
    static const char *const names[] = {"pyramid1", "pyramid4", "pyramid8", "pyramid16"};
    for (size_t k = 0; k < 8; k++) {
        cw_run query = (cw_run){0};
        query.expert.kernel = cw_kernel_find(names[k / 2]);
        query.pool = k % 2 ? pool : NULL;
        if (query.expert.kernel == NULL || !cw_kernel_describe(query.expert.kernel).available) continue;
        const insolation_desc desc = {
            .suns = suns, .count = count, .hours = 0.5, .linke = 3, .curvature = 1, .directions = 100};
        insolation *s = sum_of(&g, &desc);
        const cw_horizon h = {.count = 9, .flags = CW_HORIZON_TILTED};
        const size_t rows = k ? 13 : SIDE;
        for (int product = 0; product < 3; product++) {
            float *to = k ? got : want[product];
            for (size_t j = 0; j < SIDE; j += rows) {
                const size_t n = SIDE - j < rows ? SIDE - j : rows;
                float *at = to + j * SIDE;
                const cw_area area = {{0, j, SIDE, n}, 0};
                check_status(product == 0   ? cw_insolation_hours(s, &query, area, at)
                             : product == 1 ? cw_insolation_direct(s, &query, area, at)
                                            : cw_sky_view(&g.terrain, &query, &h, area, at),
                             CW_OK);
            }
            if (k)
                check(memcmp(got, want[product], sizeof got) == 0, "product %d differs by %s", product, names[k / 2]);
        }
        cw_insolation_destroy(s);
    }
    cw_pool_destroy(pool);
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(day_of_an_almanac), cmocka_unit_test(hours_behind_a_wall),
        cmocka_unit_test(sums_of_shadows),   cmocka_unit_test(light_by_hand),
        cmocka_unit_test(energy_on_a_plane), cmocka_unit_test(energy_behind_a_wall),
        cmocka_unit_test(sky_over_a_plane),  cmocka_unit_test(sky_over_land),
        cmocka_unit_test(same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
