/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of cellwalk-bench tradeoff, and its file. */

#include "accuracy/tradeoff.h"

#include "accuracy/summary.h"
#include "accuracy/walks.h"
#include "build_info.h"
#include "commands.h"
#include "harness/child.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "micro/counters.h"
#include "scenes/tracer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char what[] =
    "What does accuracy cost, and what does giving some up buy? Runs every mode of accuracy with every kernel that has "
    "it, and "
    "Embree, on the same rays; finds the error of each answer, then times all of them in rounds on one thread.\n\n"
    "The truth is the strict watertight answer, which the tests hold against an exact oracle, with t computed anew "
    "from ray and "
    "triangle to 2^-26 of a float's last place. What rounding excuses (papers/numerics.md) does not count:\n"
    "  leak     the ray passes clearly through the surface, and there is no hit\n"
    "  phantom  a hit where the ray is clear of the surface\n"
    "  wrong    a hit, but behind a surface that the ray has clearly passed\n"
    "  beyond   the sum of these that the mode's own claim, half a step of 16-bit samples say, does not explain\n"
    "  t        error of all other hits: in ULP of the exact t, and as a distance along the ray in cells\n"
    "  off      how far such a hit is above or below the surface, in cells; unlike t it does not grow where rays run "
    "along it\n"
    "  normal   angle between the Phong normals at the hit and at the exact place, degrees\n\n"
    "Who is beaten by nobody in both speed and error is on the Pareto frontier: once for wrong answers in a million "
    "rays, once "
    "for the worst height off the surface. Beside the benchmark's classes of rays, vertices and edges are aimed at "
    "these, to "
    "find leaks; they are not timed. The six scenes are rendered with each mode and held against strict. Saves "
    "tradeoff.json in "
    "a folder.";

static const char examples[] = "  cellwalk-bench tradeoff            a first look, in a minute\n"
                               "  cellwalk-bench tradeoff --mode strict,moller-trumbore --kernel pyramid8 \\\n"
                               "      --field 1025 --scene none      what does the watertight leaf test cost?\n"
                               "  cellwalk-bench tradeoff --long --out papers/data/tradeoff\n";

static const char *scene_or_none(size_t number) { return number == SCENES ? "none" : scene_names(number); }
static const char *mode_names(size_t number) {
    return number < tradeoff_mode_count() ? tradeoff_mode_at(number)->name : NULL;
}
static const char *class_names(size_t number) { return tradeoff_class_name((int)number); }

static void set_defaults(tradeoff_options *o) {
    if (o->count == 0) o->count = o->longer ? 1 << 20 : 1 << 14;
    if (o->seconds <= 0) o->seconds = o->longer ? 1200 : 15;
    if (o->pass <= 0) o->pass = o->longer ? 0.5 : 0.05;
    if (o->samples == 0 && !o->longer) o->samples = 1;
    if (o->fields.count == 0) { /* 257, 1025; with --long all but the largest */
        option_list_fill(&o->fields, workload_field_name, o->longer ? 0 : 1, o->longer ? 4 : 3);
        if (o->longer) option_list_fill(&o->fields, workload_field_name, 5, 7);
    }
    if (o->rays.count == 0) option_list_fill(&o->rays, class_names, 0, OPTION_LIST_MAX);
    if (o->scenes.count == 0) option_list_fill(&o->scenes, scene_names, 0, SCENES);
    if (option_wanted(&o->scenes, SCENES)) o->scenes.count = 0;
}

/* argv: the arguments, for the program that counts. */
static bool run(const tradeoff_options *o, int argc, char **argv, io_error *error) {
    io_output json = {0};
    int cpu;
    if (!run_options_pin(&o->run, &cpu, error)) return false;
    json_t *lines = json_array(), *record = run_record("tradeoff", o->run.seed, cpu);
    results_set_count(record, "rays_a_class", o->count);
    results_set_count(record, "samples_a_pixel", o->samples);
    bool good = json_array_append_new(lines, record) == 0 || io_fail(error, "out of memory");
    good = good && io_output_open_in(&json, o->out, o->counters ? "counts.json" : "tradeoff.json", error);
    /* First what may fail soon. */
    if (good && counters_here())
        good = walks_count(o, lines, error);
    else if (good)
        good = walks_count_elsewhere(argc, argv, o->out, lines, error);
    if (good && o->counters) {
        walks_print(lines);
    } else if (good) {
        good = tradeoff_run(o, lines, error);
        if (good) summary_print(lines);
    }
    good = good && results_write_all(&json, lines, error) && io_output_commit(&json, error);
    io_output_discard(&json);
    json_decref(lines);
    fflush(stdout);
    if (good) fprintf(stderr, "saved in %s\n", o->out);
    return good;
}

static int start(int argc, char **argv) {
    tradeoff_options o = {.out = "out/tradeoff", .scene_folder = BUILD_INFO_SCENES};
    enum { OWN = 13 };
    option_spec options[OWN + RUN_OPTION_COUNT] = {
        {"mode", "NAMES", "only these; all but Embree's grids by default, and these too with --long", OPTION_LIST,
         .to = &o.modes, .names = mode_names},
        {"kernel", "NAMES", "only these kernels, beside Embree", OPTION_LIST, .to = &o.kernels,
         .names = option_kernel_names},
        {"rays", "NAMES", "only these classes of rays", OPTION_LIST, .to = &o.rays, .names = class_names},
        {"field", "NAMES", "these fields instead of 257 and 1025, or all but 8193 with --long", OPTION_LIST,
         .to = &o.fields, .names = workload_field_name},
        {"scene", "NAMES", "only these", OPTION_LIST, .to = &o.scenes, .names = scene_or_none},
        {"scenes", "FOLDER", "where the scenes' .pbrt files are; by default those made with this program", OPTION_TEXT,
         .to = &o.scene_folder},
        {"count", "N", "rays in a class (16384; 1048576 with --long)", OPTION_COUNT, .to = &o.count, .low = 64,
         .high = 1 << 24},
        {"samples", "N", "samples a pixel of the scenes (1; what the scene says with --long)", OPTION_COUNT,
         .to = &o.samples, .high = 1024},
        {"seconds", "S", "time for errors and speeds on the fields, as far as it can be kept (15; 1200 with --long)",
         OPTION_REAL, .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"pass", "S", "who takes longer for one pass runs on fewer rays, down to a 64th (0.05; 0.5 with --long)",
         OPTION_REAL, .to = &o.pass, .low = 1e-6, .high = 1e6},
        {"counters", NULL, "only count what rays cost in the kernels grid3d and cell, and save that in counts.json",
         OPTION_FLAG, .to = &o.counters},
        {"long", NULL, "all fields but the largest, more rays, more time", OPTION_FLAG, .to = &o.longer},
        {"out", "FOLDER", "where to save tradeoff.json; made if need be (out/tradeoff)", OPTION_TEXT, .to = &o.out},
    };
    run_options_rows(&o.run, options + OWN);
    const options_usage usage = {.name = "tradeoff",
                                 .synopsis = "[OPTIONS]",
                                 .what = what,
                                 .examples = examples,
                                 .options = options,
                                 .option_count = OWN + RUN_OPTION_COUNT};
    char *whole[256]; /* the arguments as they are: the parser takes lists apart */
    if (argc > 255) return command_fail("tradeoff", "too many arguments"), EXIT_USAGE;
    for (int k = 0; k < argc; k++) whole[k] = strdup(argv[k]);
    int status = options_parse(&usage, argc, argv, NULL);
    io_error error = {{0}};
    set_defaults(&o);
    if (status == OPTIONS_GO && !run_options_check(&o.run, "tradeoff")) status = EXIT_USAGE;
    if (status == OPTIONS_GO && o.counters && !counters_here()) status = child_run_counting(argc, whole);
    if (status == OPTIONS_GO)
        status = run(&o, argc, whole, &error) ? EXIT_SUCCESS : command_fail("tradeoff", "%s", error.text);
    for (int k = 0; k < argc; k++) free(whole[k]);
    return status;
}

const command command_tradeoff = {"tradeoff", "weigh speed against error for every mode of accuracy", start};
