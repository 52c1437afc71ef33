/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/table.h"

#include <math.h>

const char *scene_names(size_t number) {
    static const char *const names[SCENES] = {"hftest",    "landsea-0", "landsea-1",
                                              "landsea-2", "texture",   "landsea-big"};
    return number < SCENES ? names[number] : NULL;
}

scene *scene_open(const char *folder, const char *name, io_error *error) {
    char file[4096];
    if (snprintf(file, sizeof file, "%s/%s.pbrt", folder, name) >= (int)sizeof file) {
        io_fail(error, "--scenes %s: the name is too long", folder);
        return NULL;
    }
    scene *s = scene_load(file, 1, NULL, NULL, error);
    if (s == NULL || scene_field_count(s) <= SCENE_FIELDS_MAX) return s;
    io_fail(error, "%s: more than %d height fields", file, SCENE_FIELDS_MAX);
    scene_free(s);
    return NULL;
}

static void trace(void *context, const contender_pass *pass) {
    field_tracer *t = context;
    contender_pass p = *pass;
    contender_run(&p);
    t->rays += p.n;
}

static void closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    field_tracer *t = context;
    trace(t, &(contender_pass){.of = &t->on[field], .rays = rays, .n = n, .out.hits = hits});
}

static void any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    field_tracer *t = context;
    trace(t, &(contender_pass){.of = &t->on[field], .rays = rays, .n = n, .any = true, .out.occluded = occluded});
}

scene_tracer field_tracer_of(field_tracer *tracer) { return (scene_tracer){tracer, closest, any}; }

picture_difference picture_compare(const io_image *a, const io_image *b) {
    picture_difference d = {.pixels = a->width * a->height};
    double squares = 0;
    for (size_t k = 0; k < d.pixels; k++) {
        double seen = 0;
        bool same = true;
        for (size_t c = 3 * k; c < 3 * k + 3; c++) {
            const double x = fmax(0, fmin(1, (double)a->rgb[c])), y = fmax(0, fmin(1, (double)b->rgb[c]));
            same = same && a->rgb[c] == b->rgb[c];
            squares += (x - y) * (x - y);
            seen = fmax(seen, fabs(x - y));
        }
        d.differ += !same;
        d.visible += seen > 0.5 / 255;
        if (!(seen > d.worst)) continue;
        d.worst = seen;
        d.worst_x = k % a->width;
        d.worst_y = k / a->width;
    }
    d.rmse = sqrt(squares / (3 * (double)d.pixels));
    return d;
}
