/* SPDX-License-Identifier: Apache-2.0 */
#include "tradeoff_scenes.h"

#include "results.h"
#include "scene.h"
#include "timing.h"
#include "tradeoff_counts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIELDS_MAX = 16, COUNTED = 64, PEER_WIDTH = 8 };

/* A scene with one mode on each of its fields. */
typedef struct mode_tracer {
    tradeoff_stage stages[FIELDS_MAX];
    contender on[FIELDS_MAX];
    kernel_contender kernels[FIELDS_MAX];
    peer_contender peers[FIELDS_MAX];
    size_t field_count; /* that are open */
    double cpu_seconds;
    uint64_t rays;
} mode_tracer;

typedef struct set {
    scene *scene;
    size_t field_count;
    tradeoff_ground grounds[FIELDS_MAX];
    float *z[FIELDS_MAX];
    tradeoff_counter *counters[FIELDS_MAX];
    tradeoff_counts counts;
    mode_tracer *tracer;
} set;

/* ---- tracing ---- */

static void closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    mode_tracer *t = context;
    const double start = timing_cpu_seconds();
    t->on[field].closest(t->on[field].self, rays, n, hits);
    t->cpu_seconds += timing_cpu_seconds() - start;
    t->rays += n;
}

static void any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    mode_tracer *t = context;
    const double start = timing_cpu_seconds();
    t->on[field].any(t->on[field].self, rays, n, occluded);
    t->cpu_seconds += timing_cpu_seconds() - start;
    t->rays += n;
}

/* Counting is slow: the first rays of each batch stand for it. */
static void count(set *s, size_t field, const cw_ray *rays, size_t n, bool is_any) {
    cw_hit hits[COUNTED];
    const size_t few = n < COUNTED ? n : COUNTED;
    const cw_query query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    if (cw_closest(scene_field(s->scene, field), &query, rays, few, hits) == CW_OK)
        tradeoff_count(s->counters[field], rays, few, hits, is_any, &s->counts);
}

static void counted_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    set *s = context;
    count(s, field, rays, n, false);
    closest(s->tracer, field, rays, n, hits);
}

static void counted_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    set *s = context;
    count(s, field, rays, n, true);
    any(s->tracer, field, rays, n, occluded);
}

/* ---- setting up ---- */

static void close_tracer(mode_tracer *t) {
    for (size_t f = 0; f < t->field_count; f++) tradeoff_stage_close(&t->stages[f]);
    *t = (mode_tracer){0};
}

/* The kernel that the library chooses, or the one that has the mode; Embree at its usual width. *runs is false where this
 * machine has none. */
static bool open_tracer(set *s, mode_tracer *t, const tradeoff_mode *mode, cw_isa isa, bool *runs, io_error *error) {
    *t = (mode_tracer){0};
    *runs = !mode->embree || peer_embree_version();
    for (size_t f = 0; *runs && f < s->field_count; f++) {
        cw_field *base = scene_field(s->scene, f);
        if (!tradeoff_stage_open(&t->stages[f], mode, base, &s->grounds[f], isa, error)) return false;
        t->field_count++;
        if (mode->embree) {
            tradeoff_stage_peer(&t->stages[f], PEER_WIDTH, true, &t->on[f], &t->peers[f]);
            continue;
        }
        const cw_query automatic = cw_query_default();
        const cw_kernel *kernel = mode->only ? cw_kernel_find(mode->only) : cw_query_kernel(base, &automatic);
        cw_status status = CW_ERROR_UNAVAILABLE;
        if (cw_kernel_exists(kernel)) status = tradeoff_stage_kernel(&t->stages[f], kernel, &t->on[f], &t->kernels[f]);
        if (status == CW_ERROR_UNAVAILABLE || status == CW_ERROR_UNSUPPORTED)
            *runs = false;
        else if (status != CW_OK)
            return io_fail(error, "mode %s: %s", mode->name, cw_status_message(status));
    }
    return true;
}

static bool open_set(set *s, const char *file, io_error *error) {
    s->scene = scene_load(file, NULL, NULL, error);
    if (s->scene == NULL) return false;
    s->field_count = scene_field_count(s->scene);
    if (s->field_count > FIELDS_MAX) return io_fail(error, "%s: more than %d height fields", file, FIELDS_MAX);
    for (size_t f = 0; f < s->field_count; f++) {
        cw_field *field = scene_field(s->scene, f);
        const cw_field_info info = cw_field_describe(field);
        s->z[f] = malloc(info.nx * info.ny * sizeof *s->z[f]);
        if (s->z[f] == NULL || cw_field_build(field, cw_kernel_find("cell")) != CW_OK)
            return io_fail(error, "%s: out of memory", file);
        for (size_t k = 0; k < info.nx * info.ny; k++) s->z[f][k] = cw_field_sample(field, k % info.nx, k / info.nx);
        s->grounds[f] = tradeoff_ground_of(s->z[f], info.nx, info.ny);
        s->counters[f] = tradeoff_counter_make(&s->grounds[f]);
        if (s->counters[f] == NULL) return io_fail(error, "%s: out of memory", file);
    }
    return true;
}

static void close_set(set *s) {
    for (size_t f = 0; f < FIELDS_MAX; f++) {
        tradeoff_counter_free(s->counters[f]);
        free(s->z[f]);
    }
    if (s->scene) scene_free(s->scene);
}

/* ---- pictures ---- */

tradeoff_picture tradeoff_compare(const io_image *a, const io_image *b) {
    tradeoff_picture p = {0};
    double squares = 0;
    for (size_t k = 0; k < a->width * a->height; k++) {
        double seen = 0;
        for (size_t c = 0; c < 3; c++) {
            const double x = fmax(0, fmin(1, (double)a->rgb[3 * k + c])),
                         y = fmax(0, fmin(1, (double)b->rgb[3 * k + c]));
            squares += (x - y) * (x - y);
            seen = fmax(seen, fabs(x - y));
        }
        p.differ += seen > 0;
        p.visible += seen > 0.5 / 255;
        if (!(seen > p.worst)) continue;
        p.worst = seen;
        p.worst_x = k % a->width;
        p.worst_y = k / a->width;
    }
    p.rmse = sqrt(squares / (3 * (double)(a->width * a->height)));
    return p;
}

static json_t *picture_line(const char *name, const tradeoff_mode *mode, const mode_tracer *t, const io_image *image,
                            const io_image *strict) {
    const tradeoff_picture p = tradeoff_compare(image, strict);
    json_t *line = json_object();
    results_set_text(line, "kind", "picture");
    results_set_text(line, "scene", name);
    results_set_text(line, "mode", mode->name);
    results_set_text(line, "contender", t->on[0].name);
    results_set_count(line, "pixels", image->width * image->height);
    results_set_count(line, "pixels_differ", p.differ);
    results_set_count(line, "pixels_visibly", p.visible);
    results_set_number(line, "rmse", p.rmse);
    results_set_number(line, "worst", p.worst);
    results_set_count(line, "worst_x", p.worst_x);
    results_set_count(line, "worst_y", p.worst_y);
    results_set_count(line, "traced_rays", t->rays);
    results_set_number(line, "trace_mrays_per_s", (double)t->rays / t->cpu_seconds * 1e-6);
    return line;
}

static bool add_counts(const set *s, const char *name, json_t *lines) {
    json_t *line = json_object();
    results_set_text(line, "kind", "count");
    results_set_text(line, "where", name);
    results_set_text(line, "rays", "its own");
    tradeoff_counts_set(line, &s->counts);
    return json_array_append_new(lines, line) == 0;
}

/* Renders with a mode; the first, which is strict, becomes the one to compare with and counts. */
static bool render_mode(set *s, const char *name, const tradeoff_mode *mode, const tradeoff_options *o,
                        io_image *strict, json_t *lines, io_error *error) {
    mode_tracer *t = calloc(1, sizeof *t);
    if (t == NULL) return io_fail(error, "out of memory");
    bool runs = false, good = open_tracer(s, t, mode, o->isa, &runs, error);
    io_image image = {0};
    if (good && runs) {
        const bool first = strict->rgb == NULL;
        s->tracer = t;
        const scene_tracer plain = {t, closest, any}, counting = {s, counted_closest, counted_any};
        scene_render_options options = {
            .tracer = first ? &counting : &plain, .threads = 1, .samples = (unsigned)o->samples};
        options.phong = true;
        good = scene_render(s->scene, &options, &image, NULL, error);
        if (!good) image = (io_image){0};
        if (good && first) *strict = image;
        good = good && (json_array_append_new(lines, picture_line(name, mode, t, &image, strict)) == 0 ||
                        io_fail(error, "out of memory"));
        if (!first) io_image_free(&image);
    }
    close_tracer(t);
    free(t);
    return good;
}

bool tradeoff_scene_run(const char *name, const char *file, const tradeoff_options *o, json_t *lines, io_error *error) {
    set s = {0};
    io_image strict = {0};
    bool good = open_set(&s, file, error);
    for (size_t m = 0; good && m < tradeoff_mode_count(); m++) {
        const tradeoff_mode *mode = tradeoff_mode_at(m);
        if (m > 0 && !tradeoff_mode_wanted(mode, o)) continue; /* the first is what others are held against */
        good = render_mode(&s, name, mode, o, &strict, lines, error);
    }
    good = good && (add_counts(&s, name, lines) || io_fail(error, "out of memory"));
    io_image_free(&strict);
    close_set(&s);
    return good;
}
