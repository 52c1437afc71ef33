/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's commands from beginning to end, on work so small that their figures mean nothing: files hold the same
 * numbers, comparisons of a file with itself decide nothing, mistakes are told and leave nothing behind. */
#include "commands.h"
#include "harness/results.h"
#include "micro/micro.h"
#include "scenes/table.h"

#include "check.h"
#include "scratch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 24 };

/* Splits at spaces, as a shell would; commands write into their arguments. */
static int run(const command *of, const char *line) {
    char *copy = strdup(line), *arguments[ARGUMENTS_MAX + 1] = {strdup(of->name)};
    int count = 1;
    assert_non_null(copy);
    for (char *word = strtok(copy, " "); word && count < ARGUMENTS_MAX; word = strtok(NULL, " "))
        arguments[count++] = word;
    arguments[count] = NULL;
    const int status = of->run(count, arguments);
    free(arguments[0]);
    free(copy);
    return status;
}

static void write_text(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static char *read_text(const char *name) {
    size_t size;
    return scratch_read(name, &size);
}

/* The line of a text that starts so; the text is cut up behind it. */
static char *line_of(char *text, const char *start) {
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
        if (strncmp(line, start, strlen(start)) == 0) return line;
    return NULL;
}

static void table_files_hold_the_same_numbers(void **state) {
    (void)state;
    check(run(&command_table,
              "--quick --scene hftest --seconds 0.2 --path default,grid3d,grid3d-phong,auto-phong --out a/b") == 0,
          "the table fails");
    io_error error;
    json_t *lines = results_read("a/b/table.json", &error);
    check(lines != NULL, "%s", error.text);
    const json_t *of_scene = json_array_get(lines, json_array_size(lines) - 1);
    check(strcmp(results_text(of_scene, "scene"), "hftest") == 0, "the last line is no scene");
    const json_t *paths = json_object_get(of_scene, "paths"), *path;
    check(json_array_size(paths) == (peer_embree_version() ? 4 : 3), "%zu paths", json_array_size(paths));
    check(results_number(of_scene, "camera_rays") == 256 * 256, "%.0f camera rays",
          results_number(of_scene, "camera_rays"));

    char *markdown = read_text("a/b/table.md"), *page = NULL;
    size_t size, k;
    FILE *memory = open_memstream(&page, &size);
    assert_non_null(memory);
    table_write_markdown(memory, lines);
    fclose(memory);
    check(strcmp(markdown, page) == 0, "table.md is not what table.json gives");
    free(page);
    const char *cell = line_of(markdown, "| hftest |");
    check(cell != NULL, "table.md has no line on hftest");
    cell = strchr(cell + strlen("| hftest"), '|') + 1; /* pbrt-v2's column, out of papers/data */
    check(results_first(lines, "pbrt") != NULL, "nothing is said of pbrt-v2");
    check(fabs(strtod(cell, NULL) - results_number(of_scene, "pbrt_ratio")) <= 0.0501,
          "table.md gives %.10s for pbrt-v2's %g", cell, results_number(of_scene, "pbrt_ratio"));
    json_array_foreach(paths, k, path) {
        const double seconds = results_number(path, "seconds_median");
        cell = strchr(cell, '|') + 1;
        check(fabs(strtod(cell, NULL) - seconds) <= 0.0005 + 0.01 * seconds, "table.md gives %.10s for %g", cell,
              seconds);

        char *csv = read_text("a/b/table.csv"), start[128];
        snprintf(start, sizeof start, "hftest,%s,", results_text(path, "path"));
        char *row = line_of(csv, start);
        check(row != NULL, "table.csv has no line %s", start);
        row += strlen(start);
        for (int skip = 0; skip < 2; skip++) row = strchr(row, ',') + 1; /* by, samples */
        check(fabs(strtod(row, NULL) - seconds) <= 1e-8 * seconds, "table.csv gives %.12s for %g", row, seconds);
        free(csv);
        check(results_number(json_object_get(json_object_get(path, "agreement"), "why"), "other") == 0,
              "%s disagrees without a reason", results_text(path, "path"));
    }
    free(markdown);
    json_decref(lines);
}

static void paths_end_in_their_normals(void **state) {
    (void)state;
    static const struct {
        const char *text, *title;
        scene_normals normals;
    } good[] = {{"auto", "cellwalk", SCENE_NORMALS_FLAT},
                {"grid3d", "grid3d", SCENE_NORMALS_FLAT},
                {"cell-phong", "cell, Phong", SCENE_NORMALS_AREA},
                {"default-central", "Default, central", SCENE_NORMALS_CENTRAL},
                {"grid3d-bilinear", "grid3d, bilinear", SCENE_NORMALS_BILINEAR}};
    io_error error;
    table_path path;
    for (size_t k = 0; k < sizeof good / sizeof good[0]; k++) {
        check(table_path_parse(good[k].text, &path, &error), "%s", error.text);
        check(path.normals == good[k].normals && strcmp(path.title, good[k].title) == 0, "%s is taken for %s",
              good[k].text, path.title);
    }
    check(!table_path_parse("cell-flat", &path, &error) && strstr(error.text, "-central") != NULL, "%s", error.text);
    check(!table_path_parse("-phong", &path, &error), "a path without a name");
}

static const char *const small_micro =
    "--field 65 --rays primary,ao --kernel cell,pyramid1 --count 512 --seconds 0.3 --json m.json";

static void micro_against_itself_is_undecided(void **state) {
    (void)state;
    check(run(&command_micro, small_micro) == 0, "micro fails");
    compare_counts counts;
    io_error error;
    check(compare_files("m.json", "m.json", 0, &counts, &error), "%s", error.text);
    check(counts.faster == 0 && counts.slower == 0 && counts.undecided == 4 && counts.unmatched == 0,
          "faster %zu, slower %zu, undecided %zu, without partner %zu", counts.faster, counts.slower, counts.undecided,
          counts.unmatched);
    check(run(&command_compare, "m.json m.json") == 0, "compare fails");
    json_t *lines = results_read("m.json", &error), *line;
    check(lines != NULL, "%s", error.text);
    size_t builds = 0, k;
    json_array_foreach(lines, k, line) {
        const char *kind = results_text(line, "kind");
        if (strcmp(kind, "kernel_build") != 0 && strcmp(kind, "peer_build") != 0) continue;
        builds++;
        check(results_number(line, "build_seconds") > 0 && results_number(line, "bytes") > 0,
              "a %s without time or bytes", kind);
    }
    check(builds == (peer_embree_version() ? 2 : 1), "%zu builds", builds);
    json_decref(lines);
}

/* Answers of two threads are verified like all others, and their times are the clock's. */
static void threads_take_part(void **state) {
    (void)state;
    check(run(&command_micro, "--field 65 --rays random --kernel pyramid1 --peer none --threads 1,2 --count 16384 "
                              "--seconds 0.2 --json t.json") == 0,
          "micro fails");
    io_error error;
    json_t *lines = results_read("t.json", &error), *line;
    check(lines != NULL, "%s", error.text);
    size_t found = 0, builds = 0, k;
    json_array_foreach(lines, k, line) {
        if (strcmp(results_text(line, "kind"), "kernel_build") == 0) {
            builds++;
            check(results_number(line, "threads") == (double)builds && results_number(line, "update_seconds") > 0,
                  "build %zu: other threads, or no update", builds);
        }
        if (strcmp(results_text(line, "kind"), "result") != 0) continue;
        const double threads = results_number(line, "threads");
        const bool two = strcmp(results_text(line, "contender"), "pyramid1/watertight/t2") == 0;
        check(threads == (two ? 2 : 1), "%s has %.0f threads", results_text(line, "contender"), threads);
        check(results_number(json_object_get(line, "agreement"), "same_bits") == 16384, "answers differ");
        found++;
    }
    check(found == 2 && builds == 2, "%zu results, %zu builds", found, builds);
    json_decref(lines);
}

static void nothing_but_building(void **state) {
    (void)state;
    check(run(&command_micro, "--field 65 --rays none --kernel pyramid1 --peer none --json b.json") == 0,
          "micro fails");
    io_error error;
    json_t *lines = results_read("b.json", &error);
    check(lines != NULL, "%s", error.text);
    check(json_array_size(lines) == 3 && results_number(json_array_get(lines, 2), "build_seconds") > 0, "%zu lines",
          json_array_size(lines));
    json_decref(lines);
}

/* From 10^12 field lengths away floats cannot aim at the field. */
static void rays_start_farther_back(void **state) {
    (void)state;
    static const char *const small =
        "--field 65 --rays random --kernel pyramid1 --peer none --seconds 0.01 --pass 1000";
    char arguments[256];
    snprintf(arguments, sizeof arguments, "%s --back 0,2.5,1e12 --json b.json", small);
    check(run(&command_micro, arguments) == 0, "micro fails");
    io_error error;
    json_t *lines = results_read("b.json", &error);
    check(lines != NULL, "%s", error.text);
    static const char *const names[] = {"random", "random+2.5", "random+1e+12"};
    for (size_t k = 0; k < 3; k++) {
        const json_t *line = json_array_get(lines, k + 1);
        const double hits = results_number(line, "hit_share");
        check(strcmp(results_text(line, "rays"), names[k]) == 0, "no %s rays", names[k]);
        check(k < 2 ? hits > 0.5 : hits < 0.1, "%g of the %s rays hit", hits, names[k]);
    }
    json_decref(lines);
    snprintf(arguments, sizeof arguments, "%s --back -1", small);
    check(run(&command_micro, arguments) == 2, "a negative --back is taken");
}

/* Rays beside a surface, in calls that do not divide their number. */
static void calls_may_be_small(void **state) {
    (void)state;
    check(run(&command_micro, "--field 65 --rays beside --kernel pyramid1 --peer none --count 1000 --call 7 "
                              "--seconds 0.01 --json c.json") == 0,
          "micro fails");
    io_error error;
    json_t *lines = results_read("c.json", &error);
    check(lines != NULL, "%s", error.text);
    const json_t *line = results_first(lines, "result");
    check(line && strcmp(results_text(line, "rays"), "beside") == 0, "no rays beside the surface");
    check(strcmp(results_text(line, "contender"), "pyramid1/watertight/c7") == 0, "it is %s",
          results_text(line, "contender"));
    check(results_number(json_object_get(line, "agreement"), "same_bits") == 1000, "answers differ");
    json_decref(lines);
}

/* Two kernels and a control, in two runs. */
static void write_run(const char *name, double kernel, double control) {
    char text[1024];
    static const char *const format =
        "{\"kind\":\"run\",\"command\":\"micro\"}\n"
        "{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"ao\",\"contender\":\"cell/watertight\",\"ray_count\":16,"
        "\"seconds_median\":%g,\"seconds_low\":%g,\"seconds_high\":%g,\"interval_sure\":true}\n"
        "{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"ao\",\"contender\":\"embree/triangles/w1\",\"ray_count\":16,"
        "\"seconds_median\":%g,\"seconds_low\":%g,\"seconds_high\":%g,\"interval_sure\":true}\n";
    snprintf(text, sizeof text, format, kernel, kernel * 0.99, kernel * 1.01, control, control * 0.99, control * 1.01);
    write_text(name, text);
}

static void comparisons_need_more_than_the_machine(void **state) {
    (void)state;
    compare_counts counts;
    io_error error;
    write_run("before", 1, 1);
    write_run("after", 0.8, 1);
    check(compare_files("before", "after", 0.02, &counts, &error), "%s", error.text);
    check(counts.faster == 1 && counts.slower == 0, "0.8 s after 1 s is not faster");
    check(compare_files("after", "before", 0.02, &counts, &error), "%s", error.text);
    check(counts.faster == 0 && counts.slower == 1, "1 s after 0.8 s is not slower");
    write_run("after", 0.8, 0.8);
    check(compare_files("before", "after", 0.02, &counts, &error), "%s", error.text);
    check(counts.undecided == 1, "a faster machine counts as a faster kernel");

    write_text("other", "{\"kind\":\"run\",\"command\":\"micro\"}\n");
    check(!compare_files("before", "other", 0.02, &counts, &error), "nothing is compared, and all is well");
    check(strcmp(error.text, "before and other have no result in common") == 0, "%s", error.text);
    check(run(&command_compare, "other before") == 1, "compare of nothing succeeds");
}

static void results_are_checked(void **state) {
    (void)state;
    io_error error;
    compare_counts counts;
    check(!compare_files("none.json", "none.json", 0, &counts, &error) && strstr(error.text, "none.json"), "no file");
    write_text("bad.json", "{\"kind\":\"run\"}\n{\"kind\":");
    check(results_read("bad.json", &error) == NULL && strncmp(error.text, "bad.json:2:", 11) == 0, "told as %s",
          error.text);
    write_text("bad.json", "{\"kind\":\"result\"}\n");
    check(results_read("bad.json", &error) == NULL && strncmp(error.text, "bad.json:1:", 11) == 0, "told as %s",
          error.text);
    write_text("bad.json", "");
    check(results_read("bad.json", &error) == NULL, "an empty file has results");
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    static const struct {
        const command *of;
        const char *arguments;
        int status;
    } mistakes[] = {
        {&command_micro, "--kernel nonesuch", 2},
        {&command_micro, "--field 66", 2},
        {&command_micro, "--count 0", 2},
        {&command_micro, "--count many", 2},
        {&command_micro, "--call 0", 2},
        {&command_micro, "--count 1e9", 2},
        {&command_micro, "--seconds", 2},
        {&command_micro, "--isa mmx", 2},
        {&command_micro, "--threads 0", 2},
        {&command_micro, "--threads two", 2},
        {&command_micro, "--rays none,ao", 2},
        {&command_micro, "--nonesuch", 2},
        {&command_micro, "loose", 2},
        {&command_micro, "--field 65 --json nowhere/m.json", 1},
        {&command_table, "--path nonesuch", 2},
        {&command_table, "--scene nonesuch", 2},
        {&command_table, "--quick --scene hftest --out file/out", 1},
        {&command_table, "--quick --scene hftest --out file", 1},
        {&command_table, "--quick --scene hftest --scenes nowhere --out out", 1},
        {&command_compare, "one.json", 2},
        {&command_compare, "nowhere.json nowhere.json", 1},
    };
    write_text("file", "");
    for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++) {
        const int status = run(mistakes[k].of, mistakes[k].arguments);
        check(status == mistakes[k].status, "\"%s\" ends with %d", mistakes[k].arguments, status);
    }
    check(access("out/table.json", F_OK) != 0 && access("out/table.md", F_OK) != 0, "a failed table has left files");
    check(rmdir("out") == 0, "a failed table has left something in its folder");
}

static void helps(void **state) {
    (void)state;
    const command *const commands[] = {&command_micro, &command_table, &command_compare};
    for (size_t k = 0; k < 3; k++) check(run(commands[k], "--help") == 0, "help fails");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(table_files_hold_the_same_numbers, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(micro_against_itself_is_undecided, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(threads_take_part, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(nothing_but_building, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(calls_may_be_small, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(rays_start_farther_back, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(comparisons_need_more_than_the_machine, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_are_checked, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(mistakes_leave_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test(paths_end_in_their_normals),
        cmocka_unit_test(helps),
    };
    return cmocka_run_group_tests_name("bench_program", tests, NULL, NULL);
}
