/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/tradeoff.h"

#include "accuracy/counts.h"
#include "accuracy/normals.h"
#include "accuracy/run.h"
#include "accuracy/scenes.h"
#include "accuracy/summary.h"
#include "build_info.h"
#include "clock.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "harness/timing.h"
#include "output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- counting on the fields ---- */

/* Rays of each class that are counted; their classes alone, the walk is the same for all that has a closest hit. */
enum { COUNTED = 2048 };

static bool count_field(const tradeoff_field *on, const tradeoff_options *o, json_t *lines, io_error *error) {
    tradeoff_counter *counter = tradeoff_counter_make(&on->ground);
    cw_ray *rays = malloc(COUNTED * sizeof *rays);
    cw_hit *hits = malloc(COUNTED * sizeof *hits);
    const cw_query query = {.kernel = cw_kernel_find("cell"), .leaf = CW_LEAF_WATERTIGHT};
    bool good = (counter && rays && hits) || io_fail(error, "out of memory");
    for (int c = 0; good && c < WORKLOAD_CLASS_COUNT; c++) {
        if (!tradeoff_listed(&o->rays, tradeoff_class_name(c))) continue;
        const size_t n = tradeoff_rays_make(on->field, &on->samples, c, (uint32_t)o->seed, COUNTED, rays);
        tradeoff_counts counts = {0};
        good = cw_closest(on->field, &query, rays, n, hits) == CW_OK;
        if (good) tradeoff_count(counter, rays, n, hits, tradeoff_class_is_any(c), &counts);
        json_t *line = json_object();
        results_set_text(line, "kind", "count");
        results_set_text(line, "where", on->samples.name);
        results_set_text(line, "rays", tradeoff_class_name(c));
        tradeoff_counts_set(line, &counts);
        good = (good && json_array_append_new(lines, line) == 0) || io_fail(error, "out of memory");
    }
    tradeoff_counter_free(counter);
    free(rays);
    free(hits);
    return good;
}

/* ---- the run ---- */

static size_t classes_of(const tradeoff_options *o, bool timed) {
    size_t count = 0;
    for (int c = 0; c < TRADEOFF_CLASS_COUNT; c++)
        count += tradeoff_listed(&o->rays, tradeoff_class_name(c)) && (!timed || tradeoff_class_is_timed(c));
    return count;
}

static bool run_fields(const tradeoff_options *o, json_t *lines, io_error *error) {
    double end = clock_seconds() + o->seconds;
    size_t groups = o->fields.count * classes_of(o, true);
    tradeoff_field *on = calloc(1, sizeof *on);
    bool good = on || io_fail(error, "out of memory");
    for (size_t f = 0; good && f < o->fields.count; f++) {
        const double start = clock_seconds();
        fprintf(stderr, "field %s: making it and building Embree\n", o->fields.items[f]);
        good = tradeoff_field_open(on, o->fields.items[f], o, error) && count_field(on, o, lines, error);
        end += clock_seconds() - start; /* building does not count */
        for (int c = 0; good && c < TRADEOFF_CLASS_COUNT; c++) {
            if (!tradeoff_listed(&o->rays, tradeoff_class_name(c))) continue;
            fprintf(stderr, "field %s: %s\n", o->fields.items[f], tradeoff_class_name(c));
            const bool timed = tradeoff_class_is_timed(c);
            const double left = end - clock_seconds();
            good = tradeoff_group_run(on, c, o, timed && left > 0 ? left / (double)groups : 0, lines, error);
            groups -= timed;
        }
        tradeoff_field_close(on);
    }
    free(on);
    return good;
}

static bool run_scenes(const tradeoff_options *o, json_t *lines, io_error *error) {
    for (size_t s = 0; s < o->scenes.count; s++) {
        const char *name = o->scenes.items[s];
        char file[4096];
        if (strcmp(name, "none") == 0) continue;
        fprintf(stderr, "scene %s\n", name);
        if (snprintf(file, sizeof file, "%s/%s.pbrt", o->scene_folder, name) >= (int)sizeof file)
            return io_fail(error, "--scenes %s: the name is too long", o->scene_folder);
        if (!tradeoff_scene_run(name, file, o, lines, error)) return false;
    }
    return true;
}

static json_t *modes_line(void) {
    json_t *line = json_object(), *modes = json_object();
    results_set_text(line, "kind", "modes");
    for (size_t m = 0; m < tradeoff_mode_count(); m++)
        results_set_text(modes, tradeoff_mode_at(m)->name, tradeoff_mode_at(m)->what);
    json_object_set_new(line, "modes", modes);
    return line;
}

bool tradeoff_run(const tradeoff_options *o, json_t *lines, io_error *error) {
    const int cpu = o->no_pin ? -1 : timing_pin(o->cpu == UINT64_MAX ? -1 : (int)o->cpu);
    if (!o->no_pin && cpu < 0)
        return io_fail(error, "--cpu %d: the system does not allow this process there", (int)o->cpu);
    json_t *record = run_record("tradeoff", (uint32_t)o->seed, cpu);
    if (record) {
        results_set_count(record, "rays_a_class", (size_t)o->count);
        results_set_count(record, "samples_a_pixel", (size_t)o->samples);
    }
    if (json_array_append_new(lines, record) != 0 || json_array_append_new(lines, modes_line()) != 0)
        return io_fail(error, "out of memory");
    return run_fields(o, lines, error) && run_scenes(o, lines, error) &&
           tradeoff_normals_run((uint32_t)o->seed, lines, error) && tradeoff_summarise(lines, error);
}
