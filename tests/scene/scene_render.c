/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures against closed formulas, and that neither kernel nor number of threads changes a pixel. */

#include "check.h"
#include "pictures.h"
#include "scratch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 64 };
#define HEAD                                                                                                           \
    "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64\nSampler \"bestcandidate\" "                 \
    "\"integer pixelsamples\" 16\nLookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\" \"float fov\" 90\nWorldBegin\n"
#define LIGHT "LightSource \"point\" \"color I\" [3 2 1]\n"
#define FLAT  "Shape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 0 0]\n"
static const double intensity[3] = {3, 2, 1};
static const double pi = 3.14159265358979323846;

static io_image picture_of(const char *text, scene_render_stats *stats) {
    scene *s = pictures_load(text);
    const scene_render_options options = {.threads = 1};
    const io_image image = pictures_render(s, &options, stats);
    scene_free(s);
    return image;
}

/* Light that arrives from the direction (x, y, 1), before intensity. */
typedef double light_fn(double x, double y);

/* Compares pixels that are not cut by an edge, where the formula jumps: the mean over a pixel is the formula at nine points
 * by Simpson's rule; sixteen samples a pixel are within a hundredth of it. */
static void compare(const io_image *image, light_fn *formula) {
    int compared = 0;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            double least = INFINITY, most = 0, mean = 0;
            for (int j = 0; j <= 2; j++)
                for (int i = 0; i <= 2; i++) {
                    const double light = formula((x + i * 0.5) / (SIDE / 2) - 1, 1 - (y + j * 0.5) / (SIDE / 2));
                    least = fmin(least, light);
                    most = fmax(most, light);
                    mean += light * (i == 1 ? 4 : 1) * (j == 1 ? 4 : 1) / 36;
                }
            if (most - least > 0.2 * most) continue;
            compared++;
            for (int c = 0; c < 3; c++) {
                const double got = (double)image->rgb[(y * SIDE + x) * 3 + c], wanted = mean * intensity[c];
                check(fabs(got - wanted) <= 0.01 * wanted, "pixel (%d, %d), colour %d: %g instead of %g", x, y, c, got,
                      wanted);
            }
        }
    check(compared > SIDE * SIDE / 2, "only %d pixels compared", compared);
}

/* A square of side 2 at z = 2 with Kd 0.5, light at the eye: Kd / pi · I cos / d². */
static double square_light(double x, double y) {
    const double slant = x * x + y * y + 1;
    return fabs(2 * x) <= 1 && fabs(2 * y) <= 1 ? 0.5 / pi / (4 * slant * sqrt(slant)) : 0;
}

static void flat_field_under_a_point_light(void **state) {
    (void)state;
    scene_render_stats stats;
    io_image image = picture_of(HEAD LIGHT "Translate -1 -1 2\nScale 2 2 1\n" FLAT "WorldEnd", &stats);
    compare(&image, square_light);
    check(stats.camera_rays == SIDE * SIDE * 16 && stats.mirror_rays == 0, "wrong number of rays");
    check(stats.shadow_rays == SIDE * SIDE * 16 / 4, "%llu shadow rays, a quarter of the view is hit",
          (unsigned long long)stats.shadow_rays);
    io_image_free(&image);
}

/* Seen from behind, a field is lit just as well; with the light on the other side it is black and no ray is spent. */
static void matte_has_two_sides_and_lets_nothing_through(void **state) {
    (void)state;
    io_image image = picture_of(HEAD LIGHT "Translate 1 -1 2\nRotate 180 0 1 0\nScale 2 2 1\n" FLAT "WorldEnd", NULL);
    compare(&image, square_light);
    io_image_free(&image);
    scene_render_stats stats;
    image = picture_of(HEAD "AttributeBegin\nTranslate 0 0 3\n" LIGHT
                            "AttributeEnd\nTranslate -1 -1 2\nScale 2 2 1\n" FLAT "WorldEnd",
                       &stats);
    for (size_t k = 0; k < SIDE * SIDE * 3; k++) check(image.rgb[k] == 0, "light comes through");
    check(stats.shadow_rays == 0, "%llu shadow rays for nothing", (unsigned long long)stats.shadow_rays);
    io_image_free(&image);
}

/* The square at z = 2 in the shadow of a smaller one at z = 1 that covers half of its extent, the light being at the eye's
 * side: seen from the eye everything behind the small one is hidden; so move the light to the left by 1. */
static double shadowed_light(double x, double y) {
    if (fabs(x) <= 0.25 && fabs(y) <= 0.25) { /* the small square */
        const double to[3] = {-1 - x, -y, -1}, square = to[0] * to[0] + to[1] * to[1] + 1;
        return 0.5 / pi / (square * sqrt(square));
    }
    const double p[2] = {2 * x, 2 * y};
    if (fabs(p[0]) > 1 || fabs(p[1]) > 1) return 0;
    const double to[3] = {-1 - p[0], -p[1], -2}, square = to[0] * to[0] + to[1] * to[1] + 4;
    const double half[2] = {p[0] + to[0] / 2, p[1] + to[1] / 2}; /* where the way to the light passes z = 1 */
    if (fabs(half[0]) <= 0.25 && fabs(half[1]) <= 0.25) return 0;
    return 0.5 / pi * 2 / (square * sqrt(square));
}

static void shadows_fall_where_they_should(void **state) {
    (void)state;
    io_image image = picture_of(HEAD "AttributeBegin\nTranslate -1 0 0\n" LIGHT "AttributeEnd\n"
                                     "AttributeBegin\nTranslate -0.25 -0.25 1\nScale 0.5 0.5 1\n" FLAT "AttributeEnd\n"
                                     "AttributeBegin\nTranslate -1 -1 2\nScale 2 2 1\n" FLAT "AttributeEnd\nWorldEnd",
                                NULL);
    compare(&image, shadowed_light);
    io_image_free(&image);
}

/* A large mirror at z = 2 shows a large wall at z = -1, lit from the eye: 0.9 of what the wall sends. */
static double mirrored_light(double x, double y) {
    const double slant = x * x + y * y, p = 5; /* the way is unfolded: to the wall it is 2 + 3 */
    const double square = p * p * slant + 1;
    return 0.9 * 0.5 / pi / (square * sqrt(square));
}

static void a_mirror_shows_what_lies_behind_the_eye(void **state) {
    (void)state;
    scene_render_stats stats;
    io_image image = picture_of(HEAD LIGHT "AttributeBegin\nTranslate -20 -20 -1\nScale 40 40 1\n" FLAT "AttributeEnd\n"
                                           "Material \"mirror\"\nTranslate -20 -20 2\nScale 40 40 1\n" FLAT "WorldEnd",
                                &stats);
    /* At the centre the light is a point's distance away and changes too fast for sixteen samples. */
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            if (abs(x - SIDE / 2) < SIDE / 4 && abs(y - SIDE / 2) < SIDE / 4) continue;
            const double wanted = intensity[0] * mirrored_light((x + 0.5) / (SIDE / 2) - 1, 1 - (y + 0.5) / (SIDE / 2));
            const double got = (double)image.rgb[(y * SIDE + x) * 3];
            check(fabs(got - wanted) <= 0.04 * wanted, "pixel (%d, %d): %g instead of %g", x, y, got, wanted);
        }
    check(stats.mirror_rays == SIDE * SIDE * 16, "%llu mirror rays", (unsigned long long)stats.mirror_rays);
    io_image_free(&image);
}

/* Two mirrors in a row: the wall at z = 3 is seen by way of z = 2 and z = -1, past the edge of the first mirror. */
static void each_mirror_takes_its_share(void **state) {
    (void)state;
    static const char scene_text[] =
        HEAD "LightSource \"point\" \"color I\" [1 1 1]\nAttributeBegin\nMaterial \"mirror\" \"color Kr\" [%s]\n"
             "Translate -1 -50 2\nScale 2 100 1\n" FLAT "AttributeEnd\nAttributeBegin\n"
             "Material \"mirror\" \"color Kr\" [%s]\nTranslate -50 -50 -1\nScale 100 100 1\n" FLAT
             "AttributeEnd\nTranslate 1.5 -50 3\nScale 50 100 1\n" FLAT "WorldEnd";
    char text[1024];
    snprintf(text, sizeof text, scene_text, "1 1 1", "1 1 1");
    io_image whole = picture_of(text, NULL);
    snprintf(text, sizeof text, scene_text, "1 .5 .25", ".25 .5 1");
    io_image shares = picture_of(text, NULL);
    int twice = 0;
    for (int x = SIDE / 2; x < SIDE; x++) {
        const float *a = whole.rgb + (SIDE / 2 * SIDE + x) * 3, *b = shares.rgb + (SIDE / 2 * SIDE + x) * 3;
        /* Unfolded, the ray is at 2x on the first mirror, which ends at 1, and at 9x on the wall, which starts at 1.5. */
        if ((x + 1.0) / (SIDE / 2) - 1 > 0.5 || 9 * (x * 1.0 / (SIDE / 2) - 1) < 1.5) continue;
        twice++;
        for (int c = 0; c < 3; c++)
            check(a[c] > 0 && fabsf(b[c] - a[c] / 4) <= a[c] * 1e-5f, "column %d: %g of %g", x, (double)b[c],
                  (double)a[c]);
    }
    check(twice > 4, "only %d columns show the wall", twice);
    io_image_free(&whole);
    io_image_free(&shares);
}

static void a_path_meets_at_most_four_mirrors(void **state) {
    (void)state;
    scene_render_stats stats;
    io_image image =
        picture_of(HEAD LIGHT "Material \"mirror\"\nAttributeBegin\nTranslate -500 -500 -1\nScale 1000 1000 1\n" FLAT
                              "AttributeEnd\nTranslate -500 -500 1\nScale 1000 1000 1\n" FLAT "WorldEnd",
                   &stats);
    check(stats.mirror_rays == 4 * stats.camera_rays && stats.shadow_rays == 0, "%llu mirror rays",
          (unsigned long long)stats.mirror_rays);
    io_image_free(&image);
}

/* Inside of a cylinder of radius 1 along the y axis: it stands square to the ways from the axis to it. */
static double cylinder_light(double x, double y) {
    const double t = 1 / sqrt(x * x + 1), d = t * sqrt(x * x + y * y + 1);
    return fabs(y * t) <= 0.5 ? 0.5 / pi / (d * d * d) : 0;
}

static void a_cylinder_from_inside(void **state) {
    (void)state;
    io_image image = picture_of(HEAD LIGHT "Rotate 90 1 0 0\nScale 1 1 0.5\nShape \"cylinder\"\nWorldEnd", NULL);
    compare(&image, cylinder_light);
    io_image_free(&image);
}

/* An image of one colour acts as that colour; one of four shows which way it lies. */
static void images_lie_on_shapes_as_they_should(void **state) {
    (void)state;
    float one[3 * 8 * 4], four[4 * 3] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    for (int k = 0; k < 3 * 8 * 4; k++) one[k] = 0.5f;
    io_error error = {""};
    check(io_image_write("one.exr", &(io_image){.width = 8, .height = 4, .rgb = one}, &error), "%s", error.text);
    check(io_image_write("four.exr", &(io_image){.width = 2, .height = 2, .rgb = four}, &error), "%s", error.text);
    static const char textured[] =
        HEAD "AttributeBegin\n" LIGHT "AttributeEnd\nTexture \"t\" \"color\" \"imagemap\" \"string filename\" "
             "\"%s.exr\"\nMaterial \"matte\" \"texture Kd\" \"t\"\n%sWorldEnd";
    static const char square[] = "Translate -1 -1 2\nScale 2 2 1\n" FLAT;
    char text[1024];
    snprintf(text, sizeof text, textured, "one", square);
    io_image image = picture_of(text, NULL);
    compare(&image, square_light);
    io_image_free(&image);
    snprintf(text, sizeof text, textured, "one", "Rotate 90 1 0 0\nScale 1 1 0.5\nShape \"cylinder\"\n");
    image = picture_of(text, NULL);
    compare(&image, cylinder_light);
    io_image_free(&image);

    /* u grows to the right, v upwards, from the lower left corner; row 0 of the image is at v = 0. Texel centres are at a
     * quarter and three quarters of the square. */
    snprintf(text, sizeof text, textured, "four", square);
    image = picture_of(text, NULL);
    static const int row[4] = {39, 39, 24, 24}, column[4] = {24, 39, 24, 39};
    for (int k = 0; k < 4; k++) {
        const float *rgb = image.rgb + (row[k] * SIDE + column[k]) * 3;
        for (int c = 0; c < 3; c++)
            check(((double)rgb[c] > 0.02 * intensity[c]) == (four[k * 3 + c] > 0), "corner %d: %g %g %g", k,
                  (double)rgb[0], (double)rgb[1], (double)rgb[2]);
    }
    io_image_free(&image);
}

/* ---- kernels, threads, progress ----------------------------------------------------------------------------------- */

static void kernels_and_threads_change_no_pixel(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    for (int phong = 0; phong < 2; phong++)
        for (int leaf = CW_LEAF_MOLLER_TRUMBORE; leaf < CW_LEAF_COUNT; leaf++) {
            io_image first = {0};
            scene_render_stats first_stats = {0};
            for (size_t k = 0; k < cw_kernel_count(); k++) {
                const cw_kernel *kernel = cw_kernel_at(k);
                const cw_kernel_info info = cw_kernel_describe(kernel);
                if (!info.available) continue;
                for (unsigned threads = 1; threads <= 3; threads += 2) {
                    /* The first is what the others are held against. */
                    if (first.rgb != NULL && !test_takes(k + (size_t)(leaf + phong) + threads / 2, 3)) continue;
                    const scene_render_options options = {
                        .query = {.expert.kernel = kernel, .expert.leaf = (cw_leaf)leaf},
                        .threads = threads,
                        .phong = phong != 0};
                    io_image image;
                    io_error error = {""};
                    scene_render_stats stats;
                    if (!scene_render(s, &options, &image, &stats, &error)) {
                        check(strstr(error.text, "does not have the leaf test") != NULL, "%s", error.text);
                        continue;
                    }
                    check(stats.mirror_rays > 0 && stats.shadow_rays > 0, "%s: the scene is empty", info.name);
                    if (first.rgb == NULL) {
                        first = image;
                        first_stats = stats;
                        continue;
                    }
                    check(pictures_same(&first, &image), "%s, %s, %u threads: pixels differ", info.name,
                          cw_leaf_name((cw_leaf)leaf), threads);
                    check(stats.shadow_rays == first_stats.shadow_rays &&
                              stats.mirror_rays == first_stats.mirror_rays &&
                              stats.field_queries == first_stats.field_queries,
                          "%s: numbers of rays differ", info.name);
                    io_image_free(&image);
                }
            }
            check(first.rgb != NULL, "no kernel has the leaf test %s", cw_leaf_name((cw_leaf)leaf));
            io_image_free(&first);
        }
    scene_free(s);
}

static void impossible_queries_are_refused(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    const scene_render_options options = {.query = {.expert.leaf = (cw_leaf)99}};
    io_image image;
    io_error error = {""};
    check(!scene_render(s, &options, &image, NULL, &error) && strstr(error.text, "kernel ") != NULL, "message: %s",
          error.text);
    check(image.rgb == NULL, "pixels are left");
    scene_free(s);
}

static void lower_the_limit(void *context, double share) {
    (void)context, (void)share;
    cw_isa_limit(CW_ISA_SCALAR);
}

/* A kernel that is there when the rendering begins, and not until its end. */
static void kernels_that_vanish_are_an_error(void **state) {
    (void)state;
    const cw_kernel *kernel = cw_kernel_find("packet4");
    if (!cw_kernel_describe(kernel).available) skip();
    scene *s = pictures_rough_scene();
    const scene_render_options options = {
        .query = {.expert.kernel = kernel}, .threads = 1, .progress = lower_the_limit};
    io_image image;
    io_error error = {""};
    const bool rendered = scene_render(s, &options, &image, NULL, &error);
    cw_isa_limit(CW_ISA_ANY);
    check(!rendered && strstr(error.text, "the limit on instruction sets, has scalar") != NULL, "message: %s",
          error.text);
    check(image.rgb == NULL, "pixels are left");
    scene_free(s);
}

/* Any number of samples makes the same picture up to noise. */
static void samples_converge(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    io_image many = pictures_render(s, &(scene_render_options){.samples = 257}, NULL);
    double last = INFINITY;
    static const unsigned counts[] = {1, 7, 64};
    for (int k = 0; k < 3; k++) {
        io_image few = pictures_render(s, &(scene_render_options){.samples = counts[k]}, NULL);
        double sum = 0;
        const size_t n = few.width * few.height * 3;
        for (size_t p = 0; p < n; p++) sum += pow((double)few.rgb[p] - (double)many.rgb[p], 2);
        const double difference = sqrt(sum / (double)n);
        check(difference < last / 2, "%u samples: %g after %g", counts[k], difference, last);
        last = difference;
        io_image_free(&few);
    }
    check(last < 0.01, "64 samples differ by %g from 257", last);
    io_image_free(&many);
    scene_free(s);
}

static void note_share(void *context, double share) {
    double *last = context;
    check(share > *last && share <= 1, "progress goes from %g to %g", *last, share);
    *last = share;
}

static void progress_grows_to_one(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    double last = 0;
    const scene_render_options options = {.threads = 3, .progress = note_share, .progress_context = &last};
    io_image image;
    io_error error = {""};
    check(scene_render(s, &options, &image, NULL, &error), "%s", error.text);
    check(last == 1, "progress ends at %g", last);
    io_image_free(&image);
    scene_free(s);
}

/* A tracer of one's own is asked instead of the library, for at most a batch of rays. It finds nothing. */
static void count_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    (void)rays;
    (void)field;
    *(uint64_t *)context += n;
    if (n > SCENE_BATCH) abort();
    for (size_t k = 0; k < n; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
}

static void a_tracer_is_asked_instead_of_the_library(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    uint64_t asked = 0;
    const scene_tracer nothing = {&asked, count_closest, NULL}; /* where nothing is hit, nothing is shadowed */
    scene_render_stats stats;
    const scene_render_options options = {.tracer = &nothing, .threads = 1, .general = true};
    io_image image = pictures_render(s, &options, &stats);
    check(asked == 2 * 70 * 50 * 4 && stats.field_queries == asked, "%llu rays", (unsigned long long)asked);
    for (size_t k = 0; k < 70 * 50 * 3; k++) check(image.rgb[k] == 0, "light from nowhere");
    io_image_free(&image);
    scene_free(s);
}

/* The project's own scenes load, and each shows what it is about. */
static void the_six_scenes_render(void **state) {
    (void)state;
    static const struct {
        const char *name;
        size_t side, fields;
        bool mirror;
    } scenes[] = {{"hftest", 256, 1, false},   {"landsea-0", 400, 2, true}, {"landsea-1", 400, 2, true},
                  {"landsea-2", 400, 2, true}, {"texture", 400, 1, false},  {"landsea-big", 600, 2, true}};
    for (int k = 0; k < 6; k++) {
        if (!test_takes((size_t)k, 3)) continue;
        char path[4096];
        io_error error = {""};
        snprintf(path, sizeof path, "%s/%s.pbrt", SCENES, scenes[k].name);
        scene *s = scene_load(path, NULL, NULL, &error);
        check(s != NULL, "%s", error.text);
        check(scene_width(s) == scenes[k].side && scene_height(s) == scenes[k].side, "%s: size", path);
        check(scene_field_count(s) == scenes[k].fields, "%s: %zu fields", path, scene_field_count(s));
        scene_render_stats stats;
        io_image image = pictures_render(s, &(scene_render_options){.samples = 1, .phong = k % 2 == 1}, &stats);
        double mean = 0;
        for (size_t p = 0; p < image.width * image.height * 3; p++) mean += (double)image.rgb[p];
        mean /= (double)(image.width * image.height * 3);
        check(mean > 0.02 && mean < 1, "%s: mean light %g", path, mean);
        check((stats.mirror_rays > stats.camera_rays / 20) == scenes[k].mirror, "%s: %llu mirror rays", path,
              (unsigned long long)stats.mirror_rays);
        check(stats.shadow_rays > stats.camera_rays / 6, "%s: %llu shadow rays", path,
              (unsigned long long)stats.shadow_rays);
        io_image_free(&image);
        scene_free(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flat_field_under_a_point_light),
        cmocka_unit_test(matte_has_two_sides_and_lets_nothing_through),
        cmocka_unit_test(shadows_fall_where_they_should),
        cmocka_unit_test(a_mirror_shows_what_lies_behind_the_eye),
        cmocka_unit_test(each_mirror_takes_its_share),
        cmocka_unit_test(a_path_meets_at_most_four_mirrors),
        cmocka_unit_test(a_cylinder_from_inside),
        cmocka_unit_test(images_lie_on_shapes_as_they_should),
        cmocka_unit_test(kernels_and_threads_change_no_pixel),
        cmocka_unit_test(impossible_queries_are_refused),
        cmocka_unit_test(kernels_that_vanish_are_an_error),
        cmocka_unit_test(samples_converge),
        cmocka_unit_test(progress_grows_to_one),
        cmocka_unit_test(a_tracer_is_asked_instead_of_the_library),
        cmocka_unit_test(the_six_scenes_render),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
