/* SPDX-License-Identifier: Apache-2.0 */
#include "compare.h"

#include "options.h"
#include "results.h"
#include "statistics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const usage =
    "Usage: cellwalk-bench compare [OPTIONS] A.json B.json\n"
    "\n"
    "Says for every measurement that both runs of 'cellwalk-bench micro --json' have whether B is faster or slower "
    "than A:\n"
    "only if the 95 % interval of the ratio of the two medians lies beyond 1 by more than the margin, else it is\n"
    "undecided. The interval knows the noise within a run; the margin stands for what changes between runs of one and\n"
    "the same program, where memory is laid out anew. Embree is the control: it is the same in both runs, so what it\n"
    "gained or lost is the machine's doing, and a verdict must hold after dividing by that as well.\n"
    "\n"
    "Options:\n";

/* What makes two results comparable. */
static bool same_subject(const json_t *a, const json_t *b) {
    static const char *const keys[] = {"kind", "field", "rays", "contender"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if (strcmp(results_text(a, keys[k]), results_text(b, keys[k])) != 0) return false;
    return results_number(a, "ray_count") == results_number(b, "ray_count");
}

static statistics timing_of(const json_t *result) {
    return (statistics){.n = (size_t)results_number(result, "samples"),
                        .min = results_number(result, "seconds_min"),
                        .median = results_number(result, "seconds_median"),
                        .mad = results_number(result, "seconds_mad"),
                        .low = results_number(result, "seconds_low"),
                        .high = results_number(result, "seconds_high"),
                        .sure = json_is_true(json_object_get(result, "interval_sure"))};
}

static bool is_timed(const json_t *line) {
    return strcmp(results_text(line, "kind"), "result") == 0 && json_object_get(line, "seconds_median");
}

static const json_t *partner(const json_t *lines, const json_t *of) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_timed(line) && same_subject(line, of)) return line;
    }
    return NULL;
}

/* Runs on different ground can be compared, but whoever reads must know. */
static void tell_differences(const json_t *a, const json_t *b) {
    static const char *const keys[] = {"cpu", "isa", "compiler", "build_type", "flags", "embree", "commit"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
        const char *in_a = results_text(a, keys[k]), *in_b = results_text(b, keys[k]);
        if (strcmp(in_a, in_b) != 0) printf("%s differs: %s, then %s\n", keys[k], in_a, in_b);
    }
    if (results_number(a, "seed") != results_number(b, "seed"))
        printf("seed differs: %.0f, then %.0f: these are not the same rays\n", results_number(a, "seed"),
               results_number(b, "seed"));
}

static bool is_control(const json_t *result) { return strncmp(results_text(result, "contender"), "embree/", 7) == 0; }

static bool same_group(const json_t *a, const json_t *b) {
    return strcmp(results_text(a, "field"), results_text(b, "field")) == 0 &&
           strcmp(results_text(a, "rays"), results_text(b, "rays")) == 0;
}

/* How much the machine changed on these rays: from the lowest to the highest ratio that any control allows. */
static ratio control_of(const json_t *in_a, const json_t *in_b, const json_t *of) {
    ratio hull = {.value = 1, .low = 1, .high = 1};
    bool first = true;
    size_t index;
    const json_t *b;
    json_array_foreach(in_b, index, b) {
        if (!is_timed(b) || !is_control(b) || !same_group(b, of)) continue;
        const json_t *a = partner(in_a, b);
        if (a == NULL) continue;
        const statistics time_a = timing_of(a), time_b = timing_of(b);
        const ratio r = statistics_ratio(&time_a, &time_b, 0);
        hull.low = first || r.low < hull.low ? r.low : hull.low;
        hull.high = first || r.high > hull.high ? r.high : hull.high;
        first = false;
    }
    return hull;
}

static void compare_lines(const json_t *in_a, const json_t *in_b, double margin, compare_counts *counts) {
    printf("%-10s %-8s %-30s %9s %9s  %-24s %s\n", "field", "rays", "contender", "A Mrays/s", "B Mrays/s",
           "speed B / A (95 %)", "verdict on B");
    size_t index;
    const json_t *b;
    json_array_foreach(in_b, index, b) {
        if (!is_timed(b)) continue;
        const json_t *a = partner(in_a, b);
        if (a == NULL) {
            counts->unmatched++;
            continue;
        }
        const statistics time_a = timing_of(a), time_b = timing_of(b);
        const ratio time = statistics_ratio(&time_a, &time_b, margin);
        const char *words = "undecided";
        if (!time_a.sure || !time_b.sure) words = "undecided (too few passes)";
        if (is_control(b)) {
            words = "the control";
            counts->controls++;
        } else {
            const ratio machine = control_of(in_a, in_b, b);
            const bool faster = time.verdict == VERDICT_LOWER, slower = time.verdict == VERDICT_HIGHER;
            if (faster && time.high < (1 - margin) * machine.low) {
                words = "faster";
                counts->faster++;
            } else if (slower && time.low > (1 + margin) * machine.high) {
                words = "slower";
                counts->slower++;
            } else {
                counts->undecided++;
                if (faster || slower) words = "undecided (the machine changed too)";
            }
        }
        char interval[64];
        snprintf(interval, sizeof interval, "%.3f (%.3f to %.3f)", 1 / time.value, 1 / time.high, 1 / time.low);
        printf("%-10s %-8s %-30s %9.3f %9.3f  %-24s %s\n", results_text(b, "field"), results_text(b, "rays"),
               results_text(b, "contender"), results_number(a, "mrays_per_s"), results_number(b, "mrays_per_s"),
               interval, words);
    }
}

bool compare_files(const char *path_a, const char *path_b, double margin, compare_counts *counts, io_error *error) {
    *counts = (compare_counts){0};
    json_t *a = results_read(path_a, error);
    json_t *b = a ? results_read(path_b, error) : NULL;
    if (a && b) {
        tell_differences(json_array_get(a, 0), json_array_get(b, 0));
        compare_lines(a, b, margin, counts);
        printf("\nB is faster %zu times, slower %zu times, undecided %zu times", counts->faster, counts->slower,
               counts->undecided);
        printf(counts->unmatched ? "; %zu results of B have no partner in A\n" : "\n", counts->unmatched);
    }
    bool good = a && b;
    if (good && counts->faster + counts->slower + counts->undecided + counts->controls == 0)
        good = io_fail(error, "%s and %s have no result in common", path_a, path_b);
    json_decref(a);
    json_decref(b);
    return good;
}

int compare_main(char **arguments, int count) {
    double margin = 0.02;
    const option options[] = {
        {"--margin", "SHARE", "what may change between two runs of the same program (0.02)", OPTION_REAL, &margin, 0,
         10},
    };
    const option_frame frame = {.command = "compare",
                                .usage = usage,
                                .options = options,
                                .option_count = sizeof options / sizeof options[0],
                                .loose = 2,
                                .loose_what = "files of results"};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    compare_counts counts;
    io_error error;
    if (compare_files(arguments[0], arguments[1], margin, &counts, &error)) return EXIT_SUCCESS;
    return options_failed("compare", &error);
}
