/* SPDX-License-Identifier: Apache-2.0 */
/* scenes/NAME: one of the six scenes, rendered with Phong's normals and the rays of each contender. Of Embree's widths
 * the one counts that was fastest while answers were compared. */

#include "clock.h"
#include "harness/harness_memory.h"
#include "harness/results.h"
#include "measure/measure.h"

#include <stdio.h>
#include <string.h>

enum { SCENES = 6, FIELDS_MAX = 16 };

typedef struct stage {
    scene *scene;
    size_t field_count;
    land lands[FIELDS_MAX];
    contender reference[FIELDS_MAX];
} stage;

typedef struct player {
    stage *on;
    ray_contender by[FIELDS_MAX][WIDTHS_MAX];
    size_t widths, width; /* that there are; the one that counts */
    agreement agreement;
    double spent[WIDTHS_MAX]; /* while comparing */
    io_image image;
    bool failed;
} player;

const char *scene_names(size_t number) {
    static const char *const names[SCENES] = {"hftest",    "landsea-0", "landsea-1",
                                              "landsea-2", "texture",   "landsea-big"};
    return number < SCENES ? names[number] : NULL;
}

static bool has(const char *field, const char *item) {
    size_t k = 0;
    while (k < SCENES && strcmp(scene_names(k), item) != 0) k++;
    return strcmp(field, "scenes") == 0 && k < SCENES;
}

scene *scene_of(const char *name, const measure_options *o, io_error *error) {
    char file[4096];
    snprintf(file, sizeof file, "%s/%s.pbrt", o->scenes, name);
    return scene_load(file, NULL, NULL, error);
}

/* Scenes have no coarser fields. */
static bool knows(const char *name, io_error *error) {
    contender_spec s;
    return contenders_parse(&s, name, error) &&
           (s.factor == 1 || io_fail(error, "%s: scenes have no coarser fields", name));
}

static bool open_stage(workload *w, io_error *error) {
    stage *s = w->own = memory(1, sizeof *s);
    fprintf(stderr, "scene %s\n", w->item);
    s->scene = scene_of(w->item, w->options, error);
    if (s->scene == NULL) return false;
    s->field_count = scene_field_count(s->scene);
    if (s->field_count > FIELDS_MAX) return io_fail(error, "%s: more than %d height fields", w->name, FIELDS_MAX);
    for (size_t f = 0; f < s->field_count; f++) {
        land *l = &s->lands[f];
        *l = (land){.field = scene_field(s->scene, f), .borrowed = true};
        snprintf(l->name, sizeof l->name, "%zu of the scene", f);
        if (contender_from_kernel(&s->reference[f], l->field, cw_kernel_find("cell"), CW_LEAF_WATERTIGHT) != CW_OK)
            return io_fail(error, "%s: %s", w->name, cw_last_error());
    }
    w->items = (double)(scene_width(s->scene) * scene_height(s->scene));
    return true;
}

/* ---- tracing ---- */

static void closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    const player *p = context;
    const contender *c = &p->by[field][p->width].contender;
    c->closest(c, rays, n, hits);
}

static void any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    const player *p = context;
    const contender *c = &p->by[field][p->width].contender;
    c->any(c, rays, n, occluded);
}

/* The reference answers, so that all are asked the same; every width is asked too. hits or occluded is NULL. */
static void compare(player *p, size_t field, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    cw_hit own[SCENE_BATCH];
    uint8_t own_any[SCENE_BATCH];
    const contender *reference = &p->on->reference[field];
    const cw_field *on = p->on->lands[field].field;
    contender_run(&(contender_pass){reference, rays, n, occluded != NULL, {hits, occluded}});
    for (p->width = 0; p->width < p->widths; p->width++) {
        const contender *c = &p->by[field][p->width].contender;
        const double start = clock_cpu_seconds();
        contender_run(&(contender_pass){c, rays, n, occluded != NULL, {own, own_any}});
        p->spent[p->width] += clock_cpu_seconds() - start;
        if (occluded)
            agree_any(&p->agreement, on, rays, n, occluded, own_any, reference, c);
        else
            agree_closest(&p->agreement, on, rays, n, hits, own);
    }
}

static void compare_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    compare(context, field, rays, n, hits, NULL);
}

static void compare_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    compare(context, field, rays, n, NULL, occluded);
}

static bool render(player *p, bool compare, io_image *image, io_error *error) {
    const scene_tracer tracer =
        compare ? (scene_tracer){p, compare_closest, compare_any} : (scene_tracer){p, closest, any};
    const scene_render_options options = {.tracer = &tracer, .threads = 1, .samples = compare ? 1 : 0, .phong = true};
    return scene_render(p->on->scene, &options, image, NULL, error);
}

static void render_timed(void *context) {
    player *p = context;
    io_error error;
    io_image_free(&p->image);
    p->image = (io_image){0};
    p->failed = !render(p, false, &p->image, &error) || p->failed;
}

/* ---- contenders ---- */

static bool enter(workload *w, const char *name, io_error *error) {
    stage *s = w->own;
    entrant *e = measure_enter(w, name, name, error);
    if (e == NULL) return false;
    player *p = e->own = memory(1, sizeof *p);
    p->on = s;
    for (size_t f = 0; f < s->field_count && e->why[0] == '\0'; f++)
        if (!contenders_of(&s->lands[f], name, true, (cw_isa)w->options->run.isa, p->by[f], &p->widths, e->why, error))
            return false;
    e->job = (interleave_job){.run = render_timed, .context = p, .by_clock = p->by[0][0].contender.threads > 1};
    return true;
}

static bool judge(workload *w, entrant *e, unsigned metrics, io_error *error) {
    player *p = e->own;
    (void)metrics;
    if (!render(p, true, &p->image, error)) return false;
    p->width = 0;
    for (size_t k = 1; k < p->widths; k++)
        if (p->spent[k] < p->spent[p->width]) p->width = k;
    json_object_set_new(e->line, "agreement", results_agreement(&p->agreement));
    json_object_set_new(e->line, "by", json_string(p->by[0][p->width].contender.name));
    render_timed(p); /* once, to be warm */
    return !p->failed || io_fail(error, "%s could not be rendered by %s", w->name, e->name);
}

static void leave(entrant *e) {
    player *p = e->own;
    for (size_t f = 0; f < p->on->field_count; f++)
        for (size_t k = 0; k < p->widths; k++) contenders_leave(&p->by[f][k]);
    io_image_free(&p->image);
    free(p);
}

static void close_stage(workload *w) {
    stage *s = w->own;
    for (size_t f = 0; f < s->field_count; f++) land_close(&s->lands[f]);
    if (s->scene) scene_free(s->scene);
    free(s);
}

const workload_kind measure_scene = {
    "scenes/NAME", "one of the six scenes, rendered: hftest, landsea-0, landsea-1, landsea-2, texture, landsea-big",
    "pixels",      NULL,
    has,           knows,
    open_stage,    enter,
    judge,         leave,
    close_stage};
