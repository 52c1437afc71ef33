/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench compare: changes between two runs of measure, as far as they exceed the noise. */
#include "measure/compare.h"

#include "commands.h"
#include "harness/results.h"
#include "harness/statistics.h"
#include "options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char what[] =
    "Compares two files of 'cellwalk-bench measure -o' and prints for every common measurement whether B is faster "
    "or slower than A. It is undecided unless the 95 % interval of the ratio of the two medians lies beyond 1 by more "
    "than the margin. The interval covers the noise within a run; the margin covers changes between runs of the same "
    "program, such as another layout of memory. Embree is the control: it is the same in both runs, so its change is "
    "the machine's. A verdict must also hold after dividing by that change.";

static const char examples[] = "  cellwalk-bench measure first -o before.jsonl\n"
                               "  cellwalk-bench measure first -o after.jsonl\n"
                               "  cellwalk-bench compare before.jsonl after.jsonl\n";

static bool same_group(const json_t *a, const json_t *b) { return results_same(a, b, "workload"); }
static bool is_timed(const json_t *line) {
    return results_is(line, "result") && json_object_get(line, "seconds_median");
}
static bool is_control(const json_t *result) { return strncmp(results_text(result, "group"), "embree", 6) == 0; }

/* The same measurement in the other run. */
static const json_t *partner(const json_t *lines, const json_t *of) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_timed(line) && same_group(line, of) && results_same(line, of, "contender") &&
            results_number(line, "items") == results_number(of, "items"))
            return line;
    }
    return NULL;
}

static bool is_sure(const json_t *result) { return json_is_true(json_object_get(result, "interval_sure")); }

static ratio ratio_of(const json_t *a, const json_t *b, double margin) {
    statistics s[2];
    for (int k = 0; k < 2; k++) {
        const json_t *r = k ? b : a;
        s[k] = (statistics){.median = results_number(r, "seconds_median"), .sure = is_sure(r)};
        s[k].low = results_number(r, "seconds_low");
        s[k].high = results_number(r, "seconds_high");
    }
    return statistics_ratio(&s[0], &s[1], margin);
}

/* Runs on different machines or builds can be compared, but the output says so. */
static void tell_differences(const json_t *a, const json_t *b) {
    static const char *const keys[] = {"cpu", "isa", "compiler", "build_type", "flags", "embree", "commit"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (!results_same(a, b, keys[k]))
            printf("%s differs: %s, then %s\n", keys[k], results_text(a, keys[k]), results_text(b, keys[k]));
    if (results_number(a, "seed") != results_number(b, "seed"))
        printf("seed differs: %.0f, then %.0f: these are not the same rays\n", results_number(a, "seed"),
               results_number(b, "seed"));
}

/* How much the machine changed on these rays: from the lowest to the highest ratio that any control allows. */
static ratio control_of(const json_t *in_a, const json_t *in_b, const json_t *of) {
    ratio hull = {.value = 0, .low = 1, .high = 1};
    size_t index;
    const json_t *b;
    json_array_foreach(in_b, index, b) {
        const json_t *a = is_timed(b) && is_control(b) && same_group(b, of) ? partner(in_a, b) : NULL;
        if (a == NULL) continue;
        const ratio r = ratio_of(a, b, 0);
        hull = (ratio){.value = 1,
                       .low = hull.value > 0 ? fmin(hull.low, r.low) : r.low,
                       .high = hull.value > 0 ? fmax(hull.high, r.high) : r.high};
    }
    return hull;
}

/* The verdict on B. */
static const char *verdict_on(const json_t *a, const json_t *b, const ratio *time, const ratio *machine, double margin,
                              compare_counts *counts) {
    const bool faster = time->verdict == VERDICT_LOWER, slower = time->verdict == VERDICT_HIGHER;
    if (is_control(b)) return counts->controls++, "the control";
    if (faster && time->high < (1 - margin) * machine->low) return counts->faster++, "faster";
    if (slower && time->low > (1 + margin) * machine->high) return counts->slower++, "slower";
    counts->undecided++;
    if (faster || slower) return "undecided (the machine changed too)";
    return is_sure(a) && is_sure(b) ? "undecided" : "undecided (too few passes)";
}

static void compare_lines(const json_t *in_a, const json_t *in_b, double margin, compare_counts *counts) {
    printf("%-20s %-24s %10s %10s  %-24s %s\n", "workload", "contender", "A, M/s", "B, M/s", "speed B / A (95 %)",
           "verdict on B");
    size_t index;
    const json_t *b;
    json_array_foreach(in_b, index, b) {
        const json_t *a = is_timed(b) ? partner(in_a, b) : NULL;
        counts->unmatched += is_timed(b) && a == NULL;
        if (a == NULL) continue;
        const ratio time = ratio_of(a, b, margin), machine = control_of(in_a, in_b, b);
        char interval[64];
        snprintf(interval, sizeof interval, "%.3f (%.3f to %.3f)", 1 / time.value, 1 / time.high, 1 / time.low);
        printf("%-20s %-24s %10.3f %10.3f  %-24s %s\n", results_text(b, "workload"), results_text(b, "contender"),
               1e-6 * results_number(a, "per_second"), 1e-6 * results_number(b, "per_second"), interval,
               verdict_on(a, b, &time, &machine, margin, counts));
    }
}

bool compare_files(const char *path_a, const char *path_b, double margin, compare_counts *counts, io_error *error) {
    *counts = (compare_counts){0};
    json_t *a = results_read(path_a, error), *b = a ? results_read(path_b, error) : NULL;
    bool good = a && b;
    if (good) {
        tell_differences(json_array_get(a, 0), json_array_get(b, 0));
        compare_lines(a, b, margin, counts);
        printf("\nB is faster %zu times, slower %zu times, undecided %zu times", counts->faster, counts->slower,
               counts->undecided);
        printf(counts->unmatched ? "; %zu results of B have no partner in A\n" : "\n", counts->unmatched);
    }
    if (good && counts->faster + counts->slower + counts->undecided + counts->controls == 0)
        good = io_fail(error, "%s and %s have no result in common", path_a, path_b);
    json_decref(a);
    json_decref(b);
    return good;
}

static int start(int argc, char **argv) {
    double margin = 0.02;
    const option_spec options[] = {{"margin", "SHARE",
                                    "change, as a share of 1, allowed between two runs of the same program (0.02)",
                                    OPTION_REAL, .to = &margin, .high = 10}};
    static const char *const names[] = {"A.jsonl", "B.jsonl"};
    const options_usage usage = {"compare", "A.jsonl B.jsonl [OPTIONS]", what, examples, options, 1, names, 2, 2};
    const char *files[2];
    const int status = options_parse(&usage, argc, argv, files);
    if (status != OPTIONS_GO) return status;
    compare_counts counts;
    io_error error;
    if (compare_files(files[0], files[1], margin, &counts, &error)) return EXIT_SUCCESS;
    return command_fail("compare", "%s", error.text);
}

const command command_compare = {"compare", "print the differences between two runs of measure", start};
