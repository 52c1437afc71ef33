/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench compare: changes between two runs of measure, as far as they exceed the noise. */

#include "commands.h"
#include "harness/results.h"
#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char what[] =
    "Compares two files of 'cellwalk-bench measure -o' and prints for every common measurement whether B is faster "
    "or slower than A. It is undecided unless the interval of the change lies beyond 1 by more than the margin. Embree "
    "is the control: it is the same in both runs, so where it was measured, its change is the machine's, by which the "
    "others' is divided.";

static const char examples[] = "  cellwalk-bench measure first -o before.jsonl\n"
                               "  cellwalk-bench measure first -o after.jsonl\n"
                               "  cellwalk-bench compare before.jsonl after.jsonl\n";

/* How many times as fast B is. Each end holds with 0.975, so both with 0.95 (Bonferroni). */
typedef struct change {
    double low, middle, high;
    bool sure;
} change;

static bool is_timed(const json_t *line) {
    return results_is(line, "result") && json_object_get(line, "seconds_median");
}
static bool is_control(const json_t *line) { return strncmp(results_text(line, "group"), "embree", 6) == 0; }

static const json_t *partner(const json_t *lines, const json_t *of) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (is_timed(line) && results_same(line, of, "workload") && results_same(line, of, "contender") &&
            results_same(line, of, "isa") && results_number(line, "items") == results_number(of, "items"))
            return line;
    }
    return NULL;
}

static change change_of(const json_t *a, const json_t *b) {
    return (change){.low = results_number(a, "seconds_low") / results_number(b, "seconds_high"),
                    .middle = results_number(a, "seconds_median") / results_number(b, "seconds_median"),
                    .high = results_number(a, "seconds_high") / results_number(b, "seconds_low"),
                    .sure = json_is_true(json_object_get(a, "interval_sure")) &&
                            json_is_true(json_object_get(b, "interval_sure"))};
}

/* The machine's change on this work: that of Embree's fastest width. */
static change control_of(const json_t *in_a, const json_t *in_b, const json_t *of) {
    size_t index;
    const json_t *b;
    json_array_foreach(in_b, index, b) {
        if (!is_timed(b) || !is_control(b) || !results_same(b, of, "workload") || !results_same(b, of, "isa")) continue;
        const json_t *a = json_is_true(json_object_get(b, "best_of_group")) ? partner(in_a, b) : NULL;
        if (a) return change_of(a, b);
    }
    return (change){1, 1, 1, true};
}

/* Prints a line for each result that both files have; how many there were. */
static size_t compare_lines(const json_t *in_a, const json_t *in_b, double margin) {
    size_t index, faster = 0, slower = 0, undecided = 0, controls = 0;
    const json_t *b;
    printf("%-20s %-24s %10s %10s  %-24s %s\n", "workload", "contender", "A, M/s", "B, M/s", "speed B / A (95 %)",
           "verdict on B");
    json_array_foreach(in_b, index, b) {
        const json_t *a = is_timed(b) ? partner(in_a, b) : NULL;
        if (a == NULL) continue;
        const bool control = is_control(b);
        const change c = change_of(a, b), m = control ? (change){1, 1, 1, true} : control_of(in_a, in_b, b);
        const double low = c.low / m.high, high = c.high / m.low;
        const bool sure = c.sure && m.sure && !control;
        const bool up = sure && low > 1 + margin, down = sure && high < 1 / (1 + margin);
        char interval[64];
        snprintf(interval, sizeof interval, "%.3f (%.3f to %.3f)", c.middle / m.middle, low, high);
        printf("%-20s %-24s %10.3f %10.3f  %-24s %s\n", results_text(b, "workload"), results_text(b, "contender"),
               1e-6 * results_number(a, "per_second"), 1e-6 * results_number(b, "per_second"), interval,
               control ? "the control"
               : up    ? "faster"
               : down  ? "slower"
               : !sure ? "undecided (too few passes)"
                       : "undecided");
        faster += up, slower += down, controls += control, undecided += !up && !down && !control;
    }
    printf("\nB is faster %zu times, slower %zu times, undecided %zu times\n", faster, slower, undecided);
    return faster + slower + undecided + controls;
}

static bool compare_files(const char *path_a, const char *path_b, double margin, io_error *error) {
    static const char *const keys[] = {"cpu", "isa", "compiler", "build_type", "flags", "embree", "commit"};
    json_t *a = results_read(path_a, error), *b = a ? results_read(path_b, error) : NULL;
    for (size_t k = 0; b && k < sizeof keys / sizeof keys[0]; k++) {
        const json_t *run_a = json_array_get(a, 0), *run_b = json_array_get(b, 0);
        if (!results_same(run_a, run_b, keys[k]))
            printf("%s differs: %s, then %s\n", keys[k], results_text(run_a, keys[k]), results_text(run_b, keys[k]));
    }
    const bool good =
        b && (compare_lines(a, b, margin) > 0 || io_fail(error, "%s and %s have no result in common", path_a, path_b));
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
    io_error error;
    if (status != OPTIONS_GO) return status;
    return compare_files(files[0], files[1], margin, &error) ? EXIT_SUCCESS : command_fail("compare", "%s", error.text);
}

const command command_compare = {"compare", "print the differences between two runs of measure", start};
