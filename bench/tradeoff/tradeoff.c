/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of cellwalk-bench tradeoff, and its file. */
#include "tradeoff/tradeoff.h"

#include "commands.h"
#include "harness/memory.h"
#include "harness/results.h"

#include <stdio.h>
#include <stdlib.h>

static const char what[] =
    "Measures the gain and the error of each choice between speed and accuracy, on fractal land, one thread; "
    "writes tradeoff.json to a folder.\n\n"
    "  rays      coarser land: how far its surface is promised to lie from the full one, and does; speed and error of "
    "a view's rays, beside strict and Embree\n"
    "  horizons  exact, along the grid, within a distance, and of coarser land\n"
    "  sky       the sky-view factor, by directions, distance and resolution, against 256 directions\n"
    "  pictures  by samples a pixel and resolution, against 1024 samples a pixel\n\n"
    "Contenders are timed in rounds. papers/scripts/tables.py --data makes tables of the file.";

static const char examples[] = "  cellwalk-bench tradeoff --quick       # to see whether all runs\n"
                               "  cellwalk-bench tradeoff --part horizons\n"
                               "  cellwalk-bench tradeoff --part rays --land 1025,8193,32769\n";

enum { RAYS, HORIZONS, SKY, PICTURES, PARTS };

static const char *part_names(size_t number) {
    static const char *const names[PARTS] = {"rays", "horizons", "sky", "pictures"};
    return number < PARTS ? names[number] : NULL;
}

static void set_defaults(tradeoff_options *o) {
    if (o->count == 0) o->count = o->quick ? 2048 : 1 << 20;
    if (o->seconds <= 0) o->seconds = o->quick ? 1 : 60;
    if (o->sides.count > 0) return;
    option_list_fill(&o->sides, tradeoff_land_name, o->quick ? 0 : 2, o->quick ? 1 : 3); /* 65, or 1025 and 8193 */
    if (!o->quick) option_list_fill(&o->sides, tradeoff_land_name, 4, 5);
}

static bool measure_all(const tradeoff_options *o, json_t *lines, io_error *error) {
    const char *land = o->quick ? "257" : "1025", *large = o->quick ? "257" : "4097";
    bool good = true;
    for (size_t k = 0; good && k < o->sides.count && option_wanted(&o->parts, RAYS); k++)
        good = tradeoff_resolution_run(o->sides.item[k], o, 0.5 * o->seconds / (double)o->sides.count, lines, error);
    if (good && option_wanted(&o->parts, HORIZONS))
        good = tradeoff_horizons_run(land, false, o, 0.3 * o->seconds, lines, error) &&
               tradeoff_horizons_run(large, true, o, 0.2 * o->seconds, lines, error);
    if (good && option_wanted(&o->parts, SKY)) good = tradeoff_sky_run(land, o, lines, error);
    if (good && option_wanted(&o->parts, PICTURES))
        good = tradeoff_pictures_run(o->quick ? "257" : "8193", o, lines, error);
    return good;
}

static bool run(const tradeoff_options *o, io_error *error) {
    io_output json = {0};
    int cpu;
    if (!run_options_pin(&o->run, &cpu, error)) return false;
    json_t *lines = json_array(), *record = run_record("tradeoff", o->run.seed, cpu);
    results_set_count(record, "ray_count", o->count);
    results_append(lines, record);
    const bool good = io_output_open_in(&json, o->out, "tradeoff.json", error) && measure_all(o, lines, error) &&
                      results_write_all(&json, lines, error) && io_output_commit(&json, error);
    io_output_discard(&json);
    json_decref(lines);
    if (good) fprintf(stderr, "saved %s/tradeoff.json\n", o->out);
    return good;
}

static int start(int argc, char **argv) {
    tradeoff_options o = {.run = RUN_DEFAULTS, .out = "out/tradeoff"};
    const option_spec options[] = {
        {"part", "NAMES", "only these parts", OPTION_LIST, .to = &o.parts, .names = part_names},
        {"land", "NAMES", "lands for rays, by samples a side (1025,8193); 32769 takes 9 GB", OPTION_LIST,
         .to = &o.sides, .names = tradeoff_land_name},
        {"count", "N", "rays of the view (1048576)", OPTION_COUNT, .to = &o.count, .low = 64, .high = 1 << 20},
        {"seconds", "S", "seconds for speeds of rays and horizons, kept as far as possible (60)", OPTION_REAL,
         .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"quick", NULL, "small land and few rays: to see whether all runs", OPTION_FLAG, .to = &o.quick},
        {"out", "FOLDER", "folder for tradeoff.json, made if missing (out/tradeoff)", OPTION_TEXT, .to = &o.out},
        RUN_OPTIONS(o.run),
    };
    const options_usage usage = {"tradeoff", "[OPTIONS]", what, examples, options, sizeof options / sizeof *options,
                                 NULL,       0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    io_error error = {{0}};
    set_defaults(&o);
    if (!run_options_check(&o.run, "tradeoff")) return EXIT_USAGE;
    return run(&o, &error) ? EXIT_SUCCESS : command_fail("tradeoff", "%s", error.text);
}

const command command_tradeoff = {"tradeoff", "measure gain and error of coarser fields and fewer directions", start};
