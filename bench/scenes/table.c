/* SPDX-License-Identifier: Apache-2.0 */
#include "scenes/table.h"

#include "build_info.h"
#include "clock.h"
#include "harness/folder.h"
#include "harness/results.h"
#include "harness/run_record.h"
#include "harness/timing.h"
#include "output.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const scene_names[] = {"hftest", "landsea-0", "landsea-1", "landsea-2", "texture", "landsea-big"};
enum { SCENE_COUNT = sizeof scene_names / sizeof scene_names[0] };

static const char *const usage =
    "Usage: cellwalk-bench table [OPTIONS]\n"
    "\n"
    "Renders the six scenes on one thread along every path, in rounds, each round in another order, and prints time,\n"
    "ratio to Default (Embree's triangle mesh), tracing speed, counts of rays, and whether all paths agree. Saves\n"
    "table.md, table.csv and table.json in a folder.\n"
    "\n"
    "Options (lists are NAME,NAME or the option again):\n";

/* The three files of a table, opened before any work, so that a folder that cannot be written to is found out first. */
typedef struct files {
    io_output markdown, csv, json;
} files;

static bool open_file(io_output *out, const char *folder, const char *name, io_error *error) {
    char *path = NULL;
    if (asprintf(&path, "%s/%s", folder, name) < 0) return io_fail(error, "out of memory");
    const bool good = io_output_open(out, path, error);
    free(path);
    return good;
}

static bool open_files(files *f, const char *folder, io_error *error) {
    return folder_make(folder, error) && open_file(&f->markdown, folder, "table.md", error) &&
           open_file(&f->csv, folder, "table.csv", error) && open_file(&f->json, folder, "table.json", error);
}

static bool write_text(io_output *out, char *text, io_error *error) {
    const bool good = text ? io_output_write(out, text, strlen(text), error) : io_fail(error, "out of memory");
    free(text);
    return good;
}

static bool save(files *f, const json_t *lines, io_error *error) {
    size_t index;
    json_t *line;
    json_array_foreach((json_t *)lines, index, line) {
        if (!results_write(&f->json, json_incref(line), error)) return false;
    }
    char *text = table_markdown(lines, false);
    if (text) fputs(text, stdout);
    return write_text(&f->markdown, text, error) && write_text(&f->csv, table_csv(lines), error) &&
           io_output_commit(&f->json, error) && io_output_commit(&f->csv, error) &&
           io_output_commit(&f->markdown, error);
}

/* Large scenes take longer, so time is not shared evenly. */
static double weight(const char *scene) { return strcmp(scene, "landsea-big") == 0 ? 4 : 1; }

static bool run_scenes(const table_options *o, const table_path *paths, size_t count, json_t *lines, io_error *error) {
    const double start = clock_seconds();
    double weights = 0;
    for (size_t s = 0; s < o->scenes.count; s++) weights += weight(o->scenes.items[s]);
    for (size_t s = 0; s < o->scenes.count; s++) {
        const char *name = o->scenes.items[s];
        char file[4096];
        if (snprintf(file, sizeof file, "%s/%s.pbrt", o->scene_folder, name) >= (int)sizeof file)
            return io_fail(error, "--scenes %s: the name is too long", o->scene_folder);
        const double left = o->seconds - (clock_seconds() - start);
        fprintf(stderr, "%s (%zu of %zu)\n", name, s + 1, o->scenes.count);
        json_t *line =
            table_scene_run(name, file, paths, count, o, left > 0 ? left * weight(name) / weights : 0, error);
        weights -= weight(name);
        if (line == NULL) return false;
        if (json_array_append_new(lines, line) != 0) return io_fail(error, "out of memory");
    }
    return true;
}

static bool run(const table_options *o, io_error *error) {
    table_path paths[TABLE_PATHS_MAX];
    size_t count = 0;
    json_t *lines = json_array();
    files out = {0};
    const int cpu = o->no_pin ? -1 : timing_pin(o->cpu == UINT64_MAX ? -1 : (int)o->cpu);
    bool good = lines || io_fail(error, "out of memory");
    if (good && !o->no_pin && cpu < 0)
        good = io_fail(error, "--cpu %d: the system does not allow this process there", (int)o->cpu);
    json_t *record = good ? run_record("table", (uint32_t)o->seed, cpu) : NULL;
    if (record) {
        results_set_bool(record, "quick", o->quick);
        results_set_count(record, "samples_a_pixel", (size_t)o->samples);
    }
    good = good && (json_array_append_new(lines, record) == 0 || io_fail(error, "out of memory")) &&
           table_paths_choose(o, paths, &count, lines, error) && open_files(&out, o->out, error) &&
           run_scenes(o, paths, count, lines, error) && save(&out, lines, error);
    io_output_discard(&out.json);
    io_output_discard(&out.csv);
    io_output_discard(&out.markdown);
    json_decref(lines);
    fflush(stdout);
    if (good) fprintf(stderr, "saved %s/table.md, table.csv and table.json\n", o->out);
    return good;
}

static bool check(table_options *o, io_error *error) {
    if (o->scenes.count == 0)
        for (size_t s = 0; s < SCENE_COUNT; s++) o->scenes.items[o->scenes.count++] = scene_names[s];
    for (size_t s = 0; s < o->scenes.count; s++) {
        size_t known = 0;
        while (known < SCENE_COUNT && strcmp(scene_names[known], o->scenes.items[s]) != 0) known++;
        if (known == SCENE_COUNT)
            return io_fail(error,
                           "--scene %s: the scenes are hftest, landsea-0, landsea-1, landsea-2, texture, landsea-big",
                           o->scenes.items[s]);
    }
    for (int leaf = 0; leaf < CW_LEAF_COUNT; leaf++)
        if (strcmp(o->leaf_name, cw_leaf_name((cw_leaf)leaf)) == 0) o->leaf = (cw_leaf)leaf;
    if (strcmp(o->leaf_name, cw_leaf_name(o->leaf)) != 0)
        return io_fail(error, "--leaf %s: must be default, moller-trumbore or watertight", o->leaf_name);
    o->isa = cw_isa_best();
    for (size_t p = 0; p < o->paths.count; p++) {
        table_path path;
        if (!table_path_parse(o->paths.items[p], o->leaf, &path, error)) return false;
    }
    return true;
}

int table_main(char **arguments, int count) {
    table_options o = {.out = "out/table",
                       .scene_folder = BUILD_INFO_SCENES,
                       .leaf_name = "default",
                       .seed = 1,
                       .cpu = UINT64_MAX,
                       .width = 0.02};
    const option options[] = {
        {"--out", "FOLDER", "where to save table.md, .csv and .json; made if need be (out/table)", OPTION_TEXT, &o.out,
         0, 0},
        {"--scene", "NAMES", "only these: hftest, landsea-0, landsea-1, landsea-2, texture, landsea-big", OPTION_LIST,
         &o.scenes, 0, 0},
        {"--scenes", "FOLDER", "where the scenes' .pbrt files are; by default those made with this program",
         OPTION_TEXT, &o.scene_folder, 0, 0},
        {"--path", "NAMES",
         "paths: default (Embree), auto (what the library chooses) or a kernel, each with -phong after "
         "it for Phong normals",
         OPTION_LIST, &o.paths, 0, 0},
        {"--leaf", "NAME", "leaf test of the library's kernels: default, moller-trumbore or watertight", OPTION_TEXT,
         &o.leaf_name, 0, 0},
        {"--samples", "N", "samples a pixel; 0, the default, is what the scene says", OPTION_COUNT, &o.samples, 0,
         1024},
        {"--seconds", "S", "time for all, as far as it can be kept (120; 15 with --quick)", OPTION_REAL, &o.seconds,
         0.01, 1e6},
        {"--width", "SHARE", "narrow enough: width of the confidence interval over the median (0.02)", OPTION_REAL,
         &o.width, 1e-6, 10},
        {"--seed", "N", "of the order (1)", OPTION_COUNT, &o.seed, 0, UINT32_MAX},
        {"--cpu", "N", "stay on this CPU; by default on the one that the program starts on", OPTION_COUNT, &o.cpu, 0,
         1023},
        {"--no-pin", NULL, "let the system move the program between CPUs", OPTION_FLAG, &o.no_pin, 0, 0},
        {"--quick", NULL, "one sample a pixel, fewer rounds: a first look", OPTION_FLAG, &o.quick, 0, 0},
    };
    const option_frame frame = {
        .command = "table", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    if (o.seconds <= 0) o.seconds = o.quick ? 15 : 120;
    if (o.quick && o.samples == 0) o.samples = 1;
    if (!check(&o, &error)) return options_misused("table", &error);
    if (run(&o, &error)) return EXIT_SUCCESS;
    return options_failed("table", &error);
}
