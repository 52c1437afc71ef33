/* SPDX-License-Identifier: Apache-2.0 */
#include "parts.h"

#include "clock.h"
#include "counters.h"
#include "measure.h"
#include "options.h"
#include "output.h"
#include "results.h"
#include "run_record.h"
#include "terrain.h"
#include "timing.h"
#include "workload_fields.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-bench parts [OPTIONS]\n"
    "\n"
    "Times the pieces that the kernels are made of, each by itself in the kernels' own code, for each width and\n"
    "instruction set that this CPU has: making rays ready, leaf tests, steps from node to node, refilling lanes, "
    "reading by gather "
    "and\n"
    "by loads that lanes share, from memory of several sizes; and building the pyramid, beside copying the samples.\n"
    "One thread, medians of CPU time.\n"
    "\n"
    "Options:\n";

typedef struct parts_set {
    const char *kernel; /* whose pieces */
    cw_isa isa;
    unsigned width;
    parts_run *run, *count;
} parts_set;

static const parts_set sets[] = {
    {"pyramid1", CW_ISA_SCALAR, 1, parts_run_scalar, parts_count_scalar},
#if CELLWALK_SIMD
    {"pyramid4", CW_ISA_SSE42, 4, parts_run_sse42, parts_count_sse42},
    {"pyramid4x2", CW_ISA_SSE42, 8, parts_run_sse42_twice, parts_count_sse42_twice},
    {"pyramid8", CW_ISA_AVX2, 8, parts_run_avx2, parts_count_avx2},
    {"pyramid8x2", CW_ISA_AVX2, 16, parts_run_avx2_twice, parts_count_avx2_twice},
    {"pyramid16", CW_ISA_AVX512, 16, parts_run_avx512, parts_count_avx512},
#endif
};
enum { SET_COUNT = sizeof sets / sizeof sets[0] };

static const struct {
    const char *name, *unit;
    bool reads; /* from tables of several sizes */
} parts[PART_COUNT] = {
    [PART_PREPARE] = {"prepare", "rays", false},
    [PART_LEAF_WATERTIGHT] = {"leaf watertight", "tests", false},
    [PART_LEAF_MOLLER_TRUMBORE] = {"leaf moller-trumbore", "tests", false},
    [PART_NODE] = {"node step", "steps", false},
    [PART_REFILL] = {"refill", "rays", false},
    [PART_GATHER] = {"gather", "numbers", true},
    [PART_PAIRS] = {"gather pairs", "numbers", true},
    [PART_LOAD] = {"load", "numbers", true},
    [PART_BROADCAST] = {"broadcast", "numbers", true},
};

/* First-level cache, second-level cache, beyond all caches; how many places are read in each. */
static const struct {
    const char *name;
    size_t bytes, places;
} tables[] = {{"16 KiB", 16 << 10, 1 << 12}, {"256 KiB", 256 << 10, 1 << 14}, {"256 MiB", 256 << 20, 1 << 18}};
enum { TABLE_COUNT = sizeof tables / sizeof tables[0] };

/* All that is worked on. */
typedef struct ground {
    workload_field samples;
    cw_field *field;
    cw_ray rays[PARTS_RAYS], aimed[PARTS_AIMED];
    int32_t cell_i[PARTS_AIMED], cell_j[PARTS_AIMED];
    float *table;
    int32_t *places[TABLE_COUNT];
} ground;

static float unit(uint32_t seed, uint32_t a, uint32_t b) { return (float)(terrain_hash(seed, a, b) >> 8) * 0x1p-24f; }

/* From a point above the field to a point on or in it. */
static cw_ray ray_to(const ground *g, uint32_t seed, uint32_t number, float x, float y, float z) {
    const cw_field_info info = cw_field_describe(g->field);
    const float from[3] = {unit(seed, number, 2) * (float)(info.nx - 1), unit(seed, number, 3) * (float)(info.ny - 1),
                           info.high + 0.1f * (float)info.nx};
    return (cw_ray){.org = {from[0], from[1], from[2]},
                    .dir = {x - from[0], y - from[1], z - from[2]},
                    .tmin = 0,
                    .tmax = INFINITY};
}

static void make_rays_of(ground *g, uint32_t seed) {
    const cw_field_info info = cw_field_describe(g->field);
    for (uint32_t k = 0; k < PARTS_RAYS; k++) {
        const float x = unit(seed, k, 0) * (float)(info.nx - 1), y = unit(seed, k, 1) * (float)(info.ny - 1);
        g->rays[k] = ray_to(g, seed, k, x, y, info.low + unit(seed, k, 4) * (info.high - info.low));
    }
    for (uint32_t k = 0; k < PARTS_AIMED; k++) {
        const size_t i = terrain_hash(seed, k, 5) % (info.nx - 1), j = terrain_hash(seed, k, 6) % (info.ny - 1);
        const float h00 = cw_field_sample(g->field, i, j), h10 = cw_field_sample(g->field, i + 1, j);
        const float h11 = cw_field_sample(g->field, i + 1, j + 1), x_in = 0.625f, y_in = 0.25f; /* in triangle A */
        g->cell_i[k] = (int32_t)i;
        g->cell_j[k] = (int32_t)j;
        g->aimed[k] =
            ray_to(g, seed + 1, k, (float)i + x_in, (float)j + y_in, h00 + x_in * (h10 - h00) + y_in * (h11 - h10));
    }
}

static bool open_ground(ground *g, uint32_t seed, io_error *error) {
    if (!workload_field_make("257", &g->samples)) return io_fail(error, "out of memory");
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = g->samples.z;
    desc.nx = g->samples.nx;
    desc.ny = g->samples.ny;
    desc.storage = CW_BORROW;
    const cw_status status = cw_field_create(&desc, &g->field);
    if (status != CW_OK) return io_fail(error, "field 257: %s", cw_status_message(status));
    make_rays_of(g, seed);
    g->table = malloc(tables[TABLE_COUNT - 1].bytes);
    bool good = g->table != NULL;
    for (size_t t = 0; good && t < TABLE_COUNT; t++) {
        g->places[t] = malloc(tables[t].places * sizeof *g->places[t]);
        good = g->places[t] != NULL;
        const size_t numbers = tables[t].bytes / sizeof *g->table - 16;
        for (size_t k = 0; good && k < tables[t].places; k++)
            g->places[t][k] = (int32_t)(terrain_hash(seed, (uint32_t)k, (uint32_t)t) % numbers & ~1u);
    }
    for (size_t k = 0; good && k < tables[TABLE_COUNT - 1].bytes / sizeof *g->table; k++)
        g->table[k] = (float)(k % 1000);
    return good || io_fail(error, "out of memory");
}

static void close_ground(ground *g) {
    for (size_t t = 0; t < TABLE_COUNT; t++) free(g->places[t]);
    free(g->table);
    cw_field_destroy(g->field);
    workload_field_free(&g->samples);
}

/* One thing to time. */
typedef struct trial {
    const parts_set *set;
    part_kind kind;
    size_t table;
    parts_work work;
    unsigned repeats;    /* passes a run, so that it is long for the clock */
    uint64_t operations; /* in a run */
    uint64_t turns;      /* of the lane walk in a run, steps and rounds of tests */
    uint64_t refills;    /* and rays put into lanes for them */
    double test_share;   /* of a node step: turns that test cells, among all */
} trial;

static void run_trial(void *context) {
    trial *t = context;
    for (unsigned k = 0; k < t->repeats; k++) t->set->run(t->kind, &t->work);
}

static unsigned repeats_of(trial *t) {
    static const double enough = 5e-4;
    const double start = clock_cpu_seconds();
    unsigned passes = 0;
    do {
        t->set->run(t->kind, &t->work);
        passes++;
    } while (clock_cpu_seconds() - start < enough);
    return passes;
}

/* Also warms up; and of node steps only the counting twin knows how many there are. */
static bool count_operations(trial *t, io_error *error) {
    t->operations = t->set->run(t->kind, &t->work);
    t->repeats = repeats_of(t);
    t->operations *= t->repeats;
    const bool leaf = t->kind == PART_LEAF_WATERTIGHT || t->kind == PART_LEAF_MOLLER_TRUMBORE;
    if (leaf && t->work.hits != PARTS_AIMED)
        return io_fail(error, "%s: only %zu of %d rays hit the cell that they are aimed at", parts[t->kind].name,
                       t->work.hits, PARTS_AIMED);
    if (t->kind != PART_NODE) return true;
    counter all[COUNTERS_MAX];
    t->set->count(t->kind, &t->work); /* once to make its ground ready */
    counters_reset();
    t->set->count(t->kind, &t->work);
    counters_read(all);
    t->operations = counters_find(all, "node")->lanes * t->repeats;
    t->turns = counters_find(all, "stream")->events * t->repeats;
    t->refills = counters_find(all, "refill")->events * t->repeats;
    t->test_share = (double)counters_find(all, "round")->events / (double)counters_find(all, "stream")->events;
    return t->operations > 0 || io_fail(error, "%s: none was counted", parts[t->kind].name);
}

static bool write_trial(io_output *out, const trial *t, const measure_job *job, io_error *error) {
    const statistics *s = &job->seconds;
    const double rate = (double)t->operations / s->median;
    printf("  %-10s %2u  %-22s %-8s %9.1f M%-8s/s  %6.2f ns  CI +-%.1f %%  MAD %.1f %%\n", t->set->kernel,
           t->set->width, parts[t->kind].name, parts[t->kind].reads ? tables[t->table].name : "", rate * 1e-6,
           parts[t->kind].unit, 1e9 / rate, 50 * (s->high - s->low) / s->median, 100 * s->mad / s->median);
    json_t *line = json_object();
    results_set_text(line, "kind", "part");
    results_set_text(line, "part", parts[t->kind].name);
    results_set_text(line, "unit", parts[t->kind].unit);
    results_set_text(line, "kernel", t->set->kernel);
    results_set_text(line, "isa", cw_isa_name(t->set->isa));
    results_set_count(line, "width", t->set->width);
    if (parts[t->kind].reads) {
        results_set_text(line, "memory", tables[t->table].name);
        results_set_count(line, "bytes", tables[t->table].bytes);
    }
    results_set_count(line, "operations", (size_t)t->operations);
    if (t->work.hits > 0) results_set_count(line, "hits", t->work.hits);
    if (t->kind == PART_NODE) {
        results_set_count(line, "turns", (size_t)t->turns);
        results_set_count(line, "refills", (size_t)t->refills);
        results_set_number(line, "test_share", t->test_share);
    }
    results_set_seconds(line, s);
    results_set_number(line, "per_second", rate);
    return results_write(out, line, error);
}

/* Jobs of one size of table compete with each other, so that no one's table drives another's out of the cache. */
static bool run_trials(trial *trials, size_t count, double seconds, uint32_t seed, io_output *out, io_error *error) {
    measure_job jobs[SET_COUNT * PART_COUNT];
    for (size_t k = 0; k < count; k++) {
        if (!count_operations(&trials[k], error)) return false;
        jobs[k] = (measure_job){.run = run_trial, .context = &trials[k]};
    }
    const measure_limits limits = {
        .width = 0.01, .seconds = seconds, .least = 7, .most = MEASURE_SAMPLES_MAX, .seed = seed};
    bool good = measure(jobs, count, &limits) || io_fail(error, "out of memory");
    for (size_t k = 0; good && k < count; k++) good = write_trial(out, &trials[k], &jobs[k], error);
    fflush(stdout);
    return good;
}

static const void *volatile kept;
static void keep(const void *of) { kept = of; }

static parts_work work_of(const ground *g, size_t table) {
    return (parts_work){.field = g->field,
                        .rays = g->rays,
                        .aimed = g->aimed,
                        .cell_i = g->cell_i,
                        .cell_j = g->cell_j,
                        .table = g->table,
                        .places = g->places[table],
                        .place_count = tables[table].places,
                        .keep = keep};
}

static bool run_parts(const ground *g, double seconds, uint32_t seed, io_output *out, io_error *error) {
    trial trials[SET_COUNT * PART_COUNT];
    for (size_t table = 0; table <= TABLE_COUNT; table++) { /* the last one stands for those that read no table */
        size_t count = 0;
        for (int kind = 0; kind < PART_COUNT; kind++)
            for (size_t s = 0; s < SET_COUNT; s++) {
                if (sets[s].isa > cw_isa_best() || parts[kind].reads != (table < TABLE_COUNT)) continue;
                trials[count++] = (trial){.set = &sets[s],
                                          .kind = (part_kind)kind,
                                          .table = table,
                                          .work = work_of(g, table < TABLE_COUNT ? table : 0)};
            }
        if (!run_trials(trials, count, seconds / (TABLE_COUNT + 1), seed, out, error)) return false;
    }
    return true;
}

/* ---- building ---- */

enum { BUILDS = 9 };

/* CPU seconds to build the pyramid, in turns with copying the samples to memory that has been written before. */
static bool time_building(const workload_field *samples, double build[BUILDS], double copy[BUILDS], size_t *bytes,
                          io_error *error) {
    const size_t size = samples->nx * samples->ny * sizeof *samples->z;
    const cw_kernel *kernel = cw_kernel_find("pyramid1");
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = samples->z;
    desc.nx = samples->nx;
    desc.ny = samples->ny;
    desc.storage = CW_BORROW;
    desc.bare = true;
    float *to = malloc(size);
    if (to == NULL) return io_fail(error, "out of memory");
    memset(to, 1, size);
    cw_status status = CW_OK;
    for (size_t k = 0; k < BUILDS && status == CW_OK; k++) {
        cw_field *field = NULL;
        status = cw_field_create(&desc, &field);
        double start = clock_cpu_seconds();
        if (status == CW_OK) status = cw_field_build(field, kernel);
        build[k] = clock_cpu_seconds() - start;
        if (status == CW_OK) *bytes = cw_field_describe(field).bytes_built;
        cw_field_destroy(field);
        start = clock_cpu_seconds();
        memcpy(to, samples->z, size);
        copy[k] = clock_cpu_seconds() - start;
        volatile float used = to[k];
        (void)used;
    }
    free(to);
    return status == CW_OK || io_fail(error, "field %s: %s", samples->name, cw_status_message(status));
}

static bool write_building(io_output *out, const workload_field *samples, const char *part, double seconds[BUILDS],
                           size_t built, io_error *error) {
    const double bytes = (double)(samples->nx * samples->ny * sizeof *samples->z);
    const statistics s = statistics_of(seconds, BUILDS);
    printf("  %-34s %-8s %9.2f GB/s of samples  %.3g s  MAD %.1f %%\n", part, samples->name, bytes / s.median * 1e-9,
           s.median, 100 * s.mad / s.median);
    json_t *line = json_object();
    results_set_text(line, "kind", "part");
    results_set_text(line, "part", part);
    results_set_text(line, "unit", "bytes of samples");
    results_set_text(line, "field", samples->name);
    results_set_number(line, "operations", bytes);
    if (built) results_set_count(line, "bytes_built", built);
    results_set_seconds(line, &s);
    results_set_number(line, "per_second", bytes / s.median);
    return results_write(out, line, error);
}

static bool run_building(const char *field, io_output *out, io_error *error) {
    workload_field samples;
    double build[BUILDS], copy[BUILDS];
    size_t built = 0;
    if (!workload_field_make(field, &samples)) return io_fail(error, "out of memory for field %s", field);
    const bool good = time_building(&samples, build, copy, &built, error) &&
                      write_building(out, &samples, "pyramid build", build, built, error) &&
                      write_building(out, &samples, "memcpy", copy, 0, error);
    workload_field_free(&samples);
    return good;
}

static bool run(double seconds, uint32_t seed, bool quick, io_output *out, io_error *error) {
    static const char *const fields[] = {"257", "1025", "4097"};
    json_t *record = run_record("parts", seed, timing_pin(-1));
    char text[512];
    run_record_text(record, text, sizeof text);
    printf("%s\n\n", text);
    if (!results_write(out, record, error)) return false;
    ground *g = calloc(1, sizeof *g);
    bool good =
        g ? open_ground(g, seed, error) && run_parts(g, seconds, seed, out, error) : io_fail(error, "out of memory");
    if (g) close_ground(g);
    free(g);
    for (size_t k = 0; good && k < (quick ? 1 : sizeof fields / sizeof fields[0]); k++)
        good = run_building(fields[k], out, error);
    return good;
}

int parts_main(char **arguments, int count) {
    const char *json = NULL;
    double seconds = 20;
    uint64_t seed = 1;
    bool quick = false;
    const option options[] = {
        {"--seconds", "S", "time for all but building, as far as it can be kept (20)", OPTION_REAL, &seconds, 0.01,
         1e6},
        {"--seed", "N", "of rays, places and order (1)", OPTION_COUNT, &seed, 0, UINT32_MAX},
        {"--quick", NULL, "build for a small field only", OPTION_FLAG, &quick, 0, 0},
        {"--json", "FILE", "write JSON lines there", OPTION_TEXT, &json, 0, 0},
    };
    const option_frame frame = {
        .command = "parts", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    io_output out = {0};
    const bool good = (json == NULL || io_output_open(&out, json, &error)) &&
                      run(seconds, (uint32_t)seed, quick, &out, &error) &&
                      (json == NULL || io_output_commit(&out, &error));
    io_output_discard(&out);
    return good ? EXIT_SUCCESS : options_failed("parts", &error);
}
