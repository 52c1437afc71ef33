/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures by `cellwalk render --curvature`: land beyond the horizon of a sea is seen from the height on that the formula gives.
 *
 * The eye is h metres above a sea of level 0. The surface d metres away is lower by k d² / 2 R, so that the sea's horizon is
 * at s = sqrt(2 R h / k), in the direction that falls by k s / R a metre. A shore D metres away, with s < D, stands above
 * that line by H - k (D - s)² / 2 R if it is H metres high. Samples lie on a parabola, the surface between two of them on its
 * chord, which is below it by k CELL² / 8 R = 2 · 10^-4 m at most. A pixel is 0.14 m high on the shore 20 km away. */

#include "image.h"
#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include "cellwalk.h"

#include <math.h>

enum { NX = 340, NY = 5, EYE = 2, ROW = 2, CELL = 100, SIDE = 256 };
static const double radius = 6378137, fov = 0.1, pi = 3.141592653589793;

static int enter(void **state) { return scratch_enter(state); }

/* A sea with land of the same height from a column on. */
static void make_land(size_t shore, double height) {
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) z[k] = k % NX < shore ? 0 : (float)height;
    field_file("land.npy", z, NX, NY);
}

static io_image look(const char *from, const char *to, const char *factor, const char *sun) {
    const program_result *r = program_run(
        NULL, (const char *const[]){"render", "land.npy", "--cellsize",  "100",    "--from",  from,        "--to",
                                    to,       "--fov",    "0.1",         "--size", "256x256", "--samples", "1",
                                    "--sun",  sun,        "--curvature", factor,   "-o",      "o.exr",     NULL});
    check(r->status == 0 && r->err[0] == '\0', "exit status %d: %s", r->status, r->err);
    io_image image;
    io_error error;
    check(io_image_read("o.exr", &image, &error), "%s", error.text);
    return image;
}

/* No ground is as blue: its brightest tint has 1.04 times as much blue as green, the sky 1.16 times or more. */
static bool is_sky(const io_image *image, size_t x, size_t y) {
    const float *rgb = image->rgb + (y * image->width + x) * 3;
    return rgb[2] > 1.1f * rgb[1];
}

/* The middle of the picture is at the sea's horizon. Land ends `rise` pixels above it. */
static void check_picture(const io_image *image, double rise, const char *what) {
    const double top = SIDE / 2 - fmax(rise, 0);
    for (size_t x = SIDE / 2 - 1; x <= SIDE / 2; x++)
        for (size_t y = 0; y < SIDE; y++) {
            /* A sample is anywhere in its pixel. Chords move the edge by less than 0.003 of one, and rounding directions to
             * float by four steps of 2^-24 at most, 0.035 of one. */
            const bool above = (double)(y + 1)<top - 0.05, below = (double)y> top + 0.05;
            check(!above || is_sky(image, x, y), "%s: pixel %zu is land, the top is at %g", what, y, top);
            check(!below || !is_sky(image, x, y), "%s: pixel %zu is sky, the top is at %g", what, y, top);
        }
}

static void land_beyond_the_horizon(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
    } factors[] = {{"1", 1}, {"0.857142857142857", 6.0 / 7}};
    static const size_t shores[] = {202, 302};
    const double eye = 10, pixel = 2 * tan(fov * pi / 360) / SIDE;
    for (size_t f = 0; f < 2; f++)
        for (size_t d = 0; d < 2; d++)
            for (int seen = 0; seen < 2; seen++) {
                const double k = factors[f].value, s = sqrt(2 * radius * eye / k),
                             distance = (double)(shores[d] - EYE) * CELL;
                const double least = k * (distance - s) * (distance - s) / (2 * radius);
                const double over = seen ? 0.5 : -0.5, height = (double)(float)(least + over);
                char from[64], to[64], what[64];
                /* A place on the line to the sea's horizon, at the height that curvature lowers onto that line. */
                const double end = 33000, z = eye - k * s / radius * end + k * end * end / (2 * radius);
                snprintf(from, sizeof from, "%d,%d,=%.17g", EYE * CELL, ROW * CELL, eye);
                snprintf(to, sizeof to, "%.17g,%d,=%.17g", EYE * CELL + end, ROW * CELL, z);
                snprintf(what, sizeof what, "factor %s, %g m away, %g m high", factors[f].text, distance, height);
                check(z >= height, "%s: the target is under the ground at %g", what, z);
                make_land(shores[d], height);
                io_image image = look(from, to, factors[f].text, "270,40");
                check_picture(&image, (height - least) / distance / pixel, what);
                io_image_free(&image);
            }
}

static void check_same(const io_image *a, const io_image *b, bool same, const char *what) {
    const size_t bytes = a->width * a->height * 3 * sizeof *a->rgb;
    check((memcmp(a->rgb, b->rgb, bytes) == 0) == same, "%s: the pictures are %s", what,
          same ? "not the same" : "the same");
}

/* Shadows are those of the lowered terrain. From the sea 1 km in front of the eye, land of 40 m that is 19 km farther stands 0.12
 * degrees above the level, and 0.03 degrees once it is lowered by 31 m. The sun is between the two. */
static void shadows_are_lowered(void **state) {
    (void)state;
    make_land(202, 40);
    char to[64];
    snprintf(to, sizeof to, "%d,%d,0", EYE * CELL + 1000, ROW * CELL);
    io_image flat = look("200,200,=10", to, "0", "90,0.07"), lowered = look("200,200,=10", to, "1", "90,0.07");
    const size_t at = (SIDE / 2 * SIDE + SIDE / 2) * 3;
    for (int c = 0; c < 3; c++)
        check(lowered.rgb[at + (size_t)c] > flat.rgb[at + (size_t)c], "%g is no brighter than %g in the shadow",
              (double)lowered.rgb[at + (size_t)c], (double)flat.rgb[at + (size_t)c]);
    io_image_free(&flat);
    io_image_free(&lowered);
}

static io_image picture(const char *option, const char *value) {
    const program_result *r =
        program_run(NULL, (const char *const[]){"render", "land.npy", "--cellsize", "100", "--from", "200,200,=60",
                                                "--size", "64x64", "--phong", "-o", "o.exr", option, value, NULL});
    check(r->status == 0 && r->err[0] == '\0', "exit status %d: %s", r->status, r->err);
    io_image image;
    io_error error;
    check(io_image_read("o.exr", &image, &error), "%s", error.text);
    return image;
}

/* Without the option nothing changes; colours by height stay those of the terrain as it is. */
static void off_by_default(void **state) {
    (void)state;
    make_land(100, 5);
    io_image none = picture(NULL, NULL), flat = picture("--curvature", "0"), round = picture("--curvature", "1");
    check_same(&none, &flat, true, "factor 0");
    check_same(&none, &round, false, "factor 1");
    io_image_free(&none);
    io_image_free(&flat);
    io_image_free(&round);
}

static void what_is_refused(void **state) {
    (void)state;
    make_land(100, 5);
    check_refused(
        (const char *const[]){"render", "land.npy", "--curvature", "-1", "--from", "200,200", "-o", "o.exr", NULL}, 2,
        "--curvature takes a number from 0 on, not -1");
    check_refused((const char *const[]){"render", "land.npy", "--curvature", "1", "-o", "o.exr", NULL}, 2,
                  "give the eye's place by --from");
    check_refused((const char *const[]){"render", "land.npy", "--curvature", "1", "--from", "200,200", "--water", "3",
                                        "-o", "o.exr", NULL},
                  2, "--water is level and does not go with --curvature");
    scratch_write("s.pbrt", "", 0);
    check_refused((const char *const[]){"render", "s.pbrt", "--curvature", "1", "-o", "o.exr", NULL}, 2,
                  "--curvature is for rasters");
    check_refused(
        (const char *const[]){"render", "land.npy", "--curvature", "1", "--from", "-900,0", "-o", "o.exr", NULL}, 1,
        "lies outside");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(land_beyond_the_horizon, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(shadows_are_lowered, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(off_by_default, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
