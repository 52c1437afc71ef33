/* SPDX-License-Identifier: Apache-2.0 */
/* Haze, water, sky and sun of pictures of terrain by `cellwalk render`, against closed forms. */

#include "picture.h"
#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include <math.h>

/* Level land of 590 x 490 m, samples 10 m apart, and with a wall of 40 m along row 20, which is at y = 290. From 1000 m above
 * its middle a pixel of a square picture of 60 x 60 is 10 m wide on the ground. */
enum { NX = 60, NY = 50, SIDE = 60 };
#define FROM_ABOVE                                                                                                     \
    "--cellsize", "10", "--from", "295,245,1000", "--to", "295,245,0", "--fov", "33.398488467987", "--size", "60x60"

static const double sun_light = 0.85, sky_light = 0.3, ground[3] = {0.10, 0.24, 0.08}, horizon[3] = {0.70, 0.80, 0.93},
                    above[3] = {0.16, 0.34, 0.70}, plain[3] = {0.20, 0.27, 0.16}, depth[3] = {0.02, 0.08, 0.11};
static const double degree = 0.017453292519943295;

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    memset(z, 0, sizeof z);
    field_file("level.npy", z, NX, NY);
    for (size_t i = 0; i < NX; i++) z[20 * NX + i] = 40;
    field_file("wall.npy", z, NX, NY);
    z[33 * NX + 25] = NAN;
    field_file("hole.npy", z, NX, NY);
    return 0;
}

/* How far away the ground is in the middle of a pixel. */
static double way_to(size_t x, size_t y) {
    const double a = 10 * ((double)x - 29.5), b = 10 * ((double)y - 29.5);
    return sqrt(1e6 + a * a + b * b);
}

/* Of the ground's contrast 0.02^(d / V) is left. Near the middle of the picture the ways to a pixel's samples differ by 7 m times
 * 30 / 1000 at most. */
static void haze_by_distance(void **state) {
    (void)state;
    io_image image = picture((const char *const[]){"render", "level.npy", FROM_ABOVE, "--sun", "225,30", "--haze",
                                                   "2000", "-o", "o.exr", NULL});
    for (size_t y = 27; y < 33; y++)
        for (size_t x = 27; x < 33; x++) {
            const double left = pow(0.02, way_to(x, y) / 2000);
            double wanted[3];
            for (int c = 0; c < 3; c++)
                wanted[c] = left * ground[c] * (sun_light * 0.5 + sky_light) + (1 - left) * horizon[c];
            check_pixel(&image, x, y, wanted, 1, log(50) / 2000 * 0.3);
        }
    /* The sky behind has its own colour. */
    check_pixel(&image, 30, 1, horizon, 1, 0);
    io_image_free(&image);
}

/* From above: its own light, and the sky straight up. Below the ground it changes nothing. */
static void water_from_above(void **state) {
    (void)state;
    io_image image = picture((const char *const[]){"render", "wall.npy", FROM_ABOVE, "--sun", "180,45", "--water", "5",
                                                   "-o", "o.exr", NULL});
    const double light = sun_light * sqrt(0.5) + sky_light;
    for (size_t x = 2; x < 58; x += 3)
        for (size_t y = 8; y < 53; y++) {
            if (y > 22 && y < 29) continue; /* the wall, and what mirrors it */
            const double cosine = 1000 / way_to(x, y), mirrored = 0.02 + 0.98 * pow(1 - cosine, 5);
            double wanted[3];
            for (int c = 0; c < 3; c++)
                wanted[c] =
                    (1 - mirrored) * depth[c] * light + mirrored * (horizon[c] + cosine * (above[c] - horizon[c]));
            check_pixel(&image, x, y, wanted, 1, 1e-3);
        }
    /* Holes are under water too. */
    io_image same = picture((const char *const[]){"render", "hole.npy", FROM_ABOVE, "--sun", "180,45", "--water", "5",
                                                  "-o", "o.exr", NULL});
    assert_memory_equal(same.rgb + 30 * SIDE * 3, image.rgb + 30 * SIDE * 3, 20 * SIDE * 3 * sizeof *image.rgb);
    io_image_free(&same);
    const float *wall = image.rgb + (25 * SIDE + 30) * 3;
    check(wall[0] > 0.05f, "the wall is %g, %g, %g", (double)wall[0], (double)wall[1], (double)wall[2]);
    io_image_free(&image);
    static const char *const levels[] = {"--quiet", "--water=-1"};
    char *pictures[2];
    size_t size[2];
    for (size_t k = 0; k < 2; k++) {
        image = picture((const char *const[]){"render", "wall.npy", FROM_ABOVE, levels[k], "-o", "o.exr", NULL});
        io_image_free(&image);
        pictures[k] = scratch_read("o.exr", &size[k]);
    }
    assert_true(size[0] == size[1] && memcmp(pictures[0], pictures[1], size[0]) == 0);
    free(pictures[0]);
    free(pictures[1]);
}

/* A wall in the sun, in water 10 m high: its face from y = 280 to 290 rises by 4 in 1. From 10 m over the water and 120 m before the
 * place the mirrored ray, which rises by 1 in 12, meets it above the water at y = 284.255. Its colour there is between those of the
 * texels at y = 275, of the lowest ground, and at y = 285, of half the height: brown. */
static void water_mirrors_land(void **state) {
    (void)state;
    static const double brown[3] = {0.50, 0.37, 0.18};
    io_image image = picture((const char *const[]){"render", "wall.npy", "--cellsize", "10", "--from", "295,80,=20",
                                                   "--to", "295,200,=10", "--fov", "0.01", "--size", "3x3", "--sun",
                                                   "180,45", "--water", "10", "-o", "o.exr", NULL});
    const double wall = (sun_light * 5 * sqrt(0.5) + sky_light) / sqrt(17);
    const double y = (10 - 200.0 / 12 + 4 * 280) / (4 - 1.0 / 12), part = (y - 275) / 10;
    const double cosine = 10 / sqrt(10 * 10 + 120 * 120), mirrored = 0.02 + 0.98 * pow(1 - cosine, 5);
    double wanted[3];
    for (int c = 0; c < 3; c++)
        wanted[c] = mirrored * wall * (ground[c] + part * (brown[c] - ground[c])) +
                    (1 - mirrored) * depth[c] * (sun_light * sqrt(0.5) + sky_light);
    check_pixel(&image, 1, 1, wanted, 1, 0);
    io_image_free(&image);
}

/* Below the horizon the plain at the lowest ground, in haze or in air that is twelve times the terrain deep; above it a sky that
 * is brightest where the sun is. */
static void sky_and_plain(void **state) {
    (void)state;
    static const char *const air[] = {"--phong", "--haze=3000"};
    for (size_t k = 0; k < 2; k++) {
        io_image image = picture((const char *const[]){"render", "level.npy", FROM_ABOVE, "--sun", "225,30", "--sky",
                                                       air[k], "-o", "o.exr", NULL});
        for (size_t x = 0; x < SIDE; x++) {
            const double left = pow(0.02, way_to(x, 1) / (k == 0 ? 12 * 1080 : 3000));
            double wanted[3];
            for (int c = 0; c < 3; c++) wanted[c] = horizon[c] + left * (plain[c] - horizon[c]);
            check_pixel(&image, x, 1, wanted, 1, log(50) / 3000 * 7);
        }
        io_image_free(&image);
    }
    /* Up by 30 degrees to the south-west, from 45 degrees below the sun to right into it. */
    static const char *const suns[] = {"--sun=225,75", "--sun=225,30", "--sun=45,30"};
    for (size_t k = 0; k < 3; k++) {
        io_image image = picture((const char *const[]){
            "render", "level.npy", "--cellsize", "10", "--from", "295,245,=10", "--to", "195,145,=91.64965809", "--fov",
            "0.01", "--size", "3x3", "--sky", "--quiet", suns[k], "-o", "o.exr", NULL});
        const double toward = k == 0 ? sqrt(0.5) : k == 1 ? 1 : cos(120 * degree), near = fmax(toward, 0);
        const double glow = 0.15 * pow(near, 8) + 0.5 * pow(near, 128), share = 1 - 0.5 * 0.5 * 0.5;
        static const double warm[3] = {1, 0.95, 0.85};
        double wanted[3];
        for (int c = 0; c < 3; c++) {
            const double clear = horizon[c] + share * (above[c] - horizon[c]);
            wanted[c] = clear + glow * fmax(warm[c] - clear, 0);
        }
        check_pixel(&image, 1, 1, wanted, 1, 0);
        io_image_free(&image);
    }
}

/* At a time the sun is where `cellwalk shadow` says, to the digits that it prints. */
static void sun_by_time(void **state) {
    (void)state;
    static const char real[] = "/usr/lib/R/site-library/terra/ex/elev.tif", time[] = "--time=2024-06-21T07:00:00Z";
    const program_result *r = program_run(NULL, (const char *const[]){"shadow", real, time, "-o", "s.npy", NULL});
    if (r->status != 0) skip();
    double map_azimuth, altitude;
    char sun[64];
    const char *numbers = strstr(r->out, "azimuth ");
    assert_true(numbers != NULL);
    assert_int_equal(sscanf(numbers, "azimuth %*f (%lf on the map), altitude %lf", &map_azimuth, &altitude), 2);
    snprintf(sun, sizeof sun, "--sun=%.3f,%.3f", map_azimuth, altitude);
    const char *const suns[] = {time, sun, "--sun=250,30"};
    io_image pictures[3];
    double apart[3] = {0};
    for (size_t k = 0; k < 3; k++) {
        pictures[k] = picture((const char *const[]){"render", real, suns[k], "--size", "90x60", "-o", "o.exr", NULL});
        for (size_t p = 0; p < (size_t)3 * 90 * 60; p++)
            apart[k] += fabs((double)pictures[k].rgb[p] - (double)pictures[0].rgb[p]) / (3 * 90 * 60);
    }
    check(apart[1] < 1e-4 && apart[2] > 1e-3, "%g from the sun at %s, %g from another", apart[1], sun, apart[2]);
    for (size_t k = 0; k < 3; k++) io_image_free(&pictures[k]);
}

static void what_is_refused(void **state) {
    (void)state;
    check_refused((const char *const[]){"render", "level.npy", "--haze", "0", "-o", "o.exr", NULL}, 2,
                  "--haze takes a visibility in metres, above 0, not 0");
    check_refused((const char *const[]){"render", "level.npy", "--time", "noon", "-o", "o.exr", NULL}, 2, "not 'noon'");
    check_refused((const char *const[]){"render", "level.npy", "--time", "2024-06-21T12:00:00Z", "--sun", "0,9", "-o",
                                        "o.exr", NULL},
                  2, "either --sun or --time");
    check_refused((const char *const[]){"render", "level.npy", "--time", "2024-06-21T12:00:00Z", "-o", "o.exr", NULL},
                  1, "level.npy: names no coordinate system, so the sun's place at a time is not known; give --sun");
    scratch_write("s.pbrt", "WorldBegin", 10);
    check_refused((const char *const[]){"render", "s.pbrt", "--sky", "-o", "o.exr", NULL}, 2, "--sky is for rasters");
    check_refused((const char *const[]){"render", "s.pbrt", "--water", "3", "-o", "o.exr", NULL}, 2,
                  "--water is for rasters");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(haze_by_distance, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(water_from_above, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(water_mirrors_land, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sky_and_plain, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(sun_by_time, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
