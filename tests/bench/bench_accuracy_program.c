/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench accuracy from beginning to end, on work so small that its speeds mean nothing: what is saved agrees with
 * itself, sums and verdicts are those of their lines, mistakes are told and leave nothing behind. */
#include "accuracy/accuracy.h"
#include "commands.h"
#include "harness/results.h"
#include "peers/embree.h"

#include "check.h"
#include "scratch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ARGUMENTS_MAX = 24 };

static int run(const char *line) {
    char *copy = strdup(line), *arguments[ARGUMENTS_MAX + 1] = {strdup("accuracy")};
    int count = 1;
    assert_non_null(copy);
    for (char *word = strtok(copy, " "); word && count < ARGUMENTS_MAX; word = strtok(NULL, " "))
        arguments[count++] = word;
    arguments[count] = NULL;
    const int status = command_accuracy.run(count, arguments);
    free(arguments[0]);
    free(copy);
    return status;
}

static const json_t *find(const json_t *lines, const char *kind, const char *key, const char *value) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), kind) == 0 && strcmp(results_text(line, key), value) == 0) return line;
    }
    return NULL;
}

static const char *const small = "--field 65 --rays random,ao,vertices --mode strict,moller-trumbore,samples-16,embree "
                                 "--kernel cell,grid3d,pyramid1 --count 4096 --seconds 0.3 "
                                 "--out a/b";

static void files_agree(void **state) {
    (void)state;
    check(run(small) == 0, "accuracy fails");
    io_error error;
    json_t *lines = results_read("a/b/accuracy.json", &error);
    check(lines != NULL, "%s", error.text);

    /* What is known without measuring. */
    const accuracy_sums strict = accuracy_sums_of(lines, "strict/pyramid1");
    const accuracy_sums triangles = accuracy_sums_of(lines, "moller-trumbore/cell");
    check(strict.groups == 3 && triangles.groups == 3, "a group is missing");
    check(strict.rates[0] + strict.rates[1] + strict.rates[2] + strict.aimed == 0, "strict gives wrong answers");
    check(strict.off > 0, "strict has no error");
    check(triangles.aimed > 0, "Möller-Trumbore does not leak");
    const accuracy_sums coarse = accuracy_sums_of(lines, "samples-16/pyramid1");
    const double claim = results_number(find(lines, "result", "contender", "samples-16/pyramid1"), "claim_height");
    check(coarse.groups == 3 && coarse.beyond == 0, "16-bit samples break their claim");
    check(coarse.off > 0.5 * claim && coarse.off < 1.1 * claim, "16-bit samples are off by %g, and claim %g",
          coarse.off, claim);
    check((find(lines, "result", "mode", "embree") != NULL) == (peer_embree_version() != NULL), "Embree is missing");
    check(find(lines, "result", "contender", "moller-trumbore/pyramid1") == NULL,
          "a kernel has a leaf test that it lacks");
    json_t *line;
    size_t index, shared = 0;
    bool has_error = false;
    json_array_foreach(lines, index, line) {
        const bool of_strict = strcmp(results_text(line, "contender"), "strict/pyramid1") == 0;
        has_error = has_error || (of_strict && results_number(line, "t_ulp_worst") > 0);
    }
    check(has_error, "strict has no error in t");

    /* Walks with equal bits share their errors, another leaf test's bits are its own. */
    json_array_foreach(lines, index, line) {
        const char *as = results_text(line, "same_bits_as");
        if (*as == '\0') continue;
        shared++;
        check(strncmp(as, results_text(line, "mode"), strlen(results_text(line, "mode"))) == 0,
              "%s is said to give the bits of %s", results_text(line, "contender"), as);
        check(strcmp(results_text(line, "contender"), "moller-trumbore/grid3d") != 0 ||
                  strcmp(results_text(line, "rays"), "vertices") != 0,
              "grid3d is said to leak like %s", as);
    }
    check(shared >= 9, "only %zu results share their errors",
          shared); /* strict, samples-16, Möller-Trumbore × 3 groups */

    json_decref(lines);
}

static json_t *parse(const char *const *texts, size_t count) {
    json_t *lines = json_array();
    for (size_t k = 0; k < count; k++) {
        json_t *line = json_loads(texts[k], 0, NULL);
        check(line != NULL, "not JSON: %s", texts[k]);
        json_array_append_new(lines, line);
    }
    return lines;
}

static bool is_near(double a, double b) { return fabs(a - b) <= 1e-12 * fabs(b); }

/* Two groups that are timed and one of aimed rays; a contender that lost a group to time; numbers by hand. */
static void sums_are_of_their_lines(void **state) {
    (void)state;
    static const char *const texts[] = {
        "{\"kind\":\"run\",\"command\":\"accuracy\"}",
        "{\"kind\":\"result\",\"rays\":\"random\",\"contender\":\"moller-trumbore/grid3d\",\"leaks_per_million\":0,"
        "\"phantoms_per_million\":0,\"wrong_per_million\":10000,\"broken_per_million\":3,\"mrays_per_s\":2,"
        "\"off_cells_worst\":1e-4}",
        "{\"kind\":\"result\",\"rays\":\"ao\",\"contender\":\"moller-trumbore/grid3d\",\"leaks_per_million\":20000,"
        "\"phantoms_per_million\":40000,\"wrong_per_million\":20000,\"broken_per_million\":6,\"mrays_per_s\":8,"
        "\"off_cells_worst\":2e-4}",
        "{\"kind\":\"result\",\"rays\":\"edges\",\"contender\":\"moller-trumbore/grid3d\",\"leaks_per_million\":1,"
        "\"phantoms_per_million\":2,\"wrong_per_million\":4,\"broken_per_million\":0,\"off_cells_worst\":1e-5}",
        "{\"kind\":\"result\",\"rays\":\"random\",\"contender\":\"strict/cell\",\"leaks_per_million\":0,"
        "\"mrays_per_s\":99,\"off_cells_worst\":1e-7}",
        "{\"kind\":\"result\",\"rays\":\"ao\",\"contender\":\"strict/cell\",\"left_out_seconds\":9}",
    };
    json_t *lines = parse(texts, sizeof texts / sizeof texts[0]);
    const accuracy_sums grid = accuracy_sums_of(lines, "moller-trumbore/grid3d");
    check(grid.groups == 3 && is_near(grid.speed, 4), "the mean of 2 and 8 is %g", grid.speed);
    check(grid.rates[0] == 10000 && grid.rates[1] == 15000 && grid.rates[2] == 20000, "the rates are %g, %g, %g",
          grid.rates[0], grid.rates[1], grid.rates[2]);
    check(grid.aimed == 7 && grid.beyond == 3, "of aimed rays %g are wrong, %g beyond claims", grid.aimed, grid.beyond);
    check(grid.off == 2e-4, "off by %g", grid.off);
    const accuracy_sums strict = accuracy_sums_of(lines, "strict/cell");
    check(strict.groups == 1 && is_near(strict.speed, 99), "who was left out counts as one who ran");
    json_decref(lines);
}

static void mistakes_leave_nothing(void **state) {
    (void)state;
    static const struct {
        const char *arguments;
        int status;
    } mistakes[] = {
        {"--mode nonesuch", 2},
        {"--kernel nonesuch", 2},
        {"--rays nonesuch", 2},
        {"--field 66", 2},
        {"--isa mmx", 2},
        {"--count 0", 2},
        {"--seconds", 2},
        {"--nonesuch", 2},
        {"loose", 2},
        {"--field 65 --rays random --out file/out", 1},
        {"--field 65 --rays random --out file", 1},
        {"--field 65 --rays random --count 64 --seconds 0.01 --mode moller-trumbore --kernel pyramid1 "
         "--out out",
         1},
    };
    scratch_write("file", "", 0);
    for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++) {
        const int status = run(mistakes[k].arguments);
        check(status == mistakes[k].status, "\"%s\" ends with %d", mistakes[k].arguments, status);
    }
    check(access("out/accuracy.json", F_OK) != 0, "a failure has left files");
    check(rmdir("out") == 0, "a failure has left something in its folder");
}

static void helps(void **state) {
    (void)state;
    check(run("--help") == 0, "help fails");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(files_agree, scratch_enter, scratch_leave),
        cmocka_unit_test(sums_are_of_their_lines),
        cmocka_unit_test_setup_teardown(mistakes_leave_nothing, scratch_enter, scratch_leave),
        cmocka_unit_test(helps),
    };
    return cmocka_run_group_tests_name("bench_accuracy_program", tests, NULL, NULL);
}
