/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of cellwalk-bench tradeoff, and its files. */

#include "accuracy/run.h"

#include "build_info.h"
#include "harness/choices.h"
#include "harness/folder.h"
#include "harness/results.h"
#include "output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-bench tradeoff [OPTIONS]\n"
    "\n"
    "What does accuracy cost, and what does giving some up buy? Runs every mode of accuracy with every kernel that has "
    "it,\n"
    "and Embree, on the same rays; finds each answer's error, then times all of them in rounds on one thread.\n"
    "\n"
    "The truth is the strict watertight answer, which the tests hold against an exact oracle, with t computed anew "
    "from ray\n"
    "and triangle to 2^-26 of a float's last place. What rounding excuses (papers/numerics.md) does not count:\n"
    "  leak      the ray passes clearly through the surface, and there is no hit\n"
    "  phantom   a hit where the ray is clear of the surface\n"
    "  wrong     a hit, but behind a surface that the ray has clearly passed\n"
    "  beyond    the sum of these that the mode's own claim, half a step of 16-bit samples say, does not explain\n"
    "  t         error of all other hits: in ULP of the exact t, and as a distance along the ray in cells\n"
    "  off       how far such a hit is above or below the surface, in cells; unlike t it does not grow where rays run "
    "along it\n"
    "  normal    angle between the Phong normals at the hit and at the exact place, degrees\n"
    "\n"
    "Who is beaten by nobody in both speed and error is on the Pareto frontier: once for wrong answers a million rays, "
    "once\n"
    "for the worst height off the surface. Beside the benchmark's classes of rays, 'vertices' and 'edges' are aimed "
    "at\n"
    "these, to find leaks; they are not timed. The six scenes are rendered with each mode and held against strict.\n"
    "\n"
    "Saves tradeoff.json in a folder.\n"
    "\n"
    "Options (lists are NAME,NAME or the option again):\n";

static const char *const examples =
    "\n"
    "Examples:\n"
    "  cellwalk-bench tradeoff\n"
    "      A first look, in a minute.\n"
    "  cellwalk-bench tradeoff --mode strict,moller-trumbore --kernel pyramid8 --field 1025 --scene none\n"
    "      What does the watertight leaf test cost?\n"
    "  cellwalk-bench tradeoff --long --out papers/data/tradeoff\n"
    "      The figures of the page, on a quiet machine.\n";

static const char *const scene_names[] = {"hftest",  "landsea-0",   "landsea-1", "landsea-2",
                                          "texture", "landsea-big", "none"};
enum { SCENE_NAMES = sizeof scene_names / sizeof scene_names[0] };

static bool check_options(tradeoff_options *o, io_error *error) {
    const char *names[OPTION_LIST_MAX];
    size_t count = 0;
    for (; count < tradeoff_mode_count() && count < OPTION_LIST_MAX; count++)
        names[count] = tradeoff_mode_at(count)->name;
    if (!options_check_names(&o->modes, "--mode", names, count, 0, error)) return false;
    if (!choices_kernels(&o->kernels, error)) return false;
    for (count = 0; count < TRADEOFF_CLASS_COUNT; count++) names[count] = tradeoff_class_name((int)count);
    if (!options_check_names(&o->rays, "--rays", names, count, count, error)) return false;
    if (o->fields.count == 0) {
        static const char *const some[] = {"257", "1025"}, *const more[] = {"65",   "257",      "1025",
                                                                            "4097", "sea-calm", "sea-rough"};
        for (size_t k = 0; k < (o->longer ? 6 : 2); k++)
            o->fields.items[o->fields.count++] = (o->longer ? more : some)[k];
    }
    if (!choices_fields(&o->fields, 0, error)) return false;
    if (!options_check_names(&o->scenes, "--scene", scene_names, SCENE_NAMES, SCENE_NAMES - 1, error)) return false;
    return choices_isa(o->isa_name, &o->isa, error);
}

/* ---- files ---- */

static bool open_file(io_output *out, const char *folder, const char *name, io_error *error) {
    char path[4352];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return io_output_open(out, path, error);
}

static bool run(const tradeoff_options *o, io_error *error) {
    io_output json = {0};
    json_t *lines = json_array();
    bool good = (lines || io_fail(error, "out of memory")) && folder_make(o->out, error) &&
                open_file(&json, o->out, "tradeoff.json", error) && tradeoff_run(o, lines, error);
    size_t index;
    json_t *line;
    json_array_foreach(lines, index, line) good = good && results_write(&json, json_incref(line), error);
    good = good && io_output_commit(&json, error);
    if (good) tradeoff_print(lines);
    io_output_discard(&json);
    json_decref(lines);
    fflush(stdout);
    if (good) fprintf(stderr, "saved %s/tradeoff.json\n", o->out);
    return good;
}

int tradeoff_main(char **arguments, int count) {
    tradeoff_options o = {.out = "out/tradeoff", .scene_folder = BUILD_INFO_SCENES, .seed = 1, .cpu = UINT64_MAX};
    const option options[] = {
        {"--mode", "NAMES",
         "only these; all but the grids by default, and these too with --long: strict, moller-trumbore, early, "
         "samples-16, tolerance-0.1, tolerance-1, cone-pixel, embree, embree-robust, embree-grid, "
         "embree-grid-robust",
         OPTION_LIST, &o.modes, 0, 0},
        {"--kernel", "NAMES", "only these kernels (cellwalk info lists them), beside Embree", OPTION_LIST, &o.kernels,
         0, 0},
        {"--rays", "NAMES", "only these classes: primary, shadow, ao, bounce, random, grazing, vertices, edges",
         OPTION_LIST, &o.rays, 0, 0},
        {"--field", "NAMES", "fields of micro; 257, 1025 by default; 65, 4097, sea-calm, sea-rough too with --long",
         OPTION_LIST, &o.fields, 0, 0},
        {"--scene", "NAMES", "only these: hftest, landsea-0, landsea-1, landsea-2, texture, landsea-big; or none",
         OPTION_LIST, &o.scenes, 0, 0},
        {"--scenes", "FOLDER", "where the scenes' .pbrt files are; by default those made with this program",
         OPTION_TEXT, &o.scene_folder, 0, 0},
        {"--isa", "NAME", "instruction set for all, Embree as well: scalar, sse4.2, avx2 or avx512", OPTION_TEXT,
         &o.isa_name, 0, 0},
        {"--count", "N", "rays in a class (16384; 1048576 with --long)", OPTION_COUNT, &o.count, 64, 1 << 24},
        {"--samples", "N", "samples a pixel of the scenes (1; what the scene says with --long)", OPTION_COUNT,
         &o.samples, 0, 1024},
        {"--seconds", "S", "time for errors and speeds on the fields, as far as it can be kept (15; 1200 with --long)",
         OPTION_REAL, &o.seconds, 0.01, 1e6},
        {"--pass", "S", "who takes longer for one pass runs on fewer rays, down to a 64th (0.05; 0.5 with --long)",
         OPTION_REAL, &o.pass, 1e-6, 1e6},
        {"--seed", "N", "of rays and order (1)", OPTION_COUNT, &o.seed, 0, UINT32_MAX},
        {"--cpu", "N", "stay on this CPU; by default on the one that the program starts on", OPTION_COUNT, &o.cpu, 0,
         1023},
        {"--no-pin", NULL, "let the system move the program between CPUs", OPTION_FLAG, &o.no_pin, 0, 0},
        {"--long", NULL, "all fields but the largest, more rays, more time", OPTION_FLAG, &o.longer, 0, 0},
        {"--out", "FOLDER", "where to save tradeoff.json; made if need be (out/tradeoff)", OPTION_TEXT, &o.out, 0, 0},
    };
    const option_frame frame = {.command = "tradeoff",
                                .usage = usage,
                                .examples = examples,
                                .options = options,
                                .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    if (o.count == 0) o.count = o.longer ? 1 << 20 : 1 << 14;
    if (o.seconds <= 0) o.seconds = o.longer ? 1200 : 15;
    if (o.pass <= 0) o.pass = o.longer ? 0.5 : 0.05;
    if (o.samples == 0 && !o.longer) o.samples = 1;
    if (!check_options(&o, &error)) return options_misused("tradeoff", &error);
    cw_isa_limit(o.isa);
    if (run(&o, &error)) return EXIT_SUCCESS;
    return options_failed("tradeoff", &error);
}
