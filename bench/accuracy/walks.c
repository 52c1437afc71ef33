/* SPDX-License-Identifier: Apache-2.0 */
#include "accuracy/walks.h"

#include "harness/child.h"
#include "harness/results.h"
#include "micro/counters.h"
#include "scenes/tracer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { GRID, CELL, WALKS, RAYS_MAX = 8192 };

/* Both walks on a field. */
typedef struct walks {
    contender on[WALKS];
    kernel_contender kernels[WALKS];
} walks;

/* Sums of what one ray costs. */
typedef struct costs {
    size_t rays;
    uint64_t voxels, voxel_triangles, cells, cell_triangles;
} costs;

static bool open_walks(walks *w, cw_field *field, io_error *error) {
    static const char *const names[WALKS] = {"grid3d", "cell"};
    for (int k = 0; k < WALKS; k++) {
        const cw_status status =
            contender_from_kernel(&w->on[k], &w->kernels[k], field, cw_kernel_find(names[k]), CW_LEAF_DEFAULT);
        if (status != CW_OK) return io_fail(error, "kernel %s: %s", names[k], cw_status_message(status));
    }
    return true;
}

/* What the pass answers is the cell walk's. */
static void count(const walks *w, contender_pass pass, costs *sum) {
    counter all[COUNTERS_MAX];
    counters_reset();
    for (int k = 0; k < WALKS; k++) {
        pass.of = &w->on[k];
        contender_run(&pass);
    }
    counters_read(all);
    sum->rays += pass.n;
    sum->voxels += counters_find(all, "voxel")->events;
    sum->voxel_triangles += counters_find(all, "triangle")->events;
    sum->cells += counters_find(all, "flat")->events;
    sum->cell_triangles += 2 * counters_find(all, "leaf")->events;
}

static bool add_line(json_t *lines, const char *where, const char *rays, const costs *c, io_error *error) {
    const double n = c->rays ? (double)c->rays : 1;
    json_t *line = json_pack("{s:s, s:s, s:s, s:I, s:f, s:f, s:f, s:f}", "kind", "count", "where", where, "rays", rays,
                             "ray_count", (json_int_t)c->rays, "voxels", (double)c->voxels / n, "voxel_triangles",
                             (double)c->voxel_triangles / n, "cells", (double)c->cells / n, "cell_triangles",
                             (double)c->cell_triangles / n);
    return json_array_append_new(lines, line) == 0 || io_fail(error, "out of memory");
}

/* ---- fields ---- */

static bool count_field(const char *name, const tradeoff_options *o, json_t *lines, io_error *error) {
    workload_field samples;
    cw_field *field = NULL;
    walks w;
    const size_t most = o->count < RAYS_MAX ? o->count : RAYS_MAX;
    cw_ray *rays = malloc(most * sizeof *rays);
    cw_hit *hits = malloc(most * sizeof *hits);
    uint8_t *occluded = malloc(most);
    bool good = workload_field_make(name, &samples) && rays && hits && occluded &&
                workload_field_open(&samples, CW_BORROW, false, &field) == CW_OK;
    good = good ? open_walks(&w, field, error) : io_fail(error, "field %s: out of memory", name);
    for (int c = 0; good && c < WORKLOAD_CLASS_COUNT; c++) {
        if (!option_wanted(&o->rays, (size_t)c)) continue;
        costs sum = {0};
        const size_t n = workload_rays_make(field, (workload_class)c, o->run.seed, most, rays);
        count(&w, (contender_pass){NULL, rays, n, workload_class_is_any((workload_class)c), hits, occluded}, &sum);
        good = add_line(lines, name, workload_class_name((workload_class)c), &sum, error);
    }
    cw_field_destroy(field);
    workload_field_free(&samples);
    free(rays);
    free(hits);
    free(occluded);
    return good;
}

/* ---- scenes ---- */

typedef struct scene_walks {
    walks on[SCENE_FIELDS_MAX];
    costs sum;
} scene_walks;

static void closest(void *context, size_t field, const cw_ray *rays, size_t n, cw_hit *hits) {
    scene_walks *s = context;
    count(&s->on[field], (contender_pass){.rays = rays, .n = n, .hits = hits}, &s->sum);
}

static void any(void *context, size_t field, const cw_ray *rays, size_t n, uint8_t *occluded) {
    scene_walks *s = context;
    count(&s->on[field], (contender_pass){.rays = rays, .n = n, .any = true, .occluded = occluded}, &s->sum);
}

static bool count_scene(const char *name, const tradeoff_options *o, json_t *lines, io_error *error) {
    scene *s = scene_open(o->scene_folder, name, error);
    scene_walks *w = calloc(1, sizeof *w);
    bool good = s && (w || io_fail(error, "out of memory"));
    for (size_t f = 0; good && f < scene_field_count(s); f++) good = open_walks(&w->on[f], scene_field(s, f), error);
    if (good) {
        const scene_tracer tracer = {w, closest, any};
        const scene_render_options options = {.tracer = &tracer, .threads = 1, .samples = 1, .phong = true};
        io_image image;
        good = scene_render(s, &options, &image, NULL, error);
        if (good) io_image_free(&image);
    }
    good = good && add_line(lines, name, "its own", &w->sum, error);
    free(w);
    if (s) scene_free(s);
    return good;
}

bool walks_count(const tradeoff_options *o, json_t *lines, io_error *error) {
    bool good = true;
    for (size_t f = 0; good && f < o->fields.count; f++) good = count_field(o->fields.item[f], o, lines, error);
    for (size_t s = 0; good && s < o->scenes.count; s++) good = count_scene(o->scenes.item[s], o, lines, error);
    return good;
}

bool walks_count_elsewhere(int argc, char **argv, const char *folder, json_t *lines, io_error *error) {
    static char flag[] = "--counters";
    char path[4352];
    char **whole = malloc(((size_t)argc + 1) * sizeof *whole);
    if (whole == NULL) return io_fail(error, "out of memory");
    memcpy(whole, argv, (size_t)argc * sizeof *whole);
    whole[argc] = flag;
    const int status = child_run_counting(argc + 1, whole);
    free(whole);
    if (status != 0)
        return io_fail(error, "cellwalk-bench-counting, which counts for the claims, ends with %d", status);
    snprintf(path, sizeof path, "%s/counts.json", folder);
    json_t *counted = results_read(path, error);
    if (counted == NULL) return false;
    size_t index;
    json_t *line;
    json_array_foreach(counted, index, line) {
        if (results_is(line, "count")) json_array_append(lines, line);
    }
    json_decref(counted);
    unlink(path);
    return true;
}

void walks_print(const json_t *lines) {
    size_t index;
    const json_t *line;
    printf("A ray, on average:\n%-12s %-8s %9s %9s %9s %9s\n", "on", "rays", "voxels", "triangles", "cells",
           "triangles");
    json_array_foreach(lines, index, line) {
        if (results_is(line, "count"))
            printf("%-12s %-8s %9.1f %9.1f %9.1f %9.1f\n", results_text(line, "where"), results_text(line, "rays"),
                   results_number(line, "voxels"), results_number(line, "voxel_triangles"),
                   results_number(line, "cells"), results_number(line, "cell_triangles"));
    }
}
