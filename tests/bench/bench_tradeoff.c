/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench tradeoff from beginning to end on small land: promises hold, errors are those of choices that are known to have
 * some or none, mistakes leave nothing behind. */
#include "commands.h"
#include "harness/results.h"
#include "tradeoff/tradeoff.h"

#include "check.h"
#include "scratch.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 24 };

static int run(const char *line) {
    char *copy = strdup(line), *arguments[ARGUMENTS_MAX + 1] = {strdup("tradeoff")};
    int count = 1;
    assert_non_null(copy);
    for (char *word = strtok(copy, " "); word && count < ARGUMENTS_MAX; word = strtok(NULL, " "))
        arguments[count++] = word;
    arguments[count] = NULL;
    const int status = command_tradeoff.run(count, arguments);
    free(arguments[0]);
    free(copy);
    return status;
}

typedef enum part { RAYS, HORIZONS, SKY, PICTURES, PARTS } part;

static void promises_and_errors(void **state) {
    (void)state;
    static const char *const names[PARTS] = {"rays", "horizons", "sky", "pictures"};
    char words[100] = "--quick --seconds 0.1 --out a/b --part ";
    bool taken[PARTS];
    for (size_t k = 0; k < PARTS; k++) {
        taken[k] = test_takes(k, PARTS);
        if (taken[k]) snprintf(words + strlen(words), 20, "%s,", names[k]);
    }
    words[strlen(words) - 1] = '\0';
    check(run(words) == 0, "tradeoff fails");
    io_error error;
    json_t *lines = results_read("a/b/tradeoff.json", &error), *line;
    check(lines != NULL, "%s", error.text);
    size_t index, surfaces = 0, grids = 0;
    double strict = 1, coarser = 0, few = 0, many = 0, noisy = 0, smooth = 0, near = 0;
    json_array_foreach(lines, index, line) {
        const char *method = results_text(line, "method"), *who = results_text(line, "contender");
        const double directions = results_number(line, "directions"), factor = results_number(line, "factor");
        if (results_is(line, "coarser")) {
            const double got = fmax(results_number(line, "got_above"), results_number(line, "got_below"));
            const double asked = fmax(results_number(line, "above"), results_number(line, "below"));
            /* All samples were looked at, and no surface differs more from another than at one of them. */
            check(got <= asked && got > (1 - 1e-9) * asked, "%g is promised, and %g found", asked, got);
            surfaces++;
        }
        if (strcmp(who, "strict") == 0) strict = results_number(line, "t_worst");
        if (strcmp(who, "coarser") == 0 && factor == 2) coarser = results_number(line, "t_median");
        if (results_is(line, "horizon") && strcmp(method, "grid") == 0 && directions == 8) {
            grids++;
            check(results_number(line, "degrees_worst") < 2e-5, "the grid's angles are off");
        }
        if (strcmp(method, "max-distance") == 0 && results_is(line, "horizon"))
            near = results_number(line, "degrees_worst");
        if (results_is(line, "sky") && strcmp(method, "exact") == 0) {
            if (directions == 4) few = results_number(line, "share_rms");
            if (directions == 32) many = results_number(line, "share_rms");
        }
        if (results_is(line, "picture") && factor == 1) {
            if (results_number(line, "samples_a_pixel") == 1) noisy = results_number(line, "rmse");
            if (results_number(line, "samples_a_pixel") == 4) smooth = results_number(line, "rmse");
        }
    }
    check(!taken[RAYS] || surfaces == 12, "%zu surfaces", surfaces);
    check(!taken[RAYS] || strict < 0x1p-23, "strict hits are off by %g", strict);
    check(!taken[RAYS] || (coarser > 1e-4 && coarser < 0.04), "coarser hits are off by %g", coarser);
    check(!taken[HORIZONS] || (grids >= 1 && near > 0.1), "horizons are missing, or near ones are exact");
    check(!taken[SKY] || (many > 0 && few > 8 * many), "4 directions are off by %g, 32 by %g", few, many);
    check(!taken[PICTURES] || (smooth > 0 && noisy > 2 * smooth), "a sample a pixel is off by %g, 4 by %g", noisy,
          smooth);
    json_decref(lines);
}

static void spreads(void **state) {
    (void)state;
    double errors[101];
    for (int k = 0; k <= 100; k++) errors[k] = (k * 37) % 101;
    const tradeoff_spread s = tradeoff_spread_of(errors, 101);
    check(s.mean == 50 && s.median == 50 && s.most == 99 && s.worst == 100, "%g %g %g %g", s.mean, s.median, s.most,
          s.worst);
    check(fabs(s.rms - sqrt(3350)) < 1e-12, "RMS %g", s.rms);
    check(tradeoff_spread_of(errors, 0).worst == 0, "nothing is off");
}

static void between_samples(void **state) {
    (void)state;
    const float z[9] = {0, 1, 2, 10, 11, 12, 20, 21, 22};
    for (size_t j = 0; j <= 8; j++)
        for (size_t i = 0; i <= 8; i++)
            check(tradeoff_between(z, 3, 3, 4, i, j) == 0.25 * (double)i + 2.5 * (double)j, "at (%zu, %zu)", i, j);
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    static const struct {
        const char *arguments;
        int status;
    } mistakes[] = {{"--part nonesuch", 2},   {"--land 66", 2}, {"--count 0", 2},
                    {"--seconds", 2},         {"loose", 2},     {"--quick --part rays --out file/out", 1},
                    {"--quick --out file", 1}};
    scratch_write("file", "", 0);
    for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++) {
        const int status = run(mistakes[k].arguments);
        check(status == mistakes[k].status, "\"%s\" ends with %d", mistakes[k].arguments, status);
    }
    check(run("--help") == 0, "help fails");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(promises_and_errors, scratch_enter, scratch_leave),
        cmocka_unit_test(spreads),
        cmocka_unit_test(between_samples),
        cmocka_unit_test_setup_teardown(mistakes_leave_nothing, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests_name("bench_tradeoff", tests, NULL, NULL);
}
