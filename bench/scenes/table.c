/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/table.h"

#include "build_info.h"
#include "clock.h"
#include "commands.h"
#include "harness/memory.h"
#include "harness/results.h"
#include "words.h"

#include <stdlib.h>
#include <string.h>

static const char what[] =
    "Times the rendering of six scenes on one thread by every path, prints a table and writes it as table.md, "
    "table.csv and table.json. A path is Embree or a kernel to find hits, and a kind of normals. Paths take turns in "
    "rounds, each round in another order. The table shows seconds, the ratio to Default (Embree's triangle mesh) and "
    "millions of rays a second; the files also hold the counts of rays and whether all paths agree.";

static const char examples[] = "  cellwalk-bench table --quick       # a first look, in 15 seconds\n"
                               "  cellwalk-bench table --scene landsea-big --path default,auto,grid3d\n";

/* The files of a table, opened before any work, so that a folder that cannot be written to is found out first. */
enum { MARKDOWN, CSV, JSON, FILES };
static const char *const names[FILES] = {"table.md", "table.csv", "table.json"};

/* Folds paragraphs for a terminal; tables stay as they are. */
static void print_text(const char *text) {
    enum { COLUMNS = 80 };
    for (size_t length; *text; text += length + (text[length] == '\n')) {
        length = strcspn(text, "\n");
        if (*text == '|')
            printf("%.*s", (int)length, text);
        else
            words_fold(text, length, 0, 0, COLUMNS);
        putchar('\n');
    }
}

static bool save(io_output *out, const json_t *lines, io_error *error) {
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    if (stream == NULL) memory_end();
    table_write_markdown(stream, lines);
    if (fclose(stream) != 0) memory_end();
    print_text(text);
    bool good = io_output_write(&out[MARKDOWN], text, size, error);
    free(text);
    table_write_csv(out[CSV].file, lines);
    good = good && results_write_all(&out[JSON], lines, error);
    for (size_t f = FILES; good && f-- > 0;) good = io_output_commit(&out[f], error);
    return good;
}

/* Large scenes take longer, so time is not shared evenly. */
static double weight(const char *name) { return strcmp(name, "landsea-big") == 0 ? 4 : 1; }

static bool run_scenes(const table_options *o, const table_path *paths, size_t count, json_t *lines, io_error *error) {
    const double start = clock_seconds();
    double weights = 0;
    for (size_t s = 0; s < o->scenes.count; s++) weights += weight(o->scenes.item[s]);
    for (size_t s = 0; s < o->scenes.count; s++) {
        const char *name = o->scenes.item[s];
        const double left = o->seconds - (clock_seconds() - start);
        fprintf(stderr, "%s (%zu of %zu)\n", name, s + 1, o->scenes.count);
        json_t *line = table_scene_run(name, paths, count, o, left > 0 ? left * weight(name) / weights : 0, error);
        weights -= weight(name);
        if (line == NULL) return false;
        results_append(lines, line);
    }
    return true;
}

/* The time of pbrt-v2, as a ratio of whole processes on the machine where both were measured, and that machine's
 * name. */
static void add_pbrt(json_t *lines) {
    io_error none;
    size_t k, f;
    json_t *line, *fact, *facts = results_read(BUILD_INFO_PBRT, &none);
    json_array_foreach(facts, f, fact) {
        json_array_foreach(lines, k, line) {
            if (!results_is(line, "scene") || !results_is(fact, "scene") || !results_same(line, fact, "scene"))
                continue;
            results_set_number(line, "pbrt_ratio",
                               results_number(fact, "pbrt_seconds") / results_number(fact, "cellwalk_seconds"));
        }
        if (results_is(fact, "run") && json_array_insert(lines, 1, fact) == 0)
            results_set_text(json_array_get(lines, 1), "kind", "pbrt");
    }
    json_decref(facts);
}

static bool run(const table_options *o, io_error *error) {
    table_path paths[TABLE_PATHS_MAX];
    size_t count = 0;
    int cpu;
    if (!run_options_pin(&o->run, &cpu, error)) return false;
    json_t *lines = json_array(), *record = run_record("table", o->run.seed, cpu);
    io_output out[FILES] = {0};
    results_set_bool(record, "quick", o->quick);
    results_set_count(record, "samples_a_pixel", o->samples);
    results_append(lines, record);
    bool good = table_paths_choose(o, paths, &count, lines, error);
    for (size_t f = 0; good && f < FILES; f++) good = io_output_open_in(&out[f], o->out, names[f], error);
    good = good && run_scenes(o, paths, count, lines, error);
    if (good) add_pbrt(lines);
    good = good && save(out, lines, error);
    for (size_t f = 0; f < FILES; f++) io_output_discard(&out[f]);
    json_decref(lines);
    fflush(stdout);
    if (good) fprintf(stderr, "saved %s/table.md, table.csv and table.json\n", o->out);
    return good;
}

static int start(int argc, char **argv) {
    table_options o = {.run = RUN_DEFAULTS, .out = "out/table", .scene_folder = BUILD_INFO_SCENES, .width = 0.02};
    const option_spec options[] = {
        {"out", "FOLDER", "folder for table.md, .csv and .json, made if missing (out/table)", OPTION_TEXT,
         .to = &o.out},
        {"scene", "NAMES", "only these scenes", OPTION_LIST, .to = &o.scenes, .names = scene_names},
        {"scenes", "FOLDER", "folder with the scenes' .pbrt files; by default those built with this program",
         OPTION_TEXT, .to = &o.scene_folder},
        {"path", "NAMES",
         "paths to time: default (Embree), auto (the library's choice) or a kernel, with an ending for the normals: "
         "-phong for Phong normals weighted by the triangles' areas, -central for central differences, -bilinear for "
         "these, interpolated bilinearly over a cell",
         OPTION_LIST, .to = &o.paths},
        {"leaf", "NAME", "leaf test of the library's kernels", OPTION_NAME, .to = &o.leaf, .names = option_leaf_names},
        {"samples", "N", "samples a pixel; 0 (default): as in the scene", OPTION_COUNT, .to = &o.samples, .high = 1024},
        {"seconds", "S", "seconds for all, kept as far as possible (120; 15 with --quick)", OPTION_REAL,
         .to = &o.seconds, .low = 0.01, .high = 1e6},
        {"width", "SHARE", "stop when the confidence interval is narrower than SHARE of the median (0.02)", OPTION_REAL,
         .to = &o.width, .low = 1e-6, .high = 10},
        {"quick", NULL, "one sample a pixel, fewer rounds: a first look", OPTION_FLAG, .to = &o.quick},
        RUN_OPTIONS(o.run),
    };
    const options_usage usage = {"table", "[OPTIONS]", what, examples, options, sizeof options / sizeof *options,
                                 NULL,    0,           0};
    const int status = options_parse(&usage, argc, argv, NULL);
    if (status != OPTIONS_GO) return status;
    io_error error = {{0}};
    if (o.seconds <= 0) o.seconds = o.quick ? 15 : 120;
    if (o.quick && o.samples == 0) o.samples = 1;
    if (o.scenes.count == 0) option_list_fill(&o.scenes, scene_names, 0, SCENES);
    if (!run_options_check(&o.run, "table")) return EXIT_USAGE;
    for (size_t p = 0; p < o.paths.count; p++) {
        table_path path;
        if (!table_path_parse(o.paths.item[p], &path, &error))
            return command_fail("table", "%s", error.text), EXIT_USAGE;
    }
    return run(&o, &error) ? EXIT_SUCCESS : command_fail("table", "%s", error.text);
}

const command command_table = {"table", "time six scenes rendered by Embree and the kernels; write the table", start};
