/* SPDX-License-Identifier: Apache-2.0 */
/* A view of land in sunlight: its error against samples a pixel and resolution. */
#include "tradeoff/tradeoff.h"

#include "clock.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "landscape.h"
#include "scenes/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MANY = 1024, WIDTH = 1200, HEIGHT = 800, LEFT = 576, RIGHT = 640, REPEATS = 3 };

typedef struct view {
    cw_field *own; /* of coarser land, or NULL; z likewise */
    float *z;
    scene *scene;
    scene_crop part; /* of the picture */
} view;

/* One grey ground. */
static bool paint(io_image *colours, io_error *error) {
    if (!io_image_allocate(colours, 1, 1, false, "", error)) return false;
    for (int c = 0; c < 3; c++) colours->rgb[c] = 0.6f;
    return true;
}

/* From 0.04 of a side above the middle of the near border, toward the middle of the land: the ground nearby is sharp, and far away
 * a pixel holds many cells. */
static bool open_view(view *v, const tradeoff_land *land, size_t factor, const tradeoff_options *o, io_error *error) {
    *v = (view){0};
    cw_field *field = land->field;
    if (factor > 1) {
        if (cw_field_coarser(field, NULL, factor, CW_FILTER_MEAN, &v->own, NULL) != CW_OK)
            return io_fail(error, "coarser land: %s", cw_last_error());
        v->z = tradeoff_samples_of(v->own);
        field = v->own;
    }
    const cw_field_info info = cw_field_describe(field);
    const double side = (double)(land->samples.nx - 1), step = (double)factor;
    const size_t i = land->samples.nx / 2, j = land->samples.ny / 50;
    landscape_desc d = {.field = field,
                        .samples = v->z ? v->z : land->samples.z,
                        .nx = info.nx,
                        .ny = info.ny,
                        .to_world = {{step, 0, 0, 0}, {0, step, 0, 0}, {0, 0, 1, 0}},
                        .field_of_view = 50,
                        .eye = {(double)i, (double)j, (double)cw_field_row(land->field, j)[i] + 0.04 * side},
                        .target = {side / 2, side / 2, 0},
                        .sun = {-0.62, -0.48, 0.62},
                        .sun_light = 0.85,
                        .sky_light = 0.3,
                        .horizon = {0.70f, 0.80f, 0.93f},
                        .above = {0.16f, 0.34f, 0.70f},
                        .width = o->quick ? WIDTH / 30 : WIDTH,
                        .height = o->quick ? HEIGHT / 32 : HEIGHT,
                        .samples_a_pixel = 1};
    io_image colours = {0};
    if (!paint(&colours, error)) return false;
    d.colours = &colours;
    v->scene = landscape_create(&d, error);
    if (!o->quick) v->part = (scene_crop){LEFT, 0, RIGHT, HEIGHT};
    if (v->scene == NULL) io_image_free(&colours);
    return v->scene != NULL;
}

static void close_view(view *v) {
    if (v->scene) scene_free(v->scene);
    cw_field_destroy(v->own);
    free(v->z);
}

static bool draw(const view *v, unsigned samples, uint32_t seed, io_image *image, double *seconds, io_error *error) {
    const scene_render_options options = {
        .threads = 1, .samples = samples, .seed = seed, .phong = true, .crop = v->part};
    const double start = clock_cpu_seconds(); /* one thread */
    const bool good = scene_render(v->scene, &options, image, NULL, error);
    *seconds = clock_cpu_seconds() - start;
    return good;
}

static bool measure(const view *v, size_t factor, unsigned samples, const char *name, const io_image *truth,
                    json_t *lines, io_error *error) {
    double seconds[REPEATS];
    io_image image = {0};
    for (int k = 0; k < REPEATS; k++) {
        io_image_free(&image);
        if (!draw(v, samples, 0, &image, &seconds[k], error)) return false;
    }
    const picture_difference d = picture_compare(&image, truth);
    json_t *line = json_object();
    results_set_texts(line, "kind field", (const char *[]){"picture", name});
    results_set_counts(line, "samples_a_pixel factor width height pixels_visibly",
                       (size_t[]){samples, factor, image.width, image.height, d.visible});
    results_set_numbers(line, "rmse worst seconds", (double[]){d.rmse, d.worst, statistics_of(seconds, REPEATS).min});
    results_append(lines, line);
    io_image_free(&image);
    return true;
}

bool tradeoff_pictures_run(const char *name, const tradeoff_options *o, json_t *lines, io_error *error) {
    tradeoff_land land;
    bool skipped, good = tradeoff_land_open(name, &land, &skipped, error);
    if (!good || skipped) return good;
    io_image truth = {0};
    for (size_t factor = 1; good && factor <= 16; factor *= 2) {
        view v;
        double seconds;
        fprintf(stderr, "land %s: pictures, every %zu. sample\n", name, factor);
        good = open_view(&v, &land, factor, o, error);
        /* Another pattern of samples, so that the picture holds none of those that it judges. */
        if (good && factor == 1) good = draw(&v, o->quick ? 64 : MANY, 1, &truth, &seconds, error);
        for (unsigned samples = 1; good && samples <= (o->quick ? 4 : 64); samples *= 2)
            good = measure(&v, factor, samples, name, &truth, lines, error);
        close_view(&v);
    }
    io_image_free(&truth);
    tradeoff_land_close(&land);
    return good;
}
