/* SPDX-License-Identifier: Apache-2.0 */
/* One scene of the table: verify on the scene's own rays, then render by all paths in rounds. */

#include "clock.h"
#include "harness/interleave.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "peers/embree.h"
#include "scenes/table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TRACERS_MAX = TABLE_PATHS_MAX + PEER_WIDTH_COUNT };

/* A kernel or a width of Embree, on each of the scene's fields. Paths that differ only in their normals share one. */
typedef struct tracer {
    const cw_kernel *kernel; /* NULL with embree, or the library's choice */
    bool embree;
    field_tracer fields;
    double build_seconds, verify_seconds;
    agreement agreement;
} tracer;

typedef struct stage {
    scene *scene;
    size_t field_count;
    peer_embree *embree[SCENE_FIELDS_MAX];
    tracer reference, tracers[TRACERS_MAX];
    size_t tracer_count;
    cw_hit hits[SCENE_BATCH];
    uint8_t occluded[SCENE_BATCH];
} stage;

/* A rendering that interleave() repeats. */
typedef struct job {
    interleave_job timing;
    stage *on;
    const table_path *path;
    tracer *tracer;
    unsigned samples;
    double trace_seconds[INTERLEAVE_SAMPLES_MAX];
    size_t runs;
    uint64_t traced;
    io_image image; /* of the last run */
    scene_render_stats stats;
    io_error error;
} job;

/* ---- verifying: the reference answers and everyone else is asked the same ---- */

static void verify_closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    stage *s = context;
    field_tracer_of(&s->reference.fields).closest(&s->reference.fields, field, rays, n, hits);
    for (tracer *t = s->tracers; t < s->tracers + s->tracer_count; t++) {
        const double start = clock_cpu_seconds();
        field_tracer_of(&t->fields).closest(&t->fields, field, rays, n, s->hits);
        t->verify_seconds += clock_cpu_seconds() - start;
        agree_closest(&t->agreement, scene_field(s->scene, field), rays, n, hits, s->hits);
    }
}

static void verify_any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    stage *s = context;
    field_tracer_of(&s->reference.fields).any(&s->reference.fields, field, rays, n, occluded);
    for (tracer *t = s->tracers; t < s->tracers + s->tracer_count; t++) {
        const double start = clock_cpu_seconds();
        field_tracer_of(&t->fields).any(&t->fields, field, rays, n, s->occluded);
        t->verify_seconds += clock_cpu_seconds() - start;
        agree_any(&t->agreement, scene_field(s->scene, field), rays, n, occluded, s->occluded,
                  &s->reference.fields.on[field], &t->fields.on[field]);
    }
}

static bool verify(stage *s, io_error *error) {
    const scene_tracer all = {s, verify_closest, verify_any};
    const scene_render_options options = {.tracer = &all, .threads = 1, .samples = 1, .phong = true};
    io_image image = {0};
    const bool good = scene_render(s->scene, &options, &image, NULL, error);
    if (good) io_image_free(&image);
    return good;
}

/* ---- setting up ---- */

static bool tracer_for_kernel(stage *s, tracer *t, const cw_kernel *kernel, cw_leaf leaf, io_error *error) {
    t->kernel = kernel;
    for (size_t f = 0; f < s->field_count; f++) {
        cw_field *field = scene_field(s->scene, f);
        const cw_kernel *chosen = kernel ? kernel : cw_run_kernel(field, NULL);
        const double before = cw_field_describe(field).build_seconds;
        const cw_status status = contender_from_kernel(&t->fields.on[f], field, chosen, leaf);
        if (status != CW_OK)
            return io_fail(error, "%s on field %zu of the scene: %s", t->fields.on[f].name, f, cw_last_error());
        t->build_seconds += cw_field_describe(field).build_seconds - before;
    }
    return true;
}

/* One for each width. */
static bool tracers_for_embree(stage *s, cw_isa isa, io_error *error) {
    const peer_options options = {.isa = isa, .geometry = PEER_TRIANGLES, .quality = PEER_HIGH};
    for (size_t f = 0; f < s->field_count; f++) {
        s->embree[f] = peer_embree_create(scene_field(s->scene, f), &options, error);
        if (s->embree[f] == NULL) return false;
        for (size_t w = 0; w < PEER_WIDTH_COUNT; w++) {
            tracer *t = &s->tracers[s->tracer_count + w];
            t->embree = true;
            t->build_seconds += peer_embree_describe(s->embree[f]).build_seconds;
            contender_from_peer(&t->fields.on[f], s->embree[f], peer_embree_widths[w], true, "embree/triangles");
        }
    }
    s->tracer_count += PEER_WIDTH_COUNT;
    return true;
}

/* The tracer of a path, of Embree's widths the one that was fastest while verifying; NULL if there is none yet. */
static tracer *tracer_of(stage *s, const table_path *path) {
    tracer *best = NULL;
    for (tracer *t = s->tracers; t < s->tracers + s->tracer_count; t++) {
        if (t->embree != path->embree || (!t->embree && t->kernel != path->kernel)) continue;
        if (best == NULL || t->verify_seconds < best->verify_seconds) best = t;
    }
    return best;
}

static bool open_stage(stage *s, const char *name, const table_path *paths, size_t path_count, const table_options *o,
                       io_error *error) {
    s->scene = scene_open(o->scene_folder, name, error);
    if (s->scene == NULL) return false;
    s->field_count = scene_field_count(s->scene);
    bool good = tracer_for_kernel(s, &s->reference, cw_kernel_find("cell"), CW_LEAF_WATERTIGHT, error);
    for (size_t p = 0; good && p < path_count; p++) {
        if (tracer_of(s, &paths[p])) continue;
        good = paths[p].embree
                   ? tracers_for_embree(s, (cw_isa)o->run.isa, error)
                   : tracer_for_kernel(s, &s->tracers[s->tracer_count++], paths[p].kernel, (cw_leaf)o->leaf, error);
    }
    return good;
}

static void close_stage(stage *s) {
    for (size_t f = 0; f < s->field_count; f++) peer_embree_destroy(s->embree[f]);
    if (s->scene) scene_free(s->scene);
    free(s);
}

/* ---- rendering ---- */

/* The renderer takes the time of tracing by the clock: to read CPU time at each of its questions takes 1.4 us, 3 to 4 % of a
 * picture. The time that the system gave to other programs is left out in proportion. */
static void render(void *context) {
    job *j = context;
    if (j->error.text[0] || j->runs == INTERLEAVE_SAMPLES_MAX) return;
    field_tracer *fields = &j->tracer->fields;
    const scene_tracer own = field_tracer_of(fields);
    const scene_render_options options = {
        .tracer = &own, .threads = 1, .samples = j->samples, .phong = true, .normals = j->path->normals};
    io_image_free(&j->image);
    fields->rays = 0;
    const double start = clock_seconds(), cpu_start = clock_cpu_seconds();
    if (!scene_render(j->on->scene, &options, &j->image, &j->stats, &j->error)) j->image = (io_image){0};
    const double cpu = clock_cpu_seconds() - cpu_start, seconds = clock_seconds() - start;
    j->trace_seconds[j->runs++] = j->stats.trace_seconds * (cpu / seconds);
    j->traced = fields->rays;
}

/* ---- results ---- */

static json_t *path_json(job *jobs, size_t count, size_t k) {
    job *j = &jobs[k];
    const tracer *t = j->tracer;
    const statistics trace = statistics_of(j->trace_seconds, j->runs);
    json_t *line = json_object();
    results_set_texts(
        line, "path title by",
        (const char *[]){j->path->name, j->path->title, t->embree ? "embree/triangles" : t->fields.on[0].name});
    if (t->embree) results_set_count(line, "embree_width", t->fields.on[0].width);
    results_set_bool(line, "phong", j->path->normals != SCENE_NORMALS_FLAT);
    results_set_seconds(line, &j->timing.seconds);
    results_set_count(line, "traced_rays", j->traced);
    results_set_numbers(
        line, "cpu_share trace_seconds_median trace_mrays_per_s build_seconds",
        (double[]){j->timing.cpu_share, trace.median, (double)j->traced / trace.median * 1e-6, t->build_seconds});
    json_object_set_new(line, "agreement", results_agreement(&t->agreement));

    /* Ratios are taken against Embree, pictures against the reference kernel's, or else the first other one that is not
     * Embree's, all with the same normals. */
    const job *against = NULL;
    for (size_t o = 0; o < count; o++) {
        if (jobs[o].path->normals != j->path->normals) continue;
        if (jobs[o].path->embree) {
            results_set_number(line, "time_to_default", j->timing.seconds.median / jobs[o].timing.seconds.median);
            continue;
        }
        const bool reference = strcmp(jobs[o].tracer->fields.on[0].name, j->on->reference.fields.on[0].name) == 0;
        if (against == NULL || reference) against = &jobs[o];
    }
    if (against == NULL) return line;
    const picture_difference d = picture_compare(&j->image, &against->image);
    results_set_text(line, "pixels_against", against->path->name);
    results_set_counts(line, "pixels pixels_differ pixels_visibly", (size_t[]){d.pixels, d.differ, d.visible});
    results_set_number(line, "pixels_worst", d.worst);
    return line;
}

static json_t *scene_json(const char *name, stage *s, job *jobs, size_t count) {
    json_t *line = json_object(), *fields = json_array(), *paths = json_array();
    const scene_render_stats *stats = &jobs[0].stats;
    results_set_texts(line, "kind scene", (const char *[]){"scene", name});
    results_set_counts(line, "width height camera_rays shadow_rays mirror_rays field_queries",
                       (size_t[]){scene_width(s->scene), scene_height(s->scene), stats->camera_rays, stats->shadow_rays,
                                  stats->mirror_rays, stats->field_queries});
    for (size_t f = 0; f < s->field_count; f++) {
        const cw_field_info info = cw_field_describe(scene_field(s->scene, f));
        json_t *field = json_object();
        results_set_counts(field, "nx ny", (size_t[]){info.nx, info.ny});
        json_array_append_new(fields, field);
    }
    json_object_set_new(line, "fields", fields);
    results_set_text(line, "reference", s->reference.fields.on[0].name);
    for (size_t k = 0; k < count; k++) json_array_append_new(paths, path_json(jobs, count, k));
    json_object_set_new(line, "paths", paths);
    return line;
}

json_t *table_scene_run(const char *name, const table_path *paths, size_t path_count, const table_options *o,
                        double seconds, io_error *error) {
    const double end = clock_seconds() + seconds;
    json_t *line = NULL;
    stage *s = memory(1, sizeof *s);
    job *jobs = memory(path_count, sizeof *jobs);
    interleave_job *timed[TABLE_PATHS_MAX];
    bool good = open_stage(s, name, paths, path_count, o, error) && verify(s, error);
    for (size_t k = 0; good && k < path_count; k++) {
        jobs[k] = (job){.on = s, .path = &paths[k], .samples = o->samples, .tracer = tracer_of(s, &paths[k])};
        jobs[k].timing = (interleave_job){.run = render, .context = &jobs[k]};
        timed[k] = &jobs[k].timing;
    }
    const interleave_limits limits = {.width = o->width,
                                      .seconds = fmax(0, end - clock_seconds()),
                                      .least = o->quick ? 1 : 3,
                                      .most = 50,
                                      .seed = o->run.seed};
    if (good) interleave(timed, path_count, &limits);
    for (size_t k = 0; good && k < path_count; k++)
        if (jobs[k].error.text[0]) good = io_fail(error, "%s: %s", paths[k].name, jobs[k].error.text);
    if (good) line = scene_json(name, s, jobs, path_count);
    for (size_t k = 0; k < path_count; k++) io_image_free(&jobs[k].image);
    free(jobs);
    close_stage(s);
    return line;
}
