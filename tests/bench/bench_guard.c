/* SPDX-License-Identifier: Apache-2.0 */
/* The guard's arithmetic on profiles and figures made up here: what counts, what does not, and which changes it tells. */
#include "instructions/figures.h"

#include "check.h"
#include "scratch.h"

#include <string.h>

/* Two runs and one that the machine cannot do, as the workload prints them and callgrind counts them. */
static const char *const runs =
    "run,cell,watertight,1025,random,2048\nabsent,packet16,avx512\nrun,brute,moller-trumbore,65,ao,16\n";
static const char *const profile =
    "# callgrind format\nevents: Ir\nsummary: 99\n\n"
    "part: 1\npositions: line\nevents: Ir\nsummary: 9999\n\n"
    "ob=/usr/lib/libm.so.6\nfl=???\nfn=floorf\n0 500\n\n"
    "ob=/somewhere/work\nfl=???\nfn=guard_trace\n0 10\ncob=/usr/lib/libm.so.6\ncfn=floorf\ncalls=7 0 \n0 500\n"
    "cfn=cw_closest\ncalls=1 0 \n0 90\n\nfn=cw_closest\n12 50\n13 40\n\ntotals: 600\n"
    "part: 2\nsummary: 5\nfn=nobody's\n0 1\nob=/somewhere/work\nfn=cw_occluded\n0 1000\ntotals: 5\n"
    "part: 3\nob=/somewhere/work\nfn=main\n0 7\n";

static void write_text(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

static void counts_are_the_programs_own(void **state) {
    (void)state;
    static counted figures;
    io_error error;
    write_text("runs", runs);
    write_text("profile", profile);
    check(callgrind_read(&figures, "runs", "profile", "work", &error), "%s", error.text);
    check(figures.count == 3, "%zu figures", figures.count);
    check(figures.runs[0].events[IR] == 100, "%zu instructions", (size_t)figures.runs[0].events[IR]);
    check(figures.runs[1].events[IR] == 0 && figures.runs[1].count == 0, "absent kernels have counts");
    check(figures.runs[2].events[IR] == 1000, "%zu instructions", (size_t)figures.runs[2].events[IR]);

    check(!callgrind_read(&figures, "runs", "profile", "other", &error) && strstr(error.text, "profile"),
          "a program that is not in the profile has counts");
    write_text("runs", "run,cell,watertight,65,random,2048\nrun,cell,watertight\n");
    check(!callgrind_read(&figures, "runs", "profile", "work", &error) && strncmp(error.text, "runs:2:", 7) == 0,
          "half a line is told as %s", error.text);
    check(!callgrind_read(&figures, "nowhere", "profile", "work", &error) && strstr(error.text, "nowhere"), "no file");
}

static guard_figures *new_figures(void) {
    guard_figures *f = calloc(1, sizeof *f);
    check(f != NULL, "out of memory");
    snprintf(f->compiler, sizeof f->compiler, "GNU 12.2.0");
    snprintf(f->flags, sizeof f->flags, "-std=c17 -O3");
    return f;
}

static void add(guard_figures *to, const char *kernel, uint64_t count, uint64_t instructions) {
    counted_run *f = &to->all.runs[to->all.count++];
    *f = (counted_run){.count = count, .events = {instructions}};
    snprintf(f->kernel, sizeof f->kernel, "%s", kernel);
    if (count == 0) return;
    snprintf(f->leaf, sizeof f->leaf, "watertight");
    snprintf(f->field, sizeof f->field, "65");
    snprintf(f->rays, sizeof f->rays, "random");
}

static void files_keep_figures(void **state) {
    (void)state;
    guard_figures *out = new_figures(), *in = new_figures();
    add(out, "cell", 2048, UINT64_C(123456789012));
    add(out, "packet16", 0, 0);
    add(out, "brute", 16, 1);
    io_error error;
    io_output file;
    check(io_output_open(&file, "f.csv", &error) && guard_write(out, &file, &error) && io_output_commit(&file, &error),
          "%s", error.text);
    check(guard_read(in, "f.csv", &error), "%s", error.text);
    check(strcmp(in->compiler, out->compiler) == 0 && strcmp(in->flags, out->flags) == 0, "built by %s with %s",
          in->compiler, in->flags);
    check(in->all.count == 2 && in->all.runs[0].events[IR] == out->all.runs[0].events[IR] &&
              in->all.runs[1].count == 16,
          "%zu figures, the first %zu", in->all.count, (size_t)in->all.runs[0].events[IR]);
    static const char *const bad[] = {"cell,watertight,65,random,2048\n", "cell,watertight,65,random,2048,-3\n",
                                      "cell,watertight,65,random,2048,0\n", "cell,watertight,65,random,2048,7,8\n",
                                      "\n"};
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        write_text("bad.csv", bad[k]);
        check(!guard_read(in, "bad.csv", &error) && strncmp(error.text, "bad.csv:1:", 10) == 0, "\"%s\" is a figure",
              bad[k]);
    }
    free(in);
    free(out);
}

/* The report on one figure of 100000 instructions that has become so many. */
static guard_verdict verdict_on(uint64_t now, char *report, size_t size) {
    guard_figures *committed = new_figures(), *fresh = new_figures();
    add(committed, "cell", 2048, 100000);
    add(fresh, "cell", 2048, now);
    FILE *file = fmemopen(report, size, "w");
    check(file != NULL, "no stream");
    const guard_verdict v = guard_compare(&committed->all, &fresh->all, file);
    fclose(file);
    free(fresh);
    free(committed);
    return v;
}

static void changes_beyond_the_tolerance_are_told(void **state) {
    (void)state;
    char report[512] = "";
    guard_verdict v = verdict_on(102000, report, sizeof report);
    check(v.compared == 1 && v.above == 0 && v.below == 0 && report[0] == '\0', "2 %% more is told: %s", report);
    v = verdict_on(98000, report, sizeof report);
    check(v.above == 0 && v.below == 0 && report[0] == '\0', "2 %% less is told: %s", report);
    v = verdict_on(97999, report, sizeof report);
    check(v.above == 0 && v.below == 1, "2.001 %% less is not told");
    v = verdict_on(102001, report, sizeof report);
    check(v.above == 1 && v.below == 0, "2.001 %% more is not told");
    static const char *const parts[] = {"cell", "watertight", "random", "102001", "100000", "102000"};
    for (size_t k = 0; k < sizeof parts / sizeof parts[0]; k++)
        check(strstr(report, parts[k]) != NULL, "no %s in: %s", parts[k], report);
}

static void figures_and_kernels_must_match(void **state) {
    (void)state;
    guard_figures *committed = new_figures(), *fresh = new_figures();
    add(committed, "gone", 2048, 1000);
    add(committed, "packet16", 2048, 1000);
    add(committed, "cell", 1024, 1000);
    add(committed, "moved", 2048, 1000);
    add(fresh, "moved", 2048, 1000);
    snprintf(fresh->all.runs[0].field, sizeof fresh->all.runs[0].field, "1025");
    add(fresh, "cell", 2048, 1000);
    add(fresh, "new", 2048, 1000);
    add(fresh, "packet16", 0, 0);
    char report[1024] = "";
    FILE *file = fmemopen(report, sizeof report, "w");
    check(file != NULL, "no stream");
    const guard_verdict v = guard_compare(&committed->all, &fresh->all, file);
    fclose(file);
    check(v.stale == 2 && strstr(report, "field 65") != NULL && strstr(report, "gone") != NULL, "%zu stale: %s",
          v.stale, report);
    check(v.absent == 1 && strstr(report, "packet16") == NULL, "%zu absent: %s", v.absent, report);
    check(v.missing == 3 && strstr(report, "field 1025") != NULL && v.compared == 0, "%zu missing, %zu compared: %s",
          v.missing, v.compared, report);
    free(fresh);
    free(committed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(counts_are_the_programs_own, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(files_keep_figures, scratch_enter, scratch_leave),
        cmocka_unit_test(changes_beyond_the_tolerance_are_told),
        cmocka_unit_test(figures_and_kernels_must_match),
    };
    return cmocka_run_group_tests_name("bench_guard", tests, NULL, NULL);
}
