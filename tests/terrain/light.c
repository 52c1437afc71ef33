/* SPDX-License-Identifier: Apache-2.0 */
/* Shadow, horizon and sky view against shapes whose answers are known in closed form, and against rays that the library's
 * queries trace one by one; the same bits for every instruction set and number of threads. */

#include "brute_sight.h"
#include "cellwalk_expert.h"
#include "ground.h"
#include "horizon.h"
#include "sight.h"
#include "workload/random.h"

#include <string.h>

static const double degree = 0.017453292519943295;

/* shape: rise eastward and northward. */
static double plane(const double *shape, double x, double y) { return shape[0] * x + shape[1] * y; }

/* shape: x, y, height, slope; level ground of height 0 around it. */
static double cone(const double *shape, double x, double y) {
    return fmax(0, shape[2] - shape[3] * hypot(x - shape[0], y - shape[1]));
}

/* shape: x, y, radius, height: a round pit with a level floor of height 0. */
static double pit(const double *shape, double x, double y) {
    return hypot(x - shape[0], y - shape[1]) < shape[2] ? 0 : shape[3];
}

/* shape: y, height: a wall from west to east on level ground. */
static double wall(const double *shape, double x, double y) {
    (void)x;
    return y == shape[0] ? shape[1] : 0;
}

static double land(const double *shape, double x, double y) {
    const double s = shape[0];
    return 200 * sin(x / 310 + s) * cos(y / 270) + 60 * sin(x / 57 + 2 * s) * sin(y / 71 + s) +
           9 * sin(x / 13 + y / 17);
}

enum { SIDE = 97, MIDDLE = SIDE / 2, SAMPLES = SIDE * SIDE };

static double azimuth_of(const ground *g, const cw_horizon *h, size_t number) {
    static double azimuths[360];
    assert_true(h->count <= 360);
    check_status(cw_horizon_azimuths(&g->terrain, h, azimuths), CW_OK);
    return azimuths[number];
}

static void lit_of(ground *g, double azimuth, double altitude, uint8_t *lit) {
    const cw_light light = {.azimuth = azimuth, .altitude = altitude};
    check_status(cw_shadow(&g->terrain, NULL, &light, (cw_area){0}, lit), CW_OK);
}

static void share_of(ground *g, const cw_light *light, const cw_run *run, float *share) {
    check_status(cw_sunlight(&g->terrain, run, light, (cw_area){0}, share), CW_OK);
}

/* A plane shades itself where the sun stands lower than it rises, and nowhere else. */
static void plane_shades_itself(void **state) {
    (void)state;
    const double shape[2] = {0.25, -0.5};
    static uint8_t lit[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, plane, shape);
    for (size_t n = 0; n < 24; n++) {
        if (!test_takes(n, 4)) continue;
        const double azimuth = 5 + 15 * (double)n;
        const double rise = shape[0] * sin(azimuth * degree) + shape[1] * cos(azimuth * degree);
        const double slope = atan(rise) / degree;
        lit_of(&g, azimuth, slope + 0.01, lit);
        /* A sun below the level is seen only from heights that explain it: 972 m for a degree. */
        for (size_t k = 0; k < SAMPLES && !(fabs(slope + 0.51) < 0.5); k++)
            check(lit[k] == (slope > 0), "%zu: %u on the plane from %g", k, lit[k], azimuth);
        lit_of(&g, azimuth, slope - 0.01, lit);
        /* All but those from which the ray leaves the field at once. */
        for (size_t j = 1; j + 1 < SIDE; j++)
            for (size_t i = 1; i + 1 < SIDE; i++)
                check(lit[j * SIDE + i] == 0, "(%zu, %zu) lit through the plane from %g", i, j, azimuth);
    }
    ground_free(&g);
}

/* On level ground the shadow of a cone that is steeper than the sun is high ends in two straight lines from the shadow of
 * its tip. Between samples the surface lies below the cone by no more than the slope times half of a cell's diagonal, and
 * above it, at its foot, by no more than the slope times the diagonal. */
static void cone_shadow(void **state) {
    (void)state;
    const double shape[4] = {10 * MIDDLE, -10 * MIDDLE, 120, 1.2}, diagonal = shape[3] * GROUND_CELL * sqrt(2);
    static uint8_t lit[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, cone, shape);
    size_t cases = 0;
    for (double azimuth = 0; azimuth < 360; azimuth += 22.5)
        for (double altitude = 15; altitude < 30; altitude += 10) {
            if (!test_takes(cases++, 5)) continue;
            size_t counts[2] = {0, 0};
            const double rise = tan(altitude * degree), q = rise / shape[3];
            lit_of(&g, azimuth, altitude, lit);
            for (size_t j = 0; j < SIDE; j++)
                for (size_t i = 0; i < SIDE; i++) {
                    const double x = 10.0 * (double)i - shape[0], y = -10.0 * (double)j - shape[1];
                    if (hypot(x, y) <= (shape[2] + diagonal) / shape[3]) continue;
                    const double sx = sin(azimuth * degree), sy = cos(azimuth * degree);
                    const double along = x * sx + y * sy, aside = fabs(x * sy - y * sx);
                    /* How far the cone rises above the ray, at most. Behind the cone is where along is less than 0. */
                    const double over = shape[2] + along * rise - shape[3] * aside * sqrt(1 - q * q);
                    const bool behind = along < -aside * q / sqrt(1 - q * q);
                    const bool got = lit[j * SIDE + i] == 1;
                    if (!behind || over < -diagonal) {
                        check(got, "(%zu, %zu) in the shadow of a cone from %g, %g", i, j, azimuth, altitude);
                        counts[1]++;
                    } else if (over > diagonal / 2) {
                        check(!got, "(%zu, %zu) lit through a cone from %g, %g", i, j, azimuth, altitude);
                        counts[0]++;
                    }
                }
            check(counts[0] > 10 && counts[1] > 1000, "the cone casts no shadow from %g, %g", azimuth, altitude);
        }
    ground_free(&g);
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
    const double shape[2] = {0.3, 0.4};
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

/* Against the horizon, and against what the library's queries say of rays. */
static void shadow_agrees_with_rays(void **state) {
    (void)state;
    const double shape[1] = {0.7};
    static uint8_t lit[SAMPLES];
    static float angles[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    size_t shadows = 0;
    random_state r = {11};
    for (size_t n = 0; n < 12; n++) {
        const double azimuth = random_between(&r, 0, 360), altitude = random_between(&r, 3, 40);
        if (!test_takes(n, 3)) continue;
        lit_of(&g, azimuth, altitude, lit);
        const cw_horizon h = {.start = azimuth, .count = 1};
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, angles, NULL), CW_OK);
        for (size_t j = 0; j < SIDE; j++)
            for (size_t i = 0; i < SIDE; i++) {
                const size_t k = j * SIDE + i;
                const double apart = (double)angles[k] - altitude;
                if (fabs(apart) > 1e-3)
                    check((lit[k] == 0) == (apart > 0), "(%zu, %zu): horizon at %g, sun at %g, %s", i, j,
                          (double)angles[k], altitude, lit[k] ? "lit" : "in the shadow");
                /* Lifted by 2 mm, which is far above what rounding does to heights of 300 m. An edge is at least 7 m away,
                 * where 0.1 degrees are 12 mm. */
                if (fabs(apart) < 0.1) continue;
                const double up = tan(altitude * degree) * GROUND_CELL;
                const cw_ray ray = {
                    .org = {(float)i, (float)j, g.z[k] + 2e-3f},
                    .dir = {(float)sin(azimuth * degree), (float)-cos(azimuth * degree), (float)up},
                    .tmax = INFINITY,
                };
                uint8_t hit;
                check_status(cw_occluded(g.field, NULL, &ray, 1, &hit), CW_OK);
                check(hit == 1 - lit[k], "(%zu, %zu): a ray says %d, lit is %d; %g off", i, j, hit, lit[k], apart);
                shadows += lit[k] == 0;
            }
    }
    check(shadows > 1000, "%zu shadows", shadows);
    ground_free(&g);
}

static void horizon_of_a_plane(void **state) {
    (void)state;
    const double shape[2] = {-0.75, 0.125};
    static float angles[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, plane, shape);
    const cw_horizon h = {.start = 0, .count = 32};
    for (size_t d = 0; d < 32; d++) {
        const double a = azimuth_of(&g, &h, d) * degree;
        const double wanted = atan(shape[0] * sin(a) + shape[1] * cos(a)) / degree;
        if (!test_takes(d, 4)) continue;
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, angles, NULL), CW_OK);
        for (size_t j = 1; j + 1 < SIDE; j++)
            for (size_t i = 1; i + 1 < SIDE; i++)
                check(fabs((double)angles[j * SIDE + i] - wanted) < 1e-3, "(%zu, %zu), %g degrees: %g, not %g", i, j,
                      azimuth_of(&g, &h, d), (double)angles[j * SIDE + i], wanted);
        /* North of the first row there is nothing, nor from the corner. */
        if (azimuth_of(&g, &h, d) == 0) assert_true(isnan(angles[5]));
        if (azimuth_of(&g, &h, d) == 315) assert_true(isnan(angles[0]));
    }
    ground_free(&g);
}

/* From the middle of a round pit the wall's top is between the last cells of the floor and the first ones of the rim. */
static void horizon_in_a_pit(void **state) {
    (void)state;
    const double shape[4] = {10 * MIDDLE, -10 * MIDDLE, 300, 170};
    static float angles[SAMPLES], share[SAMPLES];
    const size_t middle = MIDDLE * SIDE + MIDDLE;
    ground g;
    ground_make(&g, SIDE, SIDE, pit, shape);
    const double low = atan(shape[3] / (shape[2] + 10 * sqrt(2))) / degree, high = atan(shape[3] / shape[2]) / degree;
    const cw_horizon h = {.start = 3, .count = 90};
    for (size_t d = 0; d < 90; d++) {
        if (!test_takes(d, 4)) continue;
        check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, angles, NULL), CW_OK);
        const double got = (double)angles[middle];
        check(got >= low && got <= high + 1e-4, "%g degrees: %g, not %g to %g", azimuth_of(&g, &h, d), got, low, high);
    }
    check_status(cw_sky_view(&g.terrain, NULL, &h, (cw_area){0}, share), CW_OK);
    const double most = pow(cos(low * degree), 2), least = pow(cos(high * degree), 2);
    check((double)share[middle] >= least - 1e-5 && (double)share[middle] <= most + 1e-5, "sky view %g, not %g to %g",
          (double)share[middle], least, most);
    assert_true(fabsf(share[0] - 1) < 1e-5f); /* on the rim */
    ground_free(&g);
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
 * to curvature (L / 2)² / 2 R metres; the nearest crossing is L / 2 away: an angle of curvature L / 4 R. */
static void curvature_and_distance(void **state) {
    (void)state;
    const double shape[1] = {1.1};
    static const double curvatures[] = {0, 200, 5000}, distances[] = {0, 61.7, 333.3};
    const size_t places = test_share(300, 60);
    static float angles[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    random_state r = {77};
    size_t differ = 0;
    for (size_t k = 0; k < 9; k++) {
        const cw_horizon desc = {
            .start = 11, .count = 5, .max_distance = distances[k % 3], .curvature = curvatures[k / 3]};
        const cw_horizon h = desc;
        const double allowed = 1e-3 + desc.curvature * GROUND_CELL * sqrt(2) / (4 * g.terrain.radius) / degree;
        for (uint32_t d = 0; d < desc.count; d++) {
            check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, angles, NULL), CW_OK);
            for (size_t n = 0; n < places; n++) {
                const outlook o = random_outlook(&g, &r, azimuth_of(&g, &h, d), desc.max_distance);
                sight s;
                cw_sight_init(&s, &g.terrain, g.bounds, o.eye, desc.curvature);
                const sight_rise rise = cw_sight_steepest(&s, o.end[0], o.end[1], -INFINITY);
                const double wanted = atan(rise.steepest / o.far) / degree;
                const double got = (double)angles[o.j * SIDE + o.i];
                check(rise.steepest == -INFINITY ? isnan(got) : fabs(got - wanted) < allowed,
                      "(%zu, %zu), %g degrees, curvature %g, up to %g m: %g, not %g", o.i, o.j, azimuth_of(&g, &h, d),
                      desc.curvature, desc.max_distance, got, wanted);
                cw_sight_init(&s, &g.terrain, g.bounds, o.eye, 0);
                differ += cw_sight_steepest(&s, o.end[0], o.end[1], -INFINITY).steepest != rise.steepest;
            }
        }
    }
    check(differ > 3 * places, "curvature changes %zu horizons", differ);
    ground_free(&g);
}

/* At that distance the surface rises as steeply as the steepest of all edges. The distance is rounded to a float, by 2^-24 of
 * itself at most; slopes of surface and line are below 4 together, so that the rise is off by 2^-22. */
static void distances_of_horizons(void **state) {
    (void)state;
    const double shape[1] = {1.1};
    static const double distances[] = {0, 61.7, 333.3};
    const size_t places = test_share(60, 15);
    static float metres[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    random_state r = {78};
    size_t found = 0, near = 0;
    for (size_t k = 0; k < 3; k++) {
        const cw_horizon desc = {.start = 11, .count = 5, .max_distance = distances[k]};
        const cw_horizon h = desc;
        for (uint32_t d = 0; d < desc.count; d++) {
            if (!test_takes(k * desc.count + d, 4)) continue;
            check_status(cw_horizon_angles(&g.terrain, NULL, &h, (uint32_t)d, (cw_area){0}, NULL, metres), CW_OK);
            for (size_t n = 0; n < places; n++) {
                const outlook o = random_outlook(&g, &r, azimuth_of(&g, &h, d), desc.max_distance);
                sight s;
                cw_sight_init(&s, &g.terrain, g.bounds, o.eye, 0);
                const double steepest = brute_steepest(&s, o.end[0], o.end[1]) / o.far;
                const double way = (double)metres[o.j * SIDE + o.i], cells = way / o.length, last = SIDE - 1;
                const double x = fmin(fmax(o.eye[0] + cells * o.dir[0], 0), last),
                             y = fmin(fmax(o.eye[1] + cells * o.dir[1], 0), last);
                const double top = cw_terrain_height(&g.terrain, x, y);
                check(fabs((top - o.eye[2]) / way - steepest) < 0x1p-22,
                      "(%zu, %zu), %g degrees: %g m away the rise is %.9g, the steepest %.9g", o.i, o.j,
                      azimuth_of(&g, &h, d), way, (top - o.eye[2]) / way, steepest);
                check(desc.max_distance == 0 || way <= desc.max_distance * (1 + 0x1p-19), "%g m", way);
                found++;
                near += way < 100;
            }
        }
    }
    check(near > found / 9 && found - near > found / 9, "%zu of %zu are near", near, found);
    ground_free(&g);
}

/* shape: x of an eye. Walls 8 and 16 cells east of it, the second one twice as high. */
static double equal_walls(const double *shape, double x, double y) {
    (void)y;
    return x == shape[0] + 80 ? 20 : x == shape[0] + 160 ? 40 : 0;
}

/* Of equal rises the nearest is the horizon. From the eye 64 steps lead out of the field, so that no share of the way is rounded. */
static void nearest_of_equal_horizons(void **state) {
    (void)state;
    enum { EYE = SIDE - 64 };
    const double shape[1] = {10 * EYE};
    static float metres[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, equal_walls, shape);
    const cw_horizon h = {.start = 90, .count = 1};
    check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, NULL, metres), CW_OK);
    for (size_t j = 0; j < SIDE; j++) check(metres[j * SIDE + EYE] == 80, "%g m", (double)metres[j * SIDE + EYE]);
    ground_free(&g);
}

/* The sun over a curved earth: in the shadow is what sees a horizon at least as high. */
static void shadow_on_a_curved_earth(void **state) {
    (void)state;
    const double shape[1] = {0.7};
    static uint8_t lit[SAMPLES];
    static float angles[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    const cw_horizon h = {.start = 200, .count = 1, .curvature = 3000};
    const cw_light light = {.azimuth = 200, .altitude = 7, .curvature = 3000};
    check_status(cw_horizon_angles(&g.terrain, NULL, &h, 0, (cw_area){0}, angles, NULL), CW_OK);
    check_status(cw_shadow(&g.terrain, NULL, &light, (cw_area){0}, lit), CW_OK);
    size_t dark = 0;
    for (size_t k = 0; k < SAMPLES; k++) {
        check(fabs((double)angles[k] - 7) < 1e-3 || lit[k] == !(angles[k] >= 7),
              "sample %zu: lit %d, the horizon at %g", k, lit[k], (double)angles[k]);
        dark += lit[k] == 0;
    }
    check(dark > 100, "%zu in the shadow", dark);
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

/* Every instruction set, one thread and three: the same bits, also in blocks of odd numbers of rows. */
static void same_bits(void **state) {
    (void)state;
    const double shape[1] = {0.3};
    static float want[3][SAMPLES], got[SAMPLES];
    static uint8_t lit_want[SAMPLES], lit[SAMPLES];
    ground g;
    ground_make(&g, SIDE, SIDE, land, shape);
    cw_pool *pool = NULL;
    check_status(cw_pool_create(3, &pool), CW_OK);
    const cw_light disc = {.azimuth = 77, .altitude = 12, .radius = 0.27, .hillshade = true};
    const cw_light point = {.azimuth = 77, .altitude = 12};
    const char *const names[] = {"pyramid1", "pyramid4", "pyramid8", "pyramid16"};
    for (size_t k = 0; k < 8; k++) {
        cw_run query = (cw_run){0};
        query.expert.kernel = cw_kernel_find(names[k / 2]);
        query.pool = k % 2 ? pool : NULL;
        check(query.expert.kernel != NULL || k > 1, "there is no kernel %s", names[k / 2]);
        if (query.expert.kernel == NULL || !cw_kernel_describe(query.expert.kernel).available) continue;
        const cw_horizon h = {.start = 1, .count = 7};
        const size_t rows = k ? 13 : SIDE;
        for (int product = 0; product < 3; product++) {
            float *to = k ? got : want[product];
            for (size_t j = 0; j < SIDE; j += rows) {
                const size_t n = SIDE - j < rows ? SIDE - j : rows;
                const cw_area area = {{0, j, SIDE, n}, 0};
                check_status(product == 0   ? cw_sunlight(&g.terrain, &query, &disc, area, to + j * SIDE)
                             : product == 1 ? cw_horizon_angles(&g.terrain, &query, &h, 3, area, to + j * SIDE, NULL)
                                            : cw_sky_view(&g.terrain, &query, &h, area, to + j * SIDE),
                             CW_OK);
                check_status(cw_shadow(&g.terrain, &query, &point, area, (k ? lit : lit_want) + j * SIDE), CW_OK);
            }
            if (k)
                check(memcmp(got, want[product], sizeof got) == 0, "product %d differs by %s", product, names[k / 2]);
        }
        if (k) check(memcmp(lit, lit_want, sizeof lit) == 0, "shadows differ by %s", names[k / 2]);
    }
    cw_pool_destroy(pool);
    ground_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plane_shades_itself),
        cmocka_unit_test(cone_shadow),
        cmocka_unit_test(wall_before_the_disc),
        cmocka_unit_test(hillshade_of_a_plane),
        cmocka_unit_test(no_light_from_behind),
        cmocka_unit_test(shadow_agrees_with_rays),
        cmocka_unit_test(horizon_of_a_plane),
        cmocka_unit_test(horizon_in_a_pit),
        cmocka_unit_test(curvature_and_distance),
        cmocka_unit_test(distances_of_horizons),
        cmocka_unit_test(nearest_of_equal_horizons),
        cmocka_unit_test(shadow_on_a_curved_earth),
        cmocka_unit_test(degrees_of_tangents),
        cmocka_unit_test(holes_are_no_ground),
        cmocka_unit_test(same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
