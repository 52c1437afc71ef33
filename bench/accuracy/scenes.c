/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/tradeoff.h"

#include "harness/memory.h"
#include "harness/results.h"
#include "scenes/table.h"

#include <stdlib.h>

/* A scene, and one mode at a time on each of its fields. */
typedef struct set {
    scene *scene;
    size_t field_count, open; /* stages that are open */
    true_surface surfaces[SCENE_FIELDS_MAX];
    float *z[SCENE_FIELDS_MAX];
    tradeoff_stage stages[SCENE_FIELDS_MAX];
    field_tracer tracer;
} set;

/* ---- setting up ---- */

static void close_mode(set *s) {
    for (size_t f = 0; f < s->open; f++) tradeoff_stage_close(&s->stages[f]);
    s->open = 0;
}

/* The kernel that the library chooses, or the one that has the mode; Embree at its usual width. *runs is false where this
 * machine has none. */
static bool open_mode(set *s, const tradeoff_mode *mode, cw_isa isa, bool *runs, io_error *error) {
    field_tracer *t = &s->tracer;
    *t = (field_tracer){.rays = 0};
    *runs = !mode->embree || peer_embree_version();
    for (size_t f = 0; *runs && f < s->field_count; f++) {
        cw_field *base = scene_field(s->scene, f);
        if (!tradeoff_stage_open(&s->stages[f], mode, base, &s->surfaces[f], isa, error)) return false;
        s->open++;
        if (mode->embree) {
            contender_from_peer(&t->on[f], s->stages[f].peer, 8, true, mode->name);
            continue;
        }
        const cw_kernel *kernel = cw_run_kernel(base, NULL);
        const cw_status status = tradeoff_stage_kernel(&s->stages[f], kernel, &t->on[f]);
        if (status == CW_ERROR_KERNEL)
            *runs = false;
        else if (status != CW_OK)
            return io_fail(error, "mode %s: %s", mode->name, cw_last_error());
    }
    return true;
}

static bool open_set(set *s, const char *folder, const char *name, io_error *error) {
    s->scene = scene_open(folder, name, error);
    if (s->scene == NULL) return false;
    s->field_count = scene_field_count(s->scene);
    for (size_t f = 0; f < s->field_count; f++) {
        cw_field *field = scene_field(s->scene, f);
        const cw_field_info info = cw_field_describe(field);
        const cw_status status = cw_field_build(field, &(cw_run){.kernel = cw_kernel_find("cell")});
        if (status != CW_OK) return io_fail(error, "scene %s: %s", name, cw_last_error());
        s->z[f] = memory(info.nx * info.ny, sizeof *s->z[f]);
        for (size_t k = 0; k < info.nx * info.ny; k++) s->z[f][k] = cw_field_row(field, k / info.nx)[k % info.nx];
        s->surfaces[f] = true_surface_of(s->z[f], info.nx, info.ny);
    }
    return true;
}

static void close_set(set *s) {
    for (size_t f = 0; f < SCENE_FIELDS_MAX; f++) free(s->z[f]);
    if (s->scene) scene_free(s->scene);
    free(s);
}

/* ---- pictures ---- */

static json_t *picture_line(const char *name, const tradeoff_mode *mode, const field_tracer *t, const io_image *image,
                            const io_image *strict) {
    const picture_difference d = picture_compare(image, strict);
    json_t *line = json_object();
    results_set_texts(line, "kind scene mode contender", (const char *[]){"picture", name, mode->name, t->on[0].name});
    results_set_counts(line, "pixels pixels_differ pixels_visibly worst_x worst_y traced_rays",
                       (size_t[]){d.pixels, d.differ, d.visible, d.worst_x, d.worst_y, t->rays});
    results_set_numbers(line, "rmse worst trace_mrays_per_s",
                        (double[]){d.rmse, d.worst, (double)t->rays / t->cpu_seconds * 1e-6});
    return line;
}

/* Renders with a mode; the first, which is strict, becomes the one to compare with. */
static bool render_mode(set *s, const char *name, const tradeoff_mode *mode, const tradeoff_options *o,
                        io_image *strict, json_t *lines, io_error *error) {
    bool runs = false, good = open_mode(s, mode, (cw_isa)o->run.isa, &runs, error);
    io_image image = {0};
    if (good && runs) {
        const scene_tracer tracer = field_tracer_of(&s->tracer);
        const scene_render_options options = {.tracer = &tracer, .threads = 1, .samples = o->samples, .phong = true};
        const bool first = strict->rgb == NULL;
        good = scene_render(s->scene, &options, &image, NULL, error);
        if (!good) image = (io_image){0};
        if (good && first) *strict = image;
        if (good) results_append(lines, picture_line(name, mode, &s->tracer, &image, strict));
        if (!first) io_image_free(&image);
    }
    close_mode(s);
    return good;
}

bool tradeoff_scene_run(const char *name, const tradeoff_options *o, json_t *lines, io_error *error) {
    set *s = memory(1, sizeof *s);
    io_image strict = {0};
    bool good = open_set(s, o->scene_folder, name, error);
    for (size_t m = 0; good && tradeoff_mode_at(m); m++) {
        if (m > 0 && !tradeoff_mode_wanted(m, o)) continue; /* the others are compared with the first */
        good = render_mode(s, name, tradeoff_mode_at(m), o, &strict, lines, error);
    }
    io_image_free(&strict);
    close_set(s);
    return good;
}
