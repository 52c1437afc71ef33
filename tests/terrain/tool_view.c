/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of terrain by `cellwalk render`: level land from straight above, whose pixels are known. */

#include "picture.h"
#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include <math.h>

/* Level land of 590 x 490 m, samples 10 m apart, with a wall of 40 m along row 20, which is at y = 290. From 1000 m above its
 * middle a pixel of a square picture of 60 x 60 is 10 m wide on the ground: the first column begins at x = -5, the first row
 * at y = 545. */
enum { NX = 60, NY = 50, SIDE = 60 };
static const char fov[] = "33.398488467987", from[] = "295,245,1000", to[] = "295,245,0";
#define FROM_ABOVE "--cellsize", "10", "--from", from, "--to", to, "--fov", fov, "--size", "60x60"

static const double light_of_sun = 0.85, light_of_sky = 0.3, ground[3] = {0.10, 0.24, 0.08},
                    sky[3] = {0.70, 0.80, 0.93};

static int enter(void **state) {
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    memset(z, 0, sizeof z);
    field_file("level.npy", z, NX, NY);
    z[33 * NX + 25] = NAN;
    field_file("hole.npy", z, NX, NY);
    z[33 * NX + 25] = 0;
    for (size_t i = 0; i < NX; i++) z[20 * NX + i] = 40;
    field_file("wall.npy", z, NX, NY);
    return 0;
}

/* Everything stands where it should, and is as bright. */
static void level_land(void **state) {
    (void)state;
    io_image image =
        picture((const char *const[]){"render", "level.npy", FROM_ABOVE, "--sun", "225,30", "-o", "o.exr", NULL});
    assert_true(image.width == SIDE && image.height == SIDE);
    for (size_t y = 0; y < SIDE; y++)
        for (size_t x = 0; x < SIDE; x++) {
            if (y < 5 || y > 54)
                check_pixel(&image, x, y, sky, 1, 0);
            else if (y > 5 && y < 54 && x > 0 && x < 59)
                check_pixel(&image, x, y, ground, light_of_sun * 0.5 + light_of_sky, 0);
        }
    io_image_free(&image);
}

/* The sun in the south, 45 degrees high: from y = 300, where the wall stands, to 330 there is shadow. */
static void shadow_of_a_wall(void **state) {
    (void)state;
    io_image image = picture(
        (const char *const[]){"render", "--dem", "wall.npy", FROM_ABOVE, "--sun", "180,45", "-o", "o.exr", NULL});
    const double lit = light_of_sun * sqrt(0.5) + light_of_sky;
    for (size_t x = 1; x < 59; x++) {
        check_pixel(&image, x, 20, ground, lit, 0);
        check_pixel(&image, x, 22, ground, light_of_sky, 0);
        check_pixel(&image, x, 23, ground, light_of_sky, 0);
        check_pixel(&image, x, 28, ground, lit, 0);
    }
    io_image_free(&image);
}

/* Colours are spread evenly from the lowest height to the highest, each in its place. Steps of a millimetre hardly lean. */
static void colours_by_height(void **state) {
    (void)state;
    static const double tints[5][3] = {
        {0.10, 0.24, 0.08}, {0.34, 0.40, 0.14}, {0.50, 0.37, 0.18}, {0.38, 0.30, 0.25}, {0.92, 0.92, 0.95}};
    static const struct {
        size_t x, y;
        int step; /* of four from low to high */
    } places[] = {{15, 15, 0}, {45, 15, 1}, {15, 45, 2}, {40, 45, 3}, {55, 45, 4}};
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) {
        const size_t i = k % NX, j = k / NX; /* from the north */
        z[k] = 1e-3f * (float)(j < 25 ? i >= 30 : i < 30 ? 2 : i < 50 ? 3 : 4);
    }
    field_file("steps.npy", z, NX, NY);
    io_image image =
        picture((const char *const[]){"render", "steps.npy", FROM_ABOVE, "--sun", "225,30", "-o", "o.exr", NULL});
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++)
        check_pixel(&image, places[k].x, places[k].y, tints[places[k].step], light_of_sun * 0.5 + light_of_sky, 0);
    io_image_free(&image);
}

/* Smooth normals at the rim of a hole are made of samples alone, and rays pass through the hole. */
static void smooth_around_a_hole(void **state) {
    (void)state;
    io_image image = picture((const char *const[]){"render", "hole.npy", FROM_ABOVE, "--sun", "225,30", "--phong",
                                                   "--samples", "1", "-o", "o.exr", NULL});
    const float *rgb = image.rgb;
    size_t through = 0;
    for (size_t k = 0; k < SIDE * SIDE; k++) through += rgb[3 * k + 2] == as_half(sky[2]);
    /* The first to fifth rows and the last ones, half a row each beside them and half a column at the sides, and of six
     * triangles, three pixels large, what the samples' places make of it. */
    check(through > 600 && through < 800, "%zu pixels show the sky", through);
    for (size_t y = 8; y < 52; y++)
        for (size_t x = 2; x < 58; x++) {
            const float *p = rgb + 3 * (y * SIDE + x);
            if (p[2] == as_half(sky[2]))
                check(x >= 24 && x <= 26 && y >= 37 && y <= 39, "the sky at (%zu, %zu)", x, y);
            else
                check_pixel(&image, x, y, ground, light_of_sun * 0.5 + light_of_sky, 0);
        }
    io_image_free(&image);
}

static void same_bits(void **state) {
    (void)state;
    check_same_bits((const char *const[]){NULL});
}

/* From wherever nothing is said, all of the terrain is seen: it touches no side of the picture. */
static void seen_as_a_whole(void **state) {
    (void)state;
    static const char *const sizes[] = {"90x60", "60x90"};
    for (size_t k = 0; k < 2; k++) {
        io_image image = picture(
            (const char *const[]){"render", "wall.npy", "--cellsize", "10", "--size", sizes[k], "-o", "o.exr", NULL});
        size_t land = 0;
        for (size_t y = 0; y < image.height; y++)
            for (size_t x = 0; x < image.width; x++) {
                const float *p = image.rgb + 3 * (y * image.width + x);
                const bool rim = x == 0 || y == 0 || x + 1 == image.width || y + 1 == image.height;
                if (p[2] < p[1]) land++;
                check(!rim || p[2] > p[1], "land at the rim, (%zu, %zu)", x, y);
            }
        check(land * 8 > image.width * image.height, "%zu pixels of land", land);
        io_image_free(&image);
    }
}

static void what_is_refused(void **state) {
    (void)state;
    static const char scene[] = "WorldBegin";
    scratch_write("s.pbrt", scene, sizeof scene - 1);
    check_refused((const char *const[]){"render", "-o", "o.exr", NULL}, 2, "nothing to draw");
    check_refused((const char *const[]){"render", "level.npy", "--dem", "wall.npy", "-o", "o.exr", NULL}, 2,
                  "give either level.npy or --dem wall.npy");
    check_refused((const char *const[]){"render", "s.pbrt", "--sun", "0,30", "-o", "o.exr", NULL}, 2,
                  "--sun is for rasters");
    check_refused((const char *const[]){"render", "s.pbrt", "--nodata", "0", "-o", "o.exr", NULL}, 2,
                  "--nodata is for rasters");
    check_refused((const char *const[]){"render", "level.npy", "--sun", "0", "-o", "o.exr", NULL}, 2, "not '0'");
    check_refused((const char *const[]){"render", "level.npy", "--fov", "180", "-o", "o.exr", NULL}, 2, "not 180");
    check_refused((const char *const[]){"render", "level.npy", "--from", "5", "-o", "o.exr", NULL}, 2, "not '5'");
    check_refused((const char *const[]){"render", "level.npy", "--from", "-5,3", "-o", "o.exr", NULL}, 1,
                  "-5,3: lies outside");
    check_refused((const char *const[]){"render", "level.npy", "--from", "5,3,9", "--to", "5,3,9", "-o", "o.exr", NULL},
                  1, "the same place");
    check_refused((const char *const[]){"render", "level.npy", NULL}, 2, "-o IMAGE is missing");
    check_refused((const char *const[]){"render", "wall.npy", "--cellsize", "10", "--from", "295,290,=20", "--size",
                                        "9x9", "-o", "o.exr", NULL},
                  1, "295,290,=20: is under the ground, which is 40.000 m high there");
    /* A place on another map. */
    const program_result *r =
        program_run(NULL, (const char *const[]){"render", "level.npy", "--from", "600000,5200000,=300", "--to",
                                                "600000,5200100,=0", "--size", "9x9", "-o", "o.exr", NULL});
    check(r->status == 0 && strstr(r->err, "nothing of the terrain is in the picture"), "%d: %s", r->status, r->err);
    /* Pictures do not replace what they are made from. */
    r = program_run(NULL, (const char *const[]){"render", "level.npy", "--size", "9x9", "-o", "o.png", NULL});
    if (r->status == 0 &&
        program_run(NULL, (const char *const[]){"info", "o.png", "--band", "1", NULL})->status == 0) /* with GDAL */
        check_refused((const char *const[]){"render", "o.png", "--band", "1", "-o", "./o.png", NULL}, 1,
                      "is also an input");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(level_land, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(shadow_of_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(colours_by_height, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(smooth_around_a_hole, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(same_bits, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(seen_as_a_whole, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
