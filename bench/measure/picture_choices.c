/* SPDX-License-Identifier: Apache-2.0 */
/* FIELD/picture: a view of land in sunlight by samples:N a pixel and coarser:FACTOR, against 1024 samples a pixel on the full
 * land. Of the view of 1200 × 800 pixels a strip 64 wide is drawn. */

#include "harness/memory.h"
#include "harness/results.h"
#include "landscape.h"
#include "measure/measure.h"

#include <stdio.h>
#include <string.h>

enum { TRUTH = 1024, WIDTH = 1200, HEIGHT = 800, LEFT = 576, RIGHT = 640 };

typedef struct view {
    scene *scene;
    float *z; /* of coarser land */
    unsigned samples;
    uint32_t seed;
    io_image image;
    bool failed;
} view;

typedef struct views {
    land *land;
    view truth;
} views;

static bool has(const char *field, const char *item) {
    return strcmp(field, "scenes") != 0 && strcmp(item, "picture") == 0;
}

/* From 0.04 of a side above the middle of the near border, toward the middle of the land: the ground nearby is sharp, and far away
 * a pixel holds many cells. */
static bool open_view(view *v, land *l, size_t factor, io_error *error) {
    cw_field *field = land_coarser(l, factor, error);
    if (field == NULL) return false;
    const cw_field_info info = cw_field_describe(field);
    if (factor > 1) {
        v->z = memory(info.nx * info.ny, sizeof *v->z);
        for (size_t j = 0; j < info.ny; j++) memcpy(v->z + j * info.nx, cw_field_row(field, j), info.nx * sizeof *v->z);
    }
    const double side = (double)(l->samples.nx - 1), step = (double)factor;
    const size_t i = l->samples.nx / 2, j = l->samples.ny / 50;
    landscape_desc d = {.field = field,
                        .samples = v->z ? v->z : l->samples.z,
                        .nx = info.nx,
                        .ny = info.ny,
                        .to_world = {{step, 0, 0, 0}, {0, step, 0, 0}, {0, 0, 1, 0}},
                        .field_of_view = 50,
                        .eye = {(double)i, (double)j, (double)l->samples.z[j * l->samples.nx + i] + 0.04 * side},
                        .target = {side / 2, side / 2, 0},
                        .sun = {-0.62, -0.48, 0.62},
                        .sun_light = 0.85,
                        .sky_light = 0.3,
                        .horizon = {0.70f, 0.80f, 0.93f},
                        .above = {0.16f, 0.34f, 0.70f},
                        .width = WIDTH,
                        .height = HEIGHT,
                        .samples_a_pixel = 1};
    io_image grey = {0};
    if (!io_image_allocate(&grey, 1, 1, false, "", error)) return false;
    for (int c = 0; c < 3; c++) grey.rgb[c] = 0.6f;
    d.colours = &grey;
    v->scene = landscape_create(&d, error);
    if (v->scene == NULL) io_image_free(&grey);
    return v->scene != NULL;
}

static void draw(void *context) {
    view *v = context;
    io_error error;
    const scene_render_options options = {
        .threads = 1, .samples = v->samples, .seed = v->seed, .phong = true, .crop = {LEFT, 0, RIGHT, HEIGHT}};
    io_image_free(&v->image);
    v->image = (io_image){0};
    v->failed = !scene_render(v->scene, &options, &v->image, NULL, &error) || v->failed;
}

static bool open_views(workload *w, io_error *error) {
    views *all = w->own = memory(1, sizeof *all);
    all->land = land_of(w->field, w->options, w->why, error);
    if (all->land == NULL) return w->why[0] != '\0';
    /* Another pattern of samples, so that the picture holds none of those that it judges. */
    all->truth = (view){.samples = TRUTH, .seed = 1};
    w->items = (double)((RIGHT - LEFT) * HEIGHT);
    return open_view(&all->truth, all->land, 1, error);
}

static bool enter(workload *w, const char *name, io_error *error) {
    views *all = w->own;
    unsigned factor = 1, samples = 1;
    const bool good =
        sscanf(name, "coarser:%u:samples:%u", &factor, &samples) == 2 || sscanf(name, "samples:%u", &samples) == 1;
    if (!good || samples < 1 || samples > TRUTH || factor < 1 || factor > FACTOR_MAX)
        return io_fail(error, "contender %s: pictures have samples:N and coarser:FACTOR:samples:N", name);
    entrant *e = measure_enter(w, name, name, error);
    if (e == NULL) return false;
    view *v = e->own = memory(1, sizeof *v);
    *v = (view){.samples = samples};
    e->job = (interleave_job){.run = draw, .context = v};
    return open_view(v, all->land, factor, error);
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    views *all = w->own;
    view *v = e->own;
    draw(v);
    if ((metrics & METRIC_ERROR) && all->truth.image.rgb == NULL) draw(&all->truth);
    if (v->failed || all->truth.failed) return io_fail(error, "%s of %s: out of memory", e->name, w->name);
    if ((metrics & METRIC_ERROR) == 0) return true;
    const picture_difference d = picture_compare(&v->image, &all->truth.image);
    results_set_numbers(e->line, "rmse worst", (double[]){d.rmse, d.worst});
    return true;
}

static void release(view *v) {
    if (v->scene) scene_free(v->scene);
    io_image_free(&v->image);
    free(v->z);
}

static void leave(entrant *e) {
    release(e->own);
    free(e->own);
}

static void close_views(workload *w) {
    views *all = w->own;
    release(&all->truth);
    free(all);
}

const workload_kind measure_picture = {
    "FIELD/picture", "a view of the land, against 1024 samples a pixel", "pixels", has, open_views, enter, judge, leave,
    close_views};
