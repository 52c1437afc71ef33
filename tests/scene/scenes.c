/* SPDX-License-Identifier: Apache-2.0 */
/* src/scene as a program for the tests in Python (words.h): scenes are loaded, or made as landscape, and rendered. */

#include "half.h"
#include "landscape.h"
#include "model.h"
#include "reference.h"
#include "words.h"
#include "workload/random.h"

#include <math.h>

static scene *loaded;

static bool keep(scene *s) {
    scene_free(loaded);
    loaded = s;
    if (s == NULL) return false;
    if (scene_field_count(s) > 0) { /* the first one's samples go to the file z */
        const cw_field_info info = cw_field_describe(scene_field(s, 0));
        FILE *file = fopen("z", "wb");
        stop_unless(file != NULL, "z");
        for (size_t j = 0; j < info.ny; j++) fwrite(cw_field_row(scene_field(s, 0), j), sizeof(float), info.nx, file);
        stop_unless(fclose(file) == 0, "z");
    }
    fprintf(answer, "fields=%zu\nwidth=%zu\nheight=%zu\n", scene_field_count(s), scene_width(s), scene_height(s));
    return true;
}

/* Rough land in the sun, in haze, partly under water, below a sky with a plain. 70 x 50 pixels, 6 samples each. */
static bool makes_landscape(io_error *e) {
    enum { NX = 40, NY = 33 };
    static const double level = 0.75;
    static float z[NX * NY];
    static cw_field *field;
    random_state r = {13};
    for (int k = 0; k < NX * NY; k++) z[k] = (float)random_between(&r, -3, 3);
    if (field == NULL) cw_field_create(&(cw_field_desc){.samples = z, .nx = NX, .ny = NY}, NULL, &field);
    io_image colours;
    stop_unless(field && io_image_allocate(&colours, 2, 1, 2, "", e), "landscape");
    for (int k = 0; k < 6; k++) colours.halves[4 + k / 3 * 4 + k % 3] = half_from_float(0.25f + 0.125f * (float)k);
    return keep(landscape_create(&(landscape_desc){.field = field,
                                                   .samples = z,
                                                   .nx = NX,
                                                   .ny = NY,
                                                   .to_world = {{2, 0.25, 0, -40}, {0, 1.5, 0, -20}, {0, 0, 1.25, 0}},
                                                   .colours = &colours,
                                                   .eye = {-20, -30, 14},
                                                   .target = {0, 0, 1},
                                                   .field_of_view = 60,
                                                   .sun = {0.6, 0, 0.8},
                                                   .sun_light = 0.85,
                                                   .sky_light = 0.3,
                                                   .horizon = {0.7f, 0.8f, 0.93f},
                                                   .above = {0.16f, 0.34f, 0.7f},
                                                   .vault = true,
                                                   .plain = {0.2f, 0.27f, 0.16f},
                                                   .visibility = 200,
                                                   .water_level = &level,
                                                   .width = 70,
                                                   .height = 50,
                                                   .samples_a_pixel = 6},
                                 e));
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* Tracers that count rays, and those that do not come near the field's box. What begins there may leave it before tmin;
 * rounding may have put its origin a little outside. */
static uint64_t asked, outside;

static void count_rays(size_t field, const cw_ray *rays, size_t n) {
    const cw_field_info info = cw_field_describe(scene_field(loaded, field));
    const double low[3] = {0, 0, (double)info.low},
                 high[3] = {(double)(info.nx - 1), (double)(info.ny - 1), (double)info.high};
    stop_unless(n <= SCENE_BATCH, "too many rays at once");
    asked += n;
    for (size_t k = 0; k < n; k++) {
        double enter = 0, leave = (double)rays[k].tmax;
        for (int c = 0; c < 3; c++) {
            const double org = (double)rays[k].org[c], dir = (double)rays[k].dir[c], room = 1e-5 * (1 + fabs(org));
            enter = fmax(enter, ((dir < 0 ? high[c] + room : low[c] - room) - org) / dir);
            leave = fmin(leave, ((dir < 0 ? low[c] - room : high[c] + room) - org) / dir);
        }
        outside += enter > leave;
    }
}

static void watch_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    count_rays(field, rays, n);
    if (context == NULL) cw_closest(scene_field(loaded, field), NULL, rays, n, hits);
    for (size_t k = 0; k < n && context; k++) hits[k] = (cw_hit){.t = INFINITY, .i = -1, .j = -1};
}

static void watch_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    count_rays(field, rays, n);
    cw_occluded(scene_field(loaded, field), NULL, rays, n, occluded);
}

typedef struct watching {
    double last;
    bool falls, vanish;
} watching;

static void watch(void *context, double share) {
    watching *w = context;
    w->falls |= !(share > w->last && share <= 1);
    w->last = share;
    if (w->vanish) cw_isa_limit(CW_ISA_SCALAR); /* so a kernel that is there at the beginning is not until the end */
}

/* kernel, leaf and isa: numbers from 1 on; tracer: 1 finds the same, 2 nothing. Pixels go to a file. */
static bool renders(const char *words, io_error *e) {
    const scene_tracer tracers[] = {{NULL, watch_closest, watch_any}, {&asked, watch_closest, NULL}};
    const size_t kernel = option(words, "kernel="), tracer = option(words, "tracer="), isa = option(words, "isa=");
    watching w = {.vanish = option(words, "vanish=") != 0};
    const scene_render_options options = {
        .query.expert = {.kernel = kernel ? cw_kernel_at(kernel - 1) : NULL, .leaf = (cw_leaf)option(words, "leaf=")},
        .tracer = tracer ? &tracers[tracer - 1] : NULL,
        .threads = (unsigned)option(words, "threads="),
        .samples = (unsigned)option(words, "samples="),
        .seed = (uint32_t)option(words, "seed="),
        .width = option(words, "width="),
        .height = option(words, "height="),
        .crop = {option(words, "x0="), option(words, "y0="), option(words, "x1="), option(words, "y1=")},
        .phong = option(words, "phong=") != 0,
        .general = option(words, "general=") != 0,
        .progress = watch,
        .progress_context = &w};
    cw_isa_limit(isa ? (cw_isa)(isa - 1 + CW_ISA_SCALAR) : CW_ISA_ANY);
    if (isa && cw_isa_best() != (cw_isa)(isa - 1 + CW_ISA_SCALAR)) return io_fail(e, "not on this machine");
    io_image image;
    scene_render_stats s;
    asked = outside = 0;
    const bool good = scene_render(loaded, &options, &image, &s, e);
    cw_isa_limit(CW_ISA_ANY);
    stop_unless(good || image.rgb == NULL, "pixels are left");
    if (!good) return false;
    save("pixels", image.rgb, image.width * image.height * 3 * sizeof *image.rgb);
    fprintf(answer,
            "width=%zu\nheight=%zu\ncamera=%zu\nshadow=%zu\nmirror=%zu\nqueries=%zu\nasked=%zu\noutside=%zu\nwhole=%d",
            image.width, image.height, (size_t)s.camera_rays, (size_t)s.shadow_rays, (size_t)s.mirror_rays,
            (size_t)s.field_queries, (size_t)asked, (size_t)outside, w.last == 1 && !w.falls);
    io_image_free(&image);
    return true;
}

static int obey(char **w, io_error *e) {
    if (strcmp(w[0], "load") == 0) return keep(scene_load(w[1], warn, NULL, e));
    if (strcmp(w[0], "landscape") == 0) return makes_landscape(e);
    if (strcmp(w[0], "render") == 0) return renders(w[1], e);
    if (strcmp(w[0], "kernels") != 0) return OTHER;
    for (size_t k = 0; k < cw_kernel_count(); k++)
        fprintf(answer, "%s %d\n", cw_kernel_describe(cw_kernel_at(k)).name,
                cw_kernel_describe(cw_kernel_at(k)).available);
    return DONE;
}

int main(int argc, char **argv) {
    cw_reference_add();
    const int status = words_run(argc, argv, obey);
    scene_free(loaded);
    return status;
}
