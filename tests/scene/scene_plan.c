/* SPDX-License-Identifier: Apache-2.0 */
/* The renderer leaves out what a scene does not require: that changes no pixel. Nor does the instruction set that its code is
 * compiled for, nor what part of a picture is rendered. */

#include "check.h"
#include "pictures.h"
#include "scratch.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const normal_names[] = {"flat", "smooth"};
enum { NORMALS = 2 };

typedef scene *make_fn(void);
static make_fn *const makers[] = {pictures_rough_scene, pictures_full_scene, pictures_landscape};
enum { MAKERS = sizeof makers / sizeof makers[0] };

static scene_render_options with_normals(int normals) {
    return (scene_render_options){.threads = 1, .phong = normals == 1};
}

/* A scene of each kind is worth its name: all kinds of rays occur, and many pixels are lit. */
static void scenes_are_rich(void **state) {
    (void)state;
    for (int m = 0; m < MAKERS; m++) {
        scene *s = makers[m]();
        scene_render_stats stats;
        io_image image = pictures_render(s, &(scene_render_options){.threads = 1}, &stats);
        size_t lit = 0;
        for (size_t k = 0; k < 70 * 50; k++) lit += image.rgb[3 * k] > 0.01f;
        check(stats.mirror_rays > stats.camera_rays / 10 && stats.shadow_rays > stats.camera_rays / 2 &&
                  lit > 70 * 50 / 3,
              "scene %d: %llu mirror rays, %llu shadow rays, %zu pixels lit", m, (unsigned long long)stats.mirror_rays,
              (unsigned long long)stats.shadow_rays, lit);
        io_image_free(&image);
        scene_free(s);
    }
}

static void the_plan_changes_no_pixel(void **state) {
    (void)state;
    for (int m = 0; m < MAKERS; m++) {
        scene *s = makers[m]();
        for (int normals = 0; normals < NORMALS; normals++) {
            if (!test_takes((size_t)(m + normals), 2)) continue;
            scene_render_options options = with_normals(normals);
            scene_render_stats planned, general;
            io_image image = pictures_render(s, &options, &planned);
            options.general = true;
            io_image whole = pictures_render(s, &options, &general);
            check(pictures_same(&image, &whole), "scene %d, normals %s: pixels differ", m, normal_names[normals]);
            check(planned.shadow_rays == general.shadow_rays && planned.mirror_rays == general.mirror_rays &&
                      planned.field_queries < general.field_queries,
                  "scene %d, normals %s: %llu field queries, %llu without a plan", m, normal_names[normals],
                  (unsigned long long)planned.field_queries, (unsigned long long)general.field_queries);
            io_image_free(&image);
            io_image_free(&whole);
        }
        scene_free(s);
    }
}

static void instruction_sets_change_no_pixel(void **state) {
    (void)state;
    for (int m = 0; m < MAKERS; m++) {
        scene *s = makers[m]();
        for (int normals = 0; normals < NORMALS; normals++) {
            if (!test_takes((size_t)(m + normals), 2)) continue;
            const scene_render_options options = with_normals(normals);
            io_image first = {0};
            for (int isa = CW_ISA_SCALAR; isa < CW_ISA_COUNT; isa++) {
                cw_isa_limit((cw_isa)isa);
                if (cw_isa_best() != (cw_isa)isa) continue;
                io_image image = pictures_render(s, &options, NULL);
                if (isa == CW_ISA_SCALAR) {
                    first = image;
                    continue;
                }
                check(pictures_same(&first, &image), "scene %d, normals %s, %s: pixels differ", m,
                      normal_names[normals], cw_isa_name((cw_isa)isa));
                io_image_free(&image);
            }
            cw_isa_limit(CW_ISA_ANY);
            io_image_free(&first);
        }
        scene_free(s);
    }
}

static void kinds_of_normals_differ(void **state) {
    (void)state;
    scene *s = pictures_full_scene();
    io_image flat = pictures_render(s, &(scene_render_options){.threads = 1}, NULL);
    io_image smooth = pictures_render(s, &(scene_render_options){.threads = 1, .phong = true}, NULL);
    check(!pictures_same(&flat, &smooth), "flat and smooth normals look alike");
    io_image_free(&flat);
    io_image_free(&smooth);
    scene_free(s);
}

static void normals_of_a_plane_of(int nu, int nv) {
    static char text[1 << 16];
    size_t used = (size_t)snprintf(text, sizeof text,
                                   "Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 64\n"
                                   "LookAt 0 0 0 0 0 1 0 1 0\nCamera \"perspective\" \"float fov\" 40\nWorldBegin\n"
                                   "LightSource \"point\" \"color I\" [30 20 10]\nTranslate -1 -1 3\nScale 2 2 1\n"
                                   "Shape \"heightfield\" \"integer nu\" %d \"integer nv\" %d \"float Pz\" [",
                                   nu, nv);
    for (int k = 0; k < nu * nv; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, " %.7f", k % nu / 64.0 - k / nu / 128.0);
    snprintf(text + used, sizeof text - used, "]\nWorldEnd\n");
    scene *s = pictures_load(text);
    io_image flat = pictures_render(s, &(scene_render_options){.threads = 1}, NULL);
    io_image image = pictures_render(s, &(scene_render_options){.threads = 1, .phong = true}, NULL);
    size_t lit = 0;
    for (size_t k = 0; k < 64 * 64 * 3; k++) {
        lit += flat.rgb[k] > 0;
        /* The samples are exact and so are their differences; a light has some twenty roundings. */
        check(fabsf(image.rgb[k] - flat.rgb[k]) <= 40 * 0x1p-24f * flat.rgb[k], "%d x %d samples: %g instead of %g", nu,
              nv, (double)image.rgb[k], (double)flat.rgb[k]);
    }
    check(lit > 64 * 64, "only %zu values are lit", lit);
    io_image_free(&image);
    io_image_free(&flat);
    scene_free(s);
}

/* A tilted plane has the same normal everywhere, up to its border, also if the samples around a cell are
 * more than there are. */
static void all_normals_of_a_plane_are_its_own(void **state) {
    (void)state;
    normals_of_a_plane_of(40, 40);
    for (int nu = 2; nu <= 5; nu++)
        for (int nv = 2; nv <= 5; nv++)
            if (test_takes((size_t)(nu + nv), 4)) normals_of_a_plane_of(nu, nv);
}

/* ---- which rays are asked ----------------------------------------------------------------------------------------- */

/* Asks the library, and fails the test if a ray does not come near the field's box. What begins there may leave it before
 * tmin; rounding may have put its origin a little outside. */
typedef struct watch {
    scene *scene;
    uint64_t asked;
} watch;

static void watch_rays(watch *w, size_t field, const cw_ray *rays, size_t n) {
    const cw_field_info info = cw_field_describe(scene_field(w->scene, field));
    const double low[3] = {0, 0, (double)info.low},
                 high[3] = {(double)(info.nx - 1), (double)(info.ny - 1), (double)info.high};
    w->asked += n;
    for (size_t k = 0; k < n; k++) {
        double enter = 0, leave = (double)rays[k].tmax;
        for (int c = 0; c < 3; c++) {
            const double org = (double)rays[k].org[c], dir = (double)rays[k].dir[c], room = 1e-5 * (1 + fabs(org));
            const double a = ((dir < 0 ? high[c] + room : low[c] - room) - org) / dir;
            const double b = ((dir < 0 ? low[c] - room : high[c] + room) - org) / dir;
            enter = fmax(enter, a);
            leave = fmin(leave, b);
        }
        check(enter <= leave, "field %zu is asked about a ray that passes its box: %g to %g", field, enter, leave);
    }
}

static void watch_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    watch *w = context;
    watch_rays(w, field, rays, n);
    check_status(cw_closest(scene_field(w->scene, field), NULL, rays, n, hits), CW_OK);
}

static void watch_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    watch *w = context;
    watch_rays(w, field, rays, n);
    check_status(cw_occluded(scene_field(w->scene, field), NULL, rays, n, occluded), CW_OK);
}

static void fields_are_asked_about_rays_through_their_boxes(void **state) {
    (void)state;
    for (int m = 0; m < MAKERS; m++) {
        scene *s = makers[m]();
        watch w = {s, 0};
        const scene_tracer tracer = {&w, watch_closest, watch_any};
        scene_render_stats stats;
        io_image watched = pictures_render(s, &(scene_render_options){.threads = 1, .tracer = &tracer}, &stats);
        io_image image = pictures_render(s, &(scene_render_options){.threads = 1}, NULL);
        check(w.asked == stats.field_queries && w.asked > stats.camera_rays / 2, "%llu rays asked, %llu counted",
              (unsigned long long)w.asked, (unsigned long long)stats.field_queries);
        check(pictures_same(&watched, &image), "scene %d: another picture", m);
        io_image_free(&watched);
        io_image_free(&image);
        scene_free(s);
    }
}

/* ---- parts, seeds, sizes ------------------------------------------------------------------------------------------ */

static void a_crop_is_a_part_of_the_whole(void **state) {
    (void)state;
    static const scene_crop crops[] = {{0, 0, 70, 50}, {0, 0, 1, 1},    {69, 49, 70, 50}, {31, 31, 33, 33},
                                       {3, 7, 60, 41}, {33, 0, 35, 50}, {0, 30, 70, 34}};
    scene *s = pictures_full_scene();
    io_image whole = pictures_render(s, &(scene_render_options){.threads = 1, .phong = true}, NULL);
    for (size_t k = 0; k < sizeof crops / sizeof crops[0]; k++) {
        if (!test_takes(k, 3)) continue;
        const scene_crop c = crops[k];
        scene_render_stats stats;
        io_image part = pictures_render(s, &(scene_render_options){.threads = 2, .phong = true, .crop = c}, &stats);
        check(part.width == c.x1 - c.x0 && part.height == c.y1 - c.y0, "crop %zu is %zu x %zu", k, part.width,
              part.height);
        check(stats.camera_rays == part.width * part.height * 6, "crop %zu: %llu camera rays", k,
              (unsigned long long)stats.camera_rays);
        for (size_t y = 0; y < part.height; y++)
            check(memcmp(part.rgb + y * part.width * 3, whole.rgb + ((c.y0 + y) * whole.width + c.x0) * 3,
                         part.width * 3 * sizeof(float)) == 0,
                  "crop %zu differs in row %zu", k, y);
        io_image_free(&part);
    }
    io_image_free(&whole);

    static const scene_crop wrong[] = {{0, 0, 71, 50}, {0, 0, 70, 51}, {5, 5, 5, 9}, {9, 5, 5, 9}, {5, 9, 9, 9}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        io_image image;
        io_error error = {""};
        const scene_render_options options = {.crop = wrong[k]};
        check(!scene_render(s, &options, &image, NULL, &error) && strstr(error.text, "no part of 70 x 50") != NULL,
              "crop %zu: %s", k, error.text);
        check(image.rgb == NULL, "pixels are left");
    }
    scene_free(s);
}

static void seeds_can_be_repeated(void **state) {
    (void)state;
    scene *s = pictures_rough_scene();
    io_image images[4];
    static const uint32_t seeds[4] = {0, 1, 1, 4294967295u};
    for (int k = 0; k < 4; k++)
        images[k] = pictures_render(s, &(scene_render_options){.threads = 1 + (unsigned)k, .seed = seeds[k]}, NULL);
    check(pictures_same(&images[1], &images[2]), "seed 1 makes two pictures");
    check(!pictures_same(&images[0], &images[1]) && !pictures_same(&images[1], &images[3]), "seeds make no difference");
    io_image without = pictures_render(s, &(scene_render_options){.threads = 1}, NULL);
    check(pictures_same(&images[0], &without), "no seed is not seed 0");
    io_image_free(&without);
    for (int k = 0; k < 4; k++) io_image_free(&images[k]);
    scene_free(s);
}

static void a_size_given_is_that_of_the_film(void **state) {
    (void)state;
    static const char scene_text[] =
        "Film \"image\" \"integer xresolution\" %d \"integer yresolution\" %d\nLookAt 0 0 0 0 0 1 0 1 0\n"
        "Camera \"perspective\" \"float fov\" 60\nWorldBegin\nLightSource \"point\" \"color I\" [9 8 7]\n"
        "Translate -1 -1 2\nScale 2 2 1\nShape \"heightfield\" \"integer nu\" 2 \"integer nv\" 2 \"float Pz\" [0 0 .3 "
        "0]\n"
        "WorldEnd\n";
    char text[1024];
    snprintf(text, sizeof text, scene_text, 50, 34);
    scene *film = pictures_load(text);
    snprintf(text, sizeof text, scene_text, 5, 9);
    scene *other = pictures_load(text);
    io_image wanted = pictures_render(film, &(scene_render_options){.threads = 1}, NULL);
    io_image given = pictures_render(other, &(scene_render_options){.threads = 1, .width = 50, .height = 34}, NULL);
    check(pictures_same(&wanted, &given), "pixels differ");
    io_image_free(&wanted);
    io_image_free(&given);
    scene_free(film);
    scene_free(other);
}

/* Each moment of a thread belongs to one stage, so that stages cannot add up to more than there was. */
static void stages_add_up(void **state) {
    (void)state;
    scene *s = pictures_full_scene();
    for (unsigned threads = 1; threads <= 3; threads++) {
        scene_render_stats stats;
        io_image image = pictures_render(s, &(scene_render_options){.threads = threads}, &stats);
        const double stages[4] = {stats.ray_seconds, stats.trace_seconds, stats.shade_seconds, stats.film_seconds};
        double sum = 0;
        for (int k = 0; k < 4; k++) {
            check(stages[k] > 0, "stage %d took no time", k);
            sum += stages[k];
        }
        check(sum <= threads * stats.seconds * (1 + 1e-9), "stages take %g s of %g s on %u threads", sum, stats.seconds,
              threads);
        io_image_free(&image);
    }
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_are_rich),
        cmocka_unit_test(the_plan_changes_no_pixel),
        cmocka_unit_test(instruction_sets_change_no_pixel),
        cmocka_unit_test(kinds_of_normals_differ),
        cmocka_unit_test(all_normals_of_a_plane_are_its_own),
        cmocka_unit_test(fields_are_asked_about_rays_through_their_boxes),
        cmocka_unit_test(a_crop_is_a_part_of_the_whole),
        cmocka_unit_test(seeds_can_be_repeated),
        cmocka_unit_test(a_size_given_is_that_of_the_film),
        cmocka_unit_test(stages_add_up),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
