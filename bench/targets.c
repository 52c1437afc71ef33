/* SPDX-License-Identifier: Apache-2.0 */
#include "targets.h"

#include "results.h"
#include "statistics.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *const isas[TARGETS_ISAS] = {"avx512", "avx2", "sse4.2"};
static const char *const speed_files[TARGETS_ISAS] = {"speed-avx512.json", "speed-avx2.json", "speed-sse42.json"};
static const char *const land[] = {"65", "257", "1025", "4097", "8193"}, *const middle[] = {"257", "1025", "4097"};
static const char *const classes[] = {"primary", "shadow", "ao", "bounce", "random", "grazing"};
enum {
    LAND = sizeof land / sizeof land[0],
    MIDDLE = sizeof middle / sizeof middle[0],
    CLASSES = sizeof classes / sizeof classes[0]
};

static const struct {
    const char *title;
    double wanted[TARGETS_ISAS];
    bool at_most, general;
} rows[TARGET_COUNT] = {
    [TARGET_MEAN] = {"all classes, 257² to 4097², geometric mean", {4, 3, 1.5}, false, false},
    [TARGET_PRIMARY] = {"primary, at every size from 65²", {2, 1.6, 1}, false, false},
    [TARGET_SHADOW] = {"shadow, at every size from 65²", {3, 2, 1.2}, false, false},
    [TARGET_SCATTERED] = {"ambient occlusion, bounce", {4.5, 3.5, 1.5}, false, false},
    [TARGET_INCOHERENT] = {"random, grazing", {5, 4, 2}, false, false},
    [TARGET_MEMORY] = {"bytes a cell beyond 1 MB, samples and bounds", {7, 7, 7}, true, true},
    [TARGET_BUILD_TRIANGLES] = {"building, 1025² and 4097², against Embree's triangles", {50, 50, 50}, false, true},
    [TARGET_BUILD_GRID] = {"building, 1025² and 4097², against Embree's grid", {5, 5, 5}, false, true},
    [TARGET_SCALING] = {"time for a ray, 8193² over 257²", {3, 3, 3}, true, false},
    [TARGET_THREADS] = {"two threads over one", {1.9, 1.9, 1.9}, false, true},
};

const char *target_title(target_kind kind) { return rows[kind].title; }
const char *targets_isa(size_t isa) { return isas[isa]; }
bool target_is_general(target_kind kind) { return rows[kind].general; }

static bool read_one(json_t **lines, const char *folder, const char *name, io_error *error) {
    char path[4096];
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= (int)sizeof path)
        return io_fail(error, "%s: the name is too long", folder);
    if (access(path, F_OK) != 0) return true;
    *lines = results_read(path, error);
    return *lines != NULL;
}

bool targets_open(targets_data *d, const char *folder, io_error *error) {
    *d = (targets_data){.building = NULL};
    bool any = false;
    for (size_t k = 0; k < TARGETS_ISAS; k++) {
        if (!read_one(&d->speed[k], folder, speed_files[k], error)) return false;
        any = any || d->speed[k];
    }
    if (!any) return io_fail(error, "%s: has no file speed-….json as 'cellwalk-bench measure' makes them", folder);
    return read_one(&d->building, folder, "building.json", error) &&
           read_one(&d->threads, folder, "threads.json", error);
}

void targets_close(targets_data *d) {
    for (size_t k = 0; k < TARGETS_ISAS; k++) json_decref(d->speed[k]);
    json_decref(d->building);
    json_decref(d->threads);
}

/* ---- figures ---- */

static bool starts_with(const char *text, const char *start) { return strncmp(text, start, strlen(start)) == 0; }

const json_t *targets_own(const json_t *lines, const char *field, const char *rays) {
    const json_t *about = results_find(lines, "field", "field", field, NULL), *line;
    const char *kernel = about ? results_text(about, "default_kernel") : "";
    const size_t length = strlen(kernel);
    size_t index;
    json_array_foreach(lines, index, line) {
        const char *name = results_text(line, "contender");
        if (results_is(line, "result", "field", field, "rays", rays, NULL) && results_number(line, "threads") == 1 &&
            results_number(line, "mrays_per_s") > 0 && length > 0 && starts_with(name, kernel) && name[length] == '/')
            return line;
    }
    return NULL;
}

const json_t *targets_embree(const json_t *lines, const char *field, const char *rays) {
    const json_t *best = NULL, *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (results_is(line, "result", "field", field, "rays", rays, NULL) &&
            starts_with(results_text(line, "contender"), "embree/triangles/") &&
            results_number(line, "mrays_per_s") > (best ? results_number(best, "mrays_per_s") : 0))
            best = line;
    }
    return best;
}

/* 0 if either side is missing. */
static double speed_ratio(const json_t *lines, const char *field, const char *rays) {
    const json_t *own = targets_own(lines, field, rays), *embree = targets_embree(lines, field, rays);
    return own && embree ? results_number(own, "mrays_per_s") / results_number(embree, "mrays_per_s") : 0;
}

/* Takes a value if it is the worst so far. */
static void take(target *t, double value, const char *field, const char *rays) {
    if (!(value > 0) || (t->measured > 0 && (t->at_most ? value <= t->measured : value >= t->measured))) return;
    t->measured = value;
    snprintf(t->where, sizeof t->where, "%s%s%s", rays, *rays && *field ? ", " : "", field);
}

/* Over the middle sizes; 0 unless all are there. */
static double mean_of(const json_t *lines, const char *const *of, size_t count) {
    double values[CLASSES * MIDDLE];
    size_t n = 0;
    for (size_t c = 0; c < count; c++)
        for (size_t f = 0; f < MIDDLE; f++) {
            values[n] = speed_ratio(lines, middle[f], of[c]);
            if (!(values[n++] > 0)) return 0;
        }
    return statistics_geometric_mean(values, n);
}

static void take_sizes(target *t, const json_t *lines, const char *rays) {
    for (size_t f = 0; f < LAND; f++) take(t, speed_ratio(lines, land[f], rays), land[f], "");
}

static void take_scaling(target *t, const json_t *lines) {
    for (size_t c = 0; c < CLASSES; c++) {
        const json_t *small = targets_own(lines, "257", classes[c]), *large = targets_own(lines, "8193", classes[c]);
        if (small && large)
            take(t, results_number(small, "mrays_per_s") / results_number(large, "mrays_per_s"), "", classes[c]);
    }
}

static const json_t *own_build(const json_t *lines, const char *field) {
    const json_t *about = results_find(lines, "field", "field", field, NULL);
    return about ? results_find(lines, "kernel_build", "field", field, "kernel", results_text(about, "default_kernel"),
                                NULL)
                 : NULL;
}

static void take_memory(target *t, const json_t *lines) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "field", NULL)) continue;
        const json_t *build = own_build(lines, results_text(line, "field"));
        const double cells = (results_number(line, "nx") - 1) * (results_number(line, "ny") - 1);
        const double bytes = results_number(line, "bytes_samples") + (build ? results_number(build, "bytes") : 0);
        /* Small fields are all within the megabyte; what the others need a cell then is what counts. */
        if (build && bytes > 1e6) take(t, (bytes - 1e6) / cells, results_text(line, "field"), "");
    }
}

static void take_building(target *t, const json_t *lines, const char *peer) {
    for (size_t f = 1; f < MIDDLE; f++) {
        const json_t *own = own_build(lines, middle[f]);
        const json_t *other = results_find(lines, "peer_build", "field", middle[f], "peer", peer, NULL);
        if (own && other)
            take(t, results_number(other, "build_seconds") / results_number(own, "build_seconds"), middle[f], "");
    }
}

static void take_threads(target *t, const json_t *lines) {
    const json_t *line;
    size_t index;
    json_array_foreach(lines, index, line) {
        if (!results_is(line, "result", NULL) || results_number(line, "threads") != 2) continue;
        const char *field = results_text(line, "field"), *rays = results_text(line, "rays");
        const json_t *one = targets_own(lines, field, rays);
        if (one && results_number(line, "mrays_per_s") > 0)
            take(t, results_number(line, "mrays_per_s") / results_number(one, "mrays_per_s"), field, rays);
    }
}

target target_of(const targets_data *d, size_t isa, target_kind kind) {
    target t = {.wanted = rows[kind].wanted[isa], .at_most = rows[kind].at_most};
    const json_t *speed = d->speed[isa];
    const json_t *needed = kind == TARGET_THREADS ? d->threads : rows[kind].general ? d->building : speed;
    if (needed == NULL) return t;
    static const char *const pairs[2][2] = {{"ao", "bounce"}, {"random", "grazing"}};
    switch (kind) {
    case TARGET_MEAN:
        t.measured = mean_of(speed, classes, CLASSES);
        break;
    case TARGET_PRIMARY:
        take_sizes(&t, speed, "primary");
        break;
    case TARGET_SHADOW:
        take_sizes(&t, speed, "shadow");
        break;
    case TARGET_SCATTERED:
    case TARGET_INCOHERENT:
        for (size_t c = 0; c < 2; c++) {
            const char *const *rays = &pairs[kind == TARGET_INCOHERENT][c];
            take(&t, mean_of(speed, rays, 1), "", *rays);
        }
        break;
    case TARGET_MEMORY:
        take_memory(&t, d->building);
        break;
    case TARGET_BUILD_TRIANGLES:
        take_building(&t, d->building, "embree/triangles");
        break;
    case TARGET_BUILD_GRID:
        take_building(&t, d->building, "embree/grid");
        break;
    case TARGET_SCALING:
        take_scaling(&t, speed);
        break;
    case TARGET_THREADS:
        take_threads(&t, d->threads);
        break;
    case TARGET_COUNT:
        break;
    }
    return t;
}

bool target_is_met(const target *t) {
    return t->measured > 0 && (t->at_most ? t->measured <= t->wanted : t->measured >= t->wanted);
}
