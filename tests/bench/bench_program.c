/* SPDX-License-Identifier: Apache-2.0 */
/* The benchmark's commands from beginning to end, on work so small that their figures mean nothing: files hold the same
 * numbers, comparisons of a file with itself decide nothing, mistakes are told and leave nothing behind. */
#include "campaign.h"
#include "compare.h"
#include "micro.h"
#include "parts.h"
#include "plot.h"
#include "report.h"
#include "results.h"
#include "table.h"
#include "targets.h"

#include "check.h"
#include "scratch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 16 };

typedef int command(char **arguments, int count);

/* Splits at spaces, as a shell would; commands write into their arguments. */
static int run(command *of, const char *line) {
    char *copy = strdup(line), *arguments[ARGUMENTS_MAX];
    int count = 0;
    assert_non_null(copy);
    for (char *word = strtok(copy, " "); word && count < ARGUMENTS_MAX; word = strtok(NULL, " "))
        arguments[count++] = word;
    const int status = of(arguments, count);
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
    check(run(table_main,
              "--quick --scene hftest --seconds 0.2 --path default,grid3d,grid3d-phong,auto-phong --out a/b") == 0,
          "the table fails");
    io_error error;
    json_t *lines = results_read("a/b/table.json", &error);
    check(lines != NULL, "%s", error.text);
    const json_t *scene = json_array_get(lines, json_array_size(lines) - 1);
    check(strcmp(results_text(scene, "scene"), "hftest") == 0, "the last line is no scene");
    const json_t *paths = json_object_get(scene, "paths"), *path;
    check(json_array_size(paths) == (peer_embree_version() ? 4 : 3), "%zu paths", json_array_size(paths));
    check(results_number(scene, "camera_rays") == 256 * 256, "%.0f camera rays", results_number(scene, "camera_rays"));

    char *markdown = read_text("a/b/table.md"), *page = table_markdown(lines, false);
    check(page && strcmp(markdown, page) == 0, "table.md is not what table.json gives");
    const char *cell = line_of(markdown, "| hftest |");
    check(cell != NULL, "table.md has no line on hftest");
    cell += strlen("| hftest");
    size_t k;
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
    free(page);
    free(markdown);
    json_decref(lines);
}

static const char *const small_micro =
    "--field 65 --rays primary,ao --kernel cell,pyramid1 --count 512 --seconds 0.3 --json m.json";

static void micro_against_itself_is_undecided(void **state) {
    (void)state;
    check(run(micro_main, small_micro) == 0, "micro fails");
    compare_counts counts;
    io_error error;
    check(compare_files("m.json", "m.json", 0, &counts, &error), "%s", error.text);
    check(counts.faster == 0 && counts.slower == 0 && counts.undecided == 4 && counts.unmatched == 0,
          "faster %zu, slower %zu, undecided %zu, without partner %zu", counts.faster, counts.slower, counts.undecided,
          counts.unmatched);
    check(run(compare_main, "m.json m.json") == 0, "compare fails");
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
    check(run(micro_main, "--compare m.json m.json") == 0, "micro --compare fails");
}

/* Answers of two threads are verified like all others, and their times are the clock's. */
static void threads_take_part(void **state) {
    (void)state;
    check(run(micro_main, "--field 65 --rays random --kernel pyramid1 --peer none --threads 1,2 --count 16384 "
                          "--seconds 0.2 --json t.json") == 0,
          "micro fails");
    io_error error;
    json_t *lines = results_read("t.json", &error), *line;
    check(lines != NULL, "%s", error.text);
    size_t found = 0, k;
    json_array_foreach(lines, k, line) {
        if (strcmp(results_text(line, "kind"), "result") != 0) continue;
        const double threads = results_number(line, "threads");
        const bool two = strcmp(results_text(line, "contender"), "pyramid1/watertight/t2") == 0;
        check(threads == (two ? 2 : 1), "%s has %.0f threads", results_text(line, "contender"), threads);
        check(results_number(json_object_get(line, "agreement"), "same_bits") == 16384, "answers differ");
        found++;
    }
    check(found == 2, "%zu results", found);
    json_decref(lines);
}

/* Each piece for each kernel of the pyramid, and its figures agree with each other. */
static void pieces_are_timed(void **state) {
    (void)state;
    check(run(parts_main, "--quick --seconds 0.05 --json p.json") == 0, "parts fails");
    io_error error;
    json_t *lines = results_read("p.json", &error), *line;
    check(lines != NULL, "%s", error.text);
    size_t found = 0, sets = 0, k;
    for (size_t n = 0; n < cw_kernel_count(); n++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(n));
        sets += info.available && strncmp(info.name, "pyramid", 7) == 0;
    }
    json_array_foreach(lines, k, line) {
        if (strcmp(results_text(line, "kind"), "part") != 0) continue;
        const double rate = results_number(line, "operations") / results_number(line, "seconds_median");
        check(rate > 0 && fabs(results_number(line, "per_second") / rate - 1) < 1e-6, "%s: %g a second, not %g",
              results_text(line, "part"), results_number(line, "per_second"), rate);
        found++;
    }
    /* Five that read no table, four that read three, for each set; building and copying. */
    check(found == sets * (5 + 4 * 3) + 2, "%zu parts", found);
    json_decref(lines);
}

static void nothing_but_building(void **state) {
    (void)state;
    check(run(micro_main, "--field 65 --rays none --kernel pyramid1 --peer none --json b.json") == 0, "micro fails");
    io_error error;
    json_t *lines = results_read("b.json", &error);
    check(lines != NULL, "%s", error.text);
    check(json_array_size(lines) == 3 && results_number(json_array_get(lines, 2), "build_seconds") > 0, "%zu lines",
          json_array_size(lines));
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
    check(run(compare_main, "other before") == 1, "compare of nothing succeeds");
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

static void add_line(char *text, size_t size, const char *line) {
    const size_t used = strlen(text);
    check(used + strlen(line) + 2 < size, "the file is too long");
    snprintf(text + used, size - used, "%s\n", line);
}

/* Speeds of 20 against 10 and 8, so that each ratio is 2; but for one class on one field, where it is given. */
static void write_speeds(const char *name, const char *odd_field, const char *odd_rays, double odd) {
    static const char *const fields[] = {"65", "257", "1025", "4097", "8193"};
    static const char *const rays[] = {"primary", "shadow", "ao", "bounce", "random", "grazing"};
    static char text[65536];
    char line[512];
    text[0] = '\0';
    add_line(text, sizeof text, "{\"kind\":\"run\",\"command\":\"micro\",\"cpu\":\"Abacus 3000\"}");
    for (size_t f = 0; f < 5; f++) {
        snprintf(line, sizeof line,
                 "{\"kind\":\"field\",\"field\":\"%s\",\"nx\":%s,\"ny\":%s,"
                 "\"default_kernel\":\"pyramid8\",\"bytes_samples\":1000}",
                 fields[f], fields[f], fields[f]);
        add_line(text, sizeof text, line);
        for (size_t r = 0; r < 6; r++) {
            const bool is_odd = strcmp(fields[f], odd_field) == 0 && strcmp(rays[r], odd_rays) == 0;
            static const struct {
                const char *name;
                double speed;
                int threads;
            } rows[] = {{"embree/triangles/w4", 8, 1},  {"embree/triangles/w8", 10, 1},
                        {"embree/grid/w8", 90, 1},      {"pyramid80/watertight", 99, 1},
                        {"pyramid8/watertight", 20, 1}, {"pyramid8/watertight/t2", 98, 2}};
            for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
                const double speed = k == 4 && is_odd ? odd * 10 : rows[k].speed;
                snprintf(line, sizeof line,
                         "{\"kind\":\"result\",\"field\":\"%s\",\"rays\":\"%s\",\"contender\":\"%s\","
                         "\"threads\":%d,\"mrays_per_s\":%g}",
                         fields[f], rays[r], rows[k].name, rows[k].threads, speed);
                add_line(text, sizeof text, line);
            }
        }
    }
    write_text(name, text);
}

static void expect_target(const targets_data *d, target_kind kind, double measured, bool met) {
    const target t = target_of(d, 1, kind); /* AVX2 */
    check(fabs(t.measured - measured) <= 1e-9 * measured && target_is_met(&t) == met, "%s: %.12g, %s",
          target_title(kind), t.measured, target_is_met(&t) ? "met" : "missed");
}

static void targets_follow_from_the_files(void **state) {
    (void)state;
    io_error error;
    targets_data d;
    check(!targets_open(&d, ".", &error), "targets of nothing");
    targets_close(&d);
    write_speeds("speed-avx2.json", "4097", "bounce", 4);
    check(targets_open(&d, ".", &error), "%s", error.text);
    expect_target(&d, TARGET_MEAN, 2 * pow(2, 1.0 / 18), false);
    expect_target(&d, TARGET_PRIMARY, 2, true);
    expect_target(&d, TARGET_SHADOW, 2, true);
    expect_target(&d, TARGET_SCATTERED, 2, false); /* the lower one, ao */
    expect_target(&d, TARGET_SCALING, 1, true);
    expect_target(&d, TARGET_MEMORY, 0, false); /* not measured */
    targets_close(&d);
    write_speeds("speed-avx2.json", "65", "shadow", 1.9);
    write_text("building.json",
               "{\"kind\":\"run\",\"command\":\"micro\"}\n"
               "{\"kind\":\"kernel_build\",\"field\":\"1025\",\"kernel\":\"pyramid8\",\"build_seconds\":0.001,"
               "\"bytes\":2000000}\n"
               "{\"kind\":\"peer_build\",\"field\":\"1025\",\"peer\":\"embree/triangles\",\"build_seconds\":0.06}\n"
               "{\"kind\":\"peer_build\",\"field\":\"1025\",\"peer\":\"embree/grid\",\"build_seconds\":0.004}\n"
               "{\"kind\":\"field\",\"field\":\"1025\",\"nx\":1025,\"ny\":1025,\"bytes_samples\":4202500,"
               "\"default_kernel\":\"pyramid8\"}\n");
    write_speeds("threads.json", "", "", 0);
    check(targets_open(&d, ".", &error), "%s", error.text);
    expect_target(&d, TARGET_SHADOW, 1.9, false);
    expect_target(&d, TARGET_MEMORY, 5202500.0 / 1048576, true);
    expect_target(&d, TARGET_BUILD_TRIANGLES, 60, true);
    expect_target(&d, TARGET_BUILD_GRID, 4, false);
    expect_target(&d, TARGET_THREADS, 4.9, true);
    targets_close(&d);
    write_text("page.md", "<!-- begin:targets -->\n<!-- end:targets -->\n");
    check(run(report_main, "--targets . --into page.md --csv t.csv") == 0, "report fails");
    char *page = read_text("page.md"), *csv = read_text("t.csv");
    check(strstr(page, "| ≥ 2 | 1.90 (65) **missed** |") && strstr(page, "| ≤ 7 | 4.96 (1025) |"), "the page is %s",
          page);
    check(strstr(csv, "avx2,,,2,1.9,no,\"65\"") && strstr(csv, "speed,avx2,65,shadow,,1.9,"), "the CSV is %s", csv);
    free(csv);
    free(page);
}

static void pages_keep_what_is_not_between_markers(void **state) {
    (void)state;
    io_error error;
    write_text("page.md", "before\n<!-- begin:table -->\nold\n<!-- end:table -->\nafter");
    for (int again = 0; again < 2; again++) {
        check(report_into("page.md", "table", "new\n", &error), "%s", error.text);
        char *page = read_text("page.md");
        check(strcmp(page, "before\n<!-- begin:table -->\nnew\n<!-- end:table -->\nafter") == 0, "the page is %s",
              page);
        free(page);
    }
    static const char *const bad[] = {"", "nothing", "<!-- begin:table -->", "<!-- end:table --> <!-- begin:table -->",
                                      "<!-- begin:table --><!-- begin:table --><!-- end:table -->"};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        write_text("page.md", bad[k]);
        const size_t entries = scratch_entries();
        check(!report_into("page.md", "table", "new\n", &error) && strstr(error.text, "page.md"), "\"%s\" is a page",
              bad[k]);
        char *page = read_text("page.md");
        check(strcmp(page, bad[k]) == 0 && scratch_entries() == entries, "\"%s\" has become %s", bad[k], page);
        free(page);
    }
}

/* Two sizes, two classes, one contender left out. */
static void write_results(const char *name) {
    static const char *const fields[] = {"65", "257"}, *const rays[] = {"primary", "ao"};
    char text[8192] = "{\"kind\":\"run\",\"command\":\"micro\",\"cpu\":\"Abacus 3000\",\"embree\":\"3.13.5\"}\n";
    for (int f = 0; f < 2; f++) {
        size_t used = strlen(text);
        for (int r = 0; r < 2; r++)
            used += (size_t)snprintf(text + used, sizeof text - used,
                                     "{\"kind\":\"result\",\"field\":\"%s\",\"rays\":\"%s\",\"contender\":"
                                     "\"pyramid8/watertight\",\"mrays_per_s\":%d}\n"
                                     "{\"kind\":\"result\",\"field\":\"%s\",\"rays\":\"%s\",\"contender\":"
                                     "\"embree/triangles/w16-split\",\"left_out_seconds\":9}\n"
                                     "{\"kind\":\"result\",\"field\":\"%s\",\"rays\":\"%s\",\"contender\":"
                                     "\"embree/triangles/w8\",\"mrays_per_s\":7}\n",
                                     fields[f], rays[r], 9 + r, fields[f], rays[r], fields[f], rays[r]);
        snprintf(text + used, sizeof text - used,
                 "{\"kind\":\"field\",\"field\":\"%s\",\"nx\":%s,\"ny\":%s,\"bytes_samples\":16900}\n"
                 "{\"kind\":\"kernel_build\",\"field\":\"%s\",\"kernel\":\"pyramid8\",\"build_seconds\":1e-5,"
                 "\"bytes\":6000}\n"
                 "{\"kind\":\"peer_build\",\"field\":\"%s\",\"peer\":\"embree/triangles\",\"build_seconds\":0.01,"
                 "\"bytes\":700000,\"quality\":\"high\"}\n",
                 fields[f], fields[f], fields[f], fields[f], fields[f]);
    }
    write_text(name, text);
}

static void pictures_repeat(void **state) {
    (void)state;
    if (system("gnuplot --version >gnuplot 2>&1") != 0) skip();
    write_results("m.json");
    check(run(plot_main, "--json m.json --out a") == 0 && run(plot_main, "--json m.json --out it's") == 0,
          "plot fails");
    static const struct {
        const char *name;
        const char *has[4];
    } pictures[] = {
        {"speed-65.svg", {"Abacus 3000", "million rays / s", "pyramid8", "Embree triangles, 8 wide"}},
        {"speed-257.svg", {"257 × 257 samples", "primary", "ao", "Embree triangles, 8 wide"}},
        {"scaling.svg", {"Abacus 3000", "pyramid8", "primary", "Embree, its fastest width"}},
        {"building.svg", {"bytes a cell", "CPU time to build", "pyramid", "Embree triangles, high build quality"}},
    };
    for (size_t k = 0; k < sizeof pictures / sizeof pictures[0]; k++) {
        char one[64], other[64];
        snprintf(one, sizeof one, "a/%s", pictures[k].name);
        snprintf(other, sizeof other, "it's/%s", pictures[k].name);
        char *first = read_text(one), *second = read_text(other);
        check(strcmp(first, second) == 0, "%s differs from itself", pictures[k].name);
        for (size_t h = 0; h < 4; h++)
            check(strstr(first, pictures[k].has[h]) != NULL, "%s does not say %s", one, pictures[k].has[h]);
        check(strstr(first, "(split)") == NULL, "%s draws who was left out", one);
        free(second);
        free(first);
    }
    write_speeds("t.json", "", "", 0);
    check(run(plot_main, "--json t.json --out a") == 0, "plot fails");
    char *threads = read_text("a/threads.svg");
    check(strstr(threads, "pyramid8, 2 threads, 8193") && strstr(threads, "speed over one thread"),
          "threads.svg lacks text");
    free(threads);
    write_text("w.json", "{\"kind\":\"run\",\"command\":\"micro\"}\n"
                         "{\"kind\":\"field\",\"field\":\"65\",\"nx\":65,\"ny\":65}\n"
                         "{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"ao\",\"contender\":\"pyramid1/watertight\","
                         "\"mrays_per_s\":1}\n"
                         "{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"ao\",\"contender\":\"pyramid4/watertight\","
                         "\"mrays_per_s\":3}\n");
    check(run(plot_main, "--json w.json --out a") == 0, "plot fails");
    char *widths = read_text("a/widths.svg");
    check(strstr(widths, "rays at a time") && strstr(widths, "field 65"), "widths.svg lacks text");
    free(widths);
    write_text("s.json", "{\"kind\":\"run\",\"command\":\"table\"}\n"
                         "{\"kind\":\"scene\",\"scene\":\"landsea-big\",\"paths\":[{\"path\":\"auto-phong\","
                         "\"time_to_default\":0.5}]}\n");
    check(run(plot_main, "--json s.json --out a") == 0, "plot fails");
    char *coursework = read_text("a/coursework.svg");
    check(strstr(coursework, "landsea-big") && strstr(coursework, "what the library chooses"),
          "coursework.svg lacks text");
    free(coursework);
    /* One size gives no curve. */
    write_run("one.json", 1, 1);
    check(run(plot_main, "--json one.json --out b") == 1, "a picture of nothing");
}

static void pictures_need_gnuplot(void **state) {
    (void)state;
    write_results("m.json");
    char *path = strdup(getenv("PATH") ? getenv("PATH") : "");
    check(path && setenv("PATH", "nowhere", 1) == 0, "no environment");
    const int status = run(plot_main, "--json m.json --out a");
    check(setenv("PATH", path, 1) == 0, "no environment");
    free(path);
    check(status == 1, "plot without gnuplot ends with %d", status);
    check(rmdir("a") == 0, "plot without gnuplot leaves something behind");
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    static const struct {
        command *of;
        const char *arguments;
        int status;
    } mistakes[] = {
        {micro_main, "--kernel nonesuch", 2},
        {micro_main, "--field 66", 2},
        {micro_main, "--count 0", 2},
        {micro_main, "--count many", 2},
        {micro_main, "--count 1e9", 2},
        {micro_main, "--seconds", 2},
        {micro_main, "--isa mmx", 2},
        {micro_main, "--threads 0", 2},
        {micro_main, "--threads two", 2},
        {micro_main, "--threads 2 --counters", 1},
        {micro_main, "--rays none,ao", 2},
        {micro_main, "--nonesuch", 2},
        {micro_main, "loose", 2},
        {micro_main, "--field 65 --json nowhere/m.json", 1},
        {table_main, "--path nonesuch", 2},
        {table_main, "--scene nonesuch", 2},
        {table_main, "--quick --scene hftest --out file/out", 1},
        {table_main, "--quick --scene hftest --out file", 1},
        {table_main, "--quick --scene hftest --scenes nowhere --out out", 1},
        {report_main, "", 2},
        {report_main, "--json m.json --targets .", 2},
        {report_main, "--json m.json --csv m.csv", 2},
        {report_main, "--targets nowhere", 1},
        {campaign_main, "loose", 2},
        {campaign_main, "--out file/out", 1},
        {parts_main, "--json nowhere/p.json", 1},
        {report_main, "--json nowhere.json", 1},
        {plot_main, "", 2},
        {plot_main, "--json m.json", 2},
        {plot_main, "--json m.json --data . --out out", 2},
        {plot_main, "--data nowhere --out out", 1},
        {plot_main, "--json nowhere.json --out out", 1},
        {compare_main, "one.json", 2},
        {compare_main, "nowhere.json nowhere.json", 1},
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
    command *const commands[] = {micro_main, table_main, compare_main, report_main, plot_main};
    for (size_t k = 0; k < 5; k++) check(run(commands[k], "--help") == 0, "help fails");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(table_files_hold_the_same_numbers, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(micro_against_itself_is_undecided, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(threads_take_part, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pieces_are_timed, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(nothing_but_building, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(comparisons_need_more_than_the_machine, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(results_are_checked, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(targets_follow_from_the_files, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pages_keep_what_is_not_between_markers, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pictures_repeat, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(pictures_need_gnuplot, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(mistakes_leave_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test(helps),
    };
    return cmocka_run_group_tests_name("bench_program", tests, NULL, NULL);
}
