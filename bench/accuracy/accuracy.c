/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of cellwalk-bench accuracy, and its file. */

#include "accuracy/accuracy.h"

#include "clock.h"
#include "commands.h"
#include "harness/memory.h"
#include "harness/results.h"

#include <stdio.h>
#include <stdlib.h>

static const char what[] =
    "Measures errors and speed of every mode of accuracy, with every kernel that has it, and of Embree on the same "
    "rays; writes accuracy.json to a folder. The error of each answer is found first; then all contenders are timed "
    "in rounds on one thread.\n\n"
    "The truth is the strict watertight answer, which the tests compare with an exact oracle, with t computed again "
    "from ray and triangle to 2^-26 of a float's last place. Errors within the bounds of rounding "
    "(papers/numerics.md) do not count:\n"
    "  leak     the ray passes clearly through the surface, and there is no hit\n"
    "  phantom  a hit where the ray is clear of the surface\n"
    "  wrong    a hit, but behind a surface that the ray has clearly passed\n"
    "  beyond   the sum of these that exceed the mode's own claim, such as half a step of 16-bit samples\n"
    "  t        error of all other hits: in ULP of the exact t, and as a distance along the ray in cells\n"
    "  off      how far such a hit is above or below the surface, in cells; unlike t it does not grow where rays run "
    "along it\n"
    "  normal   angle between the Phong normals at the hit and at the exact place, in degrees\n\n"
    "The file also has errors of t relative to it, of u and v, and of the hit's point in cells.\n\n"
    "Beside the benchmark's classes of rays, vertices and edges are aimed at these, to find leaks, and within-0.1 and "
    "within-2 start so many cells from the surface; they are not timed. "
    "papers/scripts/tables.py --data makes tables of accuracy.json.";

static const char examples[] = "  cellwalk-bench accuracy            # a first look, in a minute\n"
                               "  cellwalk-bench accuracy --mode strict,moller-trumbore --kernel packet8 \\\n"
                               "      --field 1025                   # the cost of the watertight leaf test\n"
                               "  cellwalk-bench accuracy --long --out out/long\n";

static const char *mode_names(size_t number) {
    return accuracy_mode_at(number) ? accuracy_mode_at(number)->name : NULL;
}
static const char *class_names(size_t number) { return workload_class_name((workload_class)number); }

static void set_defaults(accuracy_options *o) {
    if (o->count == 0) o->count = o->longer ? 1 << 20 : 1 << 14;
    if (o->seconds <= 0) o->seconds = o->longer ? 1200 : 15;
    if (o->pass <= 0) o->pass = o->longer ? 0.5 : 0.05;
    if (o->fields.count == 0) { /* 257, 1025; with --long all but the largest */
        option_list_fill(&o->fields, workload_field_name, o->longer ? 0 : 1, o->longer ? 4 : 3);
        if (o->longer) option_list_fill(&o->fields, workload_field_name, 5, 7);
    }
    if (o->rays.count == 0) option_list_fill(&o->rays, class_names, 0, OPTION_LIST_MAX);
}

static bool run_fields(const accuracy_options *o, json_t *lines, io_error *error) {
    double end = clock_seconds() + o->seconds;
    size_t groups = 0; /* that are timed */
    for (size_t c = 0; c < WORKLOAD_CLASS_COUNT; c++) groups += option_wanted(&o->rays, c) ? o->fields.count : 0;
    accuracy_field *on = memory(1, sizeof *on);
    bool good = true;
    for (size_t f = 0; good && f < o->fields.count; f++) {
        const double start = clock_seconds();
        fprintf(stderr, "field %s: making it and building Embree\n", o->fields.item[f]);
        good = accuracy_field_open(on, o->fields.item[f], o, error);
        end += clock_seconds() - start; /* building does not count */
        for (size_t c = 0; good && c < WORKLOAD_ALL; c++) {
            if (!option_wanted(&o->rays, c)) continue;
            fprintf(stderr, "field %s: %s\n", o->fields.item[f], workload_class_name((workload_class)c));
            const bool timed = c < WORKLOAD_CLASS_COUNT;
            const double left = end - clock_seconds();
            good = accuracy_group_run(on, (workload_class)c, o, timed && left > 0 ? left / (double)groups : 0, lines,
                                      error);
            groups -= timed;
        }
        accuracy_field_close(on);
    }
    free(on);
    return good;
}

static json_t *modes_line(void) {
    json_t *line = json_object(), *modes = json_object();
    results_set_text(line, "kind", "modes");
    for (size_t m = 0; accuracy_mode_at(m); m++)
        results_set_text(modes, accuracy_mode_at(m)->name, accuracy_mode_at(m)->what);
    json_object_set_new(line, "modes", modes);
    return line;
}

static bool measure_all(const accuracy_options *o, json_t *lines, io_error *error) {
    results_append(lines, modes_line());
    const bool good = run_fields(o, lines, error);
    if (good) accuracy_normals_run(o->run.seed, lines);
    return good;
}

static bool run(const accuracy_options *o, io_error *error) {
    io_output json = {0};
    int cpu;
    if (!run_options_pin(&o->run, &cpu, error)) return false;
    json_t *lines = json_array(), *record = run_record("accuracy", o->run.seed, cpu);
    results_set_count(record, "rays_a_class", o->count);
    results_append(lines, record);
    const bool good = io_output_open_in(&json, o->out, "accuracy.json", error) && measure_all(o, lines, error) &&
                      results_write_all(&json, lines, error) && io_output_commit(&json, error);
    if (good) accuracy_print(lines);
    io_output_discard(&json);
    json_decref(lines);
    fflush(stdout);
    if (good) fprintf(stderr, "saved %s/accuracy.json\n", o->out);
    return good;
}

static int start(int argc, char **argv) {
    accuracy_options o = {.run = RUN_DEFAULTS, .out = "out/accuracy"};
    const option_spec options[] = {
        {"mode", "NAMES", "only these modes; by default all but Embree's grids, with --long all", OPTION_LIST,
         .to = &o.modes, .names = mode_names},
        {"kernel", "NAMES", "only these kernels, beside Embree", OPTION_LIST, .to = &o.kernels,
         .names = option_kernel_names},
        {"rays", "NAMES", "only these classes of rays", OPTION_LIST, .to = &o.rays, .names = class_names},
        {"field", "NAMES", "these fields instead of 257 and 1025, or all but 8193 with --long", OPTION_LIST,
         .to = &o.fields, .names = workload_field_name},
        {"count", "N", "rays in a class (16384; 1048576 with --long)", OPTION_COUNT, .to = &o.count, .low = 64,
         .high = 1 << 24},
        {"seconds", "S", "seconds for errors and speeds on the fields, kept as far as possible (15; 1200 with --long)",
         OPTION_REAL, .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"pass", "S",
         "contenders that take more than S seconds for a pass get fewer rays, down to a 64th (0.05; 0.5 with --long)",
         OPTION_REAL, .to = &o.pass, .low = 1e-6, .high = 1e6},
        {"long", NULL, "all fields but the largest, more rays, more time", OPTION_FLAG, .to = &o.longer},
        {"out", "FOLDER", "folder for accuracy.json, made if missing (out/accuracy)", OPTION_TEXT, .to = &o.out},
        RUN_OPTIONS(o.run),
    };
    const options_usage usage = {"accuracy", "[OPTIONS]", what, examples, options, sizeof options / sizeof *options,
                                 NULL,       0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    io_error error = {{0}};
    set_defaults(&o);
    if (!run_options_check(&o.run, "accuracy")) return EXIT_USAGE;
    return run(&o, &error) ? EXIT_SUCCESS : command_fail("accuracy", "%s", error.text);
}

const command command_accuracy = {"accuracy", "measure errors and speed of strict hits, other modes and Embree", start};
