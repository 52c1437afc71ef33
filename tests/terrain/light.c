/* SPDX-License-Identifier: Apache-2.0 */
/* Shadow, horizon and the sun's disc on land of many kinds: against rays that the library's queries trace one by one, against lines of
 * sight, and against closed forms. */

#include "compass.h"
#include "ground.h"

#include <string.h>

enum { SIDE = 97, MIDDLE = SIDE / 2, SAMPLES = SIDE * SIDE };

static void lit_of(ground *g, double azimuth, double altitude, uint8_t *lit) {
    const cw_light light = {.azimuth = azimuth, .altitude = altitude};
    check_status(cw_shadow(&g->terrain, NULL, &light, (cw_area){0}, lit), CW_OK);
}

static void share_of(ground *g, const cw_light *light, const cw_run *run, float *share) {
    check_status(cw_sunlight(&g->terrain, run, light, (cw_area){0}, share), CW_OK);
}

/* A long wall as high as the middle of the sun hides half of it, and more or less by a segment of the disc. The sum over
 * strips of the disc, in which the part that is seen falls from the middle strip outward, is off by no more than half of the
 * largest strip's share on each side. */
static void wall_before_the_disc(void **state) {
    (void)state;
    const double shape[2] = {-10 * MIDDLE, 50}, radius = 2;
    static float share[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, wall, shape);
    size_t cases = 0;
    for (unsigned strips = 4; strips <= 64; strips *= 4) {
        const double largest = 4 / (3.141592653589793 * strips);
        for (size_t south = 4; south < 40; south += 7) {
            const size_t at = (MIDDLE + south) * SIDE + MIDDLE;
            const double top = atan(shape[1] / (10 * (double)south)) / degree;
            for (double u = -1.25; u <= 1.25; u += 0.25) { /* the wall's top over the sun's middle, in radii */
                if (!test_takes(cases++, 7)) continue;
                share_of(&g, &(cw_light){.altitude = top - u * radius, .radius = radius, .strips = strips}, NULL,
                         share);
                const double v = fmin(fmax(u, -1), 1), seen = (acos(v) - v * sqrt(1 - v * v)) / 3.141592653589793;
                /* Away from the middle the wall is farther off: by 1 / cos of 2 degrees over cos of the altitude. */
                check(fabs((double)share[at] - seen) <= largest + 0.04,
                      "%u strips, %zu cells south of the wall, %g radii: %g, not %g", strips, south, u,
                      (double)share[at], seen);
            }
        }
    }
    ground_free(&g);
}

static void hillshade_of_a_plane(void **state) {
    (void)state;
    const double shape[3] = {0.3, 0.4, 0};
    static float share[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, plane, shape);
    for (double azimuth = 0; azimuth < 360; azimuth += 30) {
        const double altitude = 50, level = cos(altitude * degree);
        share_of(&g, &(cw_light){.azimuth = azimuth, .altitude = altitude, .hillshade = true}, NULL, share);
        const double cosine = (sin(altitude * degree) - shape[0] * sin(azimuth * degree) * level -
                               shape[1] * cos(azimuth * degree) * level) /
                              sqrt(1 + shape[0] * shape[0] + shape[1] * shape[1]);
        /* Heights of up to 700 m are rounded by 3 10^-5, differences over 10 m so by 6 10^-6 of a slope. */
        for (size_t k = 0; k < SAMPLES; k++)
            check(fabs((double)share[k] - cosine) < 1e-5, "%zu from %g: %.9g, not %.9g", k, azimuth, (double)share[k],
                  cosine);
    }
    ground_free(&g);
}

/* shape: x up to which the ground is level, before it falls by 1000 m. */
static double cliff(const double *shape, double x, double y) {
    (void)y;
    return x <= shape[0] ? 0 : -1000;
}

/* At the edge of a cliff the sun is seen, but the mean of the triangles faces away from it: no light, and not less. */
static void no_light_from_behind(void **state) {
    (void)state;
    const double shape[1] = {10 * MIDDLE};
    const cw_light sun = {.azimuth = 270, .altitude = 10, .hillshade = true};
    static float share[SAMPLES];
    static uint8_t lit[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, cliff, shape);
    lit_of(&g, sun.azimuth, sun.altitude, lit);
    share_of(&g, &sun, NULL, share);
    for (size_t j = 0; j < SIDE; j++) {
        const size_t edge = j * SIDE + MIDDLE;
        check(lit[edge] == 1 && share[edge] == 0, "row %zu: %g at the edge", j, (double)share[edge]);
        check(share[edge - 1] > 0, "row %zu: %g before the edge", j, (double)share[edge - 1]);
    }
    ground_free(&g);
}

/* shape: x, y, radius, depth: a round pit. */
static double pit(const double *shape, double x, double y) {
    return hypot(x - shape[0], y - shape[1]) < shape[2] ? 0 : shape[3];
}

/* Slopes and steps that shade themselves and each other, and random land. */
static void make_any(ground *g, size_t number, random_state *r) {
    enum { FORMULAS = 5 };
    static const struct {
        ground_height *height;
        double shape[4];
    } known[FORMULAS] = {{land, {0.7}},
                         {plane, {0.25, -0.5, 0}},
                         {pit, {10 * MIDDLE, -10 * MIDDLE, 300, 170}},
                         {cliff, {10 * MIDDLE}},
                         {wall, {-10 * MIDDLE, 50}}};
    const size_t kind = number % (FORMULAS + WRONG);
    if (kind < FORMULAS)
        ground_make(g, SIDE, SIDE, known[kind].height, known[kind].shape);
    else
        ground_rough(g, SIDE, SIDE, (roughness)(kind - FORMULAS), r, ground_map);
}

/* 1: something hides the sun from a sample, 0: nothing does, -1: the horizon is so close to the sun that rounding may decide, or there
 * are holes, beside which edges without a triangle are ground to horizons and nothing to rays. At night
 * the land's rim hides it too: from a height z a free horizon has the dip acos(R / (R + z)). */
static int is_hidden(const ground *g, size_t i, size_t j, double azimuth, double altitude, double horizon) {
    const double z = (double)g->z[j * SIDE + i];
    if (altitude < 0 && z <= g->terrain.radius * (1 / cos(altitude * degree) - 1)) return 1;
    if (fabs(horizon - altitude) < 0.1) return -1;
    /* Lifted by 2 mm, which is far above what rounding does to heights of 300 m. An edge is at least 7 m away, where 0.1 degrees are
     * 12 mm. */
    double sine, cosine;
    cw_terrain_sine_cosine(azimuth, &sine, &cosine); /* a ray along the rim stays on it */
    const cw_ray ray = {.org = {(float)i, (float)j, (float)z + 2e-3f},
                        .dir = {(float)sine, (float)-cosine, (float)(tan(altitude * degree) * GROUND_CELL)},
                        .tmax = INFINITY};
    uint8_t hit;
    check_status(cw_occluded(g->field, NULL, &ray, 1, &hit), CW_OK);
    return hit == 0 && cw_field_describe(g->field).holes > 0 ? -1 : hit;
}

/* Against the horizon, also on a curved earth, and against what the library's queries say of rays. Holes are no ground. */
static void shadow_agrees_with_horizon_and_rays(void **state) {
    (void)state;
    static uint8_t lit[SAMPLES];
    static float angles[SAMPLES];
    size_t shadows = 0, nights = 0;
    random_state r = {11};
    for (size_t n = 0; n < 60; n++) {
        const double azimuth = n % 4 ? random_between(&r, 0, 360) : 45 * (double)(n / 4),
                     altitude = n % 7 ? random_between(&r, 1, 40) : random_between(&r, -1.5, 0),
                     curvature = n % 5 == 1 && altitude > 0 ? 3000 : 0;
        if (!test_takes(n, 15)) continue;
        ground g;
        make_any(&g, n, &r);
        const cw_light light = {.azimuth = azimuth, .altitude = altitude, .curvature = curvature};
        const cw_horizon h = {.start = azimuth, .count = 1, .curvature = curvature};
        check_status(cw_shadow(&g.terrain, NULL, &light, (cw_area){0}, lit), CW_OK);
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, angles, NULL), CW_OK);
        for (size_t k = 0; k < SAMPLES; k++) {
            if (isnan(g.z[k])) {
                check(lit[k] == 255 && isnan(angles[k]), "hole %zu: lit %d, %g", k, lit[k], (double)angles[k]);
                continue;
            }
            const double horizon = isnan(angles[k]) ? -90 : (double)angles[k];
            if (altitude > 0 && fabs(horizon - altitude) > 1e-3)
                check((lit[k] == 0) == (horizon > altitude), "land %zu, sample %zu: horizon at %g, sun at %g, %s", n, k,
                      horizon, altitude, lit[k] ? "lit" : "in the shadow");
            const int hidden = curvature > 0 ? -1 : is_hidden(&g, k % SIDE, k / SIDE, azimuth, altitude, horizon);
            check(hidden < 0 || hidden == 1 - lit[k], "land %zu, sample %zu, sun at %g, %g: a ray says %d, lit is %d",
                  n, k, azimuth, altitude, hidden, lit[k]);
            shadows += lit[k] == 0;
            nights += altitude < 0 && lit[k] == 1;
        }
        ground_free(&g);
    }
    check(shadows > 100 && (nights > 0 || test_divisor() > 1), "%zu shadows, %zu lit by night", shadows, nights);
}

/* A sample away from the border, and the line from it in a direction of the horizon, out of the terrain. */
typedef struct outlook {
    size_t i, j;
    double eye[3], end[2], far; /* far: metres */
    double dir[2], length;      /* a step, and how many metres it is long */
} outlook;

static outlook random_outlook(const ground *g, random_state *r, double azimuth, double max_distance) {
    outlook o = {.i = 1 + random_below(r, SIDE - 2), .j = 1 + random_below(r, SIDE - 2)};
    o.eye[0] = (double)o.i;
    o.eye[1] = (double)o.j;
    o.eye[2] = (double)g->z[o.j * SIDE + o.i];
    o.length = cw_terrain_direction(&g->terrain, o.eye[0], o.eye[1], azimuth, o.dir);
    double steps = max_distance > 0 ? max_distance / o.length : INFINITY;
    for (int a = 0; a < 2; a++) steps = fmin(steps, ((o.dir[a] > 0 ? SIDE - 1 : 0) - o.eye[a]) / o.dir[a] + 1);
    for (int a = 0; a < 2; a++) o.end[a] = o.eye[a] + steps * o.dir[a];
    o.far = steps * o.length;
    return o;
}

/* On a curved earth, and as far as one looks: what lines of sight see, which are followed in double. The earth is made so much
 * rounder that it hides what is far.
 *
 * A heading lowers each crossing, a line of sight the samples beside it. On an edge of at most L = 10 √2 m that differs by up
 * to curvature (L / 2)² / 2 R metres; the nearest crossing is L / 2 away: an angle of curvature L / 4 R.
 *
 * On a flat earth the surface rises as steeply at the horizon's distance. That is rounded to a float, by 2^-24 of
 * itself at most; slopes of surface and line are below 4 together, so that the rise is off by 2^-22. */
static void horizons_are_those_of_lines(void **state) {
    (void)state;
    const double shape[1] = {1.1};
    static const double curvatures[] = {0, 200, 5000}, distances[] = {0, 61.7, 333.3};
    const size_t places = test_share(300, 60);
    static float angles[SAMPLES], metres[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    random_state r = {77};
    size_t differ = 0, found = 0, near = 0;
    for (size_t k = 0; k < 9; k++) {
        const cw_horizon h = {
            .start = 11, .count = 5, .max_distance = distances[k % 3], .curvature = curvatures[k / 3]};
        const double allowed = 1e-3 + h.curvature * GROUND_CELL * sqrt(2) / (4 * g.terrain.radius) / degree;
        for (uint32_t d = 0; d < h.count; d++) {
            check_status(cw_horizon_angles(&g.terrain, NULL, &h, d, (cw_area){0}, angles, metres), CW_OK);
            for (size_t n = 0; n < places; n++) {
                const outlook o = random_outlook(&g, &r, azimuth_of(&g, &h, d), h.max_distance);
                const double got = (double)angles[o.j * SIDE + o.i], way = (double)metres[o.j * SIDE + o.i];
                sight s;
                cw_sight_init(&s, &g.terrain, g.bounds, o.eye, h.curvature);
                const double steepest = cw_sight_steepest(&s, o.end[0], o.end[1], -INFINITY).steepest / o.far,
                             wanted = atan(steepest) / degree;
                check(steepest == -INFINITY ? isnan(got) : fabs(got - wanted) < allowed,
                      "(%zu, %zu), %g degrees, curvature %g, up to %g m: %g, not %g", o.i, o.j, azimuth_of(&g, &h, d),
                      h.curvature, h.max_distance, got, wanted);
                if (h.curvature > 0) {
                    cw_sight_init(&s, &g.terrain, g.bounds, o.eye, 0);
                    differ += cw_sight_steepest(&s, o.end[0], o.end[1], -INFINITY).steepest / o.far != steepest;
                    continue;
                }
                const double cells = way / o.length, last = SIDE - 1, x = o.eye[0] + cells * o.dir[0],
                             y = o.eye[1] + cells * o.dir[1];
                const double top = cw_terrain_height(&g.terrain, fmin(fmax(x, 0), last), fmin(fmax(y, 0), last));
                check(fabs((top - o.eye[2]) / way - steepest) < 0x1p-22,
                      "(%zu, %zu), %g degrees: %g m away the rise is %.9g, the steepest %.9g", o.i, o.j,
                      azimuth_of(&g, &h, d), way, (top - o.eye[2]) / way, steepest);
                check(h.max_distance == 0 || way <= h.max_distance * (1 + 0x1p-19), "%g m", way);
                found++;
                near += way < 100;
            }
        }
    }
    check(differ > 3 * places, "curvature changes %zu horizons", differ);
    check(near > found / 9 && found - near > found / 9, "%zu of %zu are near", near, found);
    ground_free(&g);
}

/* shape: x of an eye. Walls 8 and 16 cells east of it, the second one twice as high. */
static double equal_walls(const double *shape, double x, double y) {
    (void)y;
    return x == shape[0] + 80 ? 20 : x == shape[0] + 160 ? 40 : 0;
}

/* Of equal rises the nearest is the horizon. From the eye 64 steps lead out of the field, so that no share of the way is rounded. East of
 * the last column there is no terrain, and so no horizon. */
static void nearest_of_equal_horizons(void **state) {
    (void)state;
    enum { EYE = SIDE - 64 };
    const double shape[1] = {10 * EYE};
    static float angles[SAMPLES], metres[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, equal_walls, shape);
    const cw_horizon h = {.start = 90, .count = 1};
    check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, angles, metres), CW_OK);
    for (size_t j = 0; j < SIDE; j++) {
        const size_t eye = j * SIDE + EYE, last = j * SIDE + SIDE - 1;
        check(metres[eye] == 80, "%g m", (double)metres[eye]);
        check(isnan(angles[last]) && isnan(metres[last]), "row %zu: a horizon beyond the terrain", j);
    }
    ground_free(&g);
}

static void degrees_of_tangents(void **state) {
    (void)state;
    random_state r = {5};
    const size_t tangents = test_share(1000000, 20000);
    for (size_t n = 0; n < tangents; n++) {
        const float x = (float)(random_between(&r, -1, 1) * pow(2, random_between(&r, -30, 30)));
        check(fabs((double)cw_horizon_degrees(x) - atan((double)x) / degree) < 1e-5, "%a: %g", (double)x,
              (double)cw_horizon_degrees(x));
    }
    assert_true(cw_horizon_degrees(INFINITY) == 90 && cw_horizon_degrees(-INFINITY) == -90 &&
                cw_horizon_degrees(0) == 0);
    assert_true(isnan(cw_horizon_degrees(NAN)));
}

static void holes_are_no_ground(void **state) {
    (void)state;
    const double shape[2] = {-10 * MIDDLE, 1000};
    static uint8_t lit[SAMPLES];
    static float share[SAMPLES], angles[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, wall, shape);
    for (size_t i = 0; i < SIDE; i++) g.z[MIDDLE * SIDE + i] = NAN; /* the wall is not there */
    ground_change(&g);
    lit_of(&g, 0, 20, lit);
    share_of(&g, &(cw_light){.altitude = 20, .radius = 0.3, .hillshade = true}, NULL, share);
    const cw_horizon h = {.start = 0, .count = 4};
    check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, angles, NULL), CW_OK);
    for (size_t k = 0; k < SAMPLES; k++) {
        const bool hole = k / SIDE == MIDDLE;
        assert_int_equal(lit[k], hole ? 255 : 1);
        assert_true(hole ? isnan(share[k]) && isnan(angles[k]) : share[k] > 0.3f && !(angles[k] > 0));
    }
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wall_before_the_disc),        cmocka_unit_test(hillshade_of_a_plane),
        cmocka_unit_test(no_light_from_behind),        cmocka_unit_test(shadow_agrees_with_horizon_and_rays),
        cmocka_unit_test(horizons_are_those_of_lines), cmocka_unit_test(nearest_of_equal_horizons),
        cmocka_unit_test(degrees_of_tangents),         cmocka_unit_test(holes_are_no_ground),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
