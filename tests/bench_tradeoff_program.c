/* SPDX-License-Identifier: Apache-2.0 */
/* cellwalk-bench tradeoff from beginning to end, on work so small that its speeds mean nothing: what is saved agrees with
 * itself, sums and verdicts are those of their lines, mistakes are told and leave nothing behind. */
#include "accuracy/tradeoff.h"
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

static const json_t *find(const json_t *lines, const char *kind, const char *key, const char *value) {
    size_t index;
    const json_t *line;
    json_array_foreach(lines, index, line) {
        if (strcmp(results_text(line, "kind"), kind) == 0 && strcmp(results_text(line, key), value) == 0) return line;
    }
    return NULL;
}

static const char *const small =
    "--field 65 --rays random,ao,vertices --mode strict,moller-trumbore,early,samples-16,tolerance-1,"
    "cone-pixel,embree "
    "--kernel cell,grid3d,grid3d-early,pyramid1 --scene hftest --count 4096 --seconds 0.3 "
    "--out a/b";

static void files_agree(void **state) {
    (void)state;
    check(run(small) == 0, "tradeoff fails");
    io_error error;
    json_t *lines = results_read("a/b/tradeoff.json", &error);
    check(lines != NULL, "%s", error.text);

    /* What is known without measuring. */
    const json_t *strict = find(lines, "summary", "contender", "strict/pyramid1");
    const json_t *triangles = find(lines, "summary", "contender", "moller-trumbore/cell");
    check(strict && triangles, "a contender is missing");
    check(results_number(strict, "wrong_answers_per_million") == 0, "strict gives wrong answers");
    check(results_number(strict, "t_ulp_worst") > 0, "strict has no error in t");
    check(results_number(triangles, "aimed_wrong_answers_per_million") > 0, "Möller-Trumbore does not leak");
    check(results_number(strict, "groups") == 3 && !json_is_true(json_object_get(strict, "partial")),
          "a group is missing");
    const json_t *coarse = find(lines, "summary", "contender", "samples-16/pyramid1");
    const json_t *result = find(lines, "result", "contender", "samples-16/pyramid1");
    check(results_number(coarse, "broken_per_million") == 0, "16-bit samples break their claim");
    check(results_number(coarse, "off_cells_worst") > 0.5 * results_number(result, "claim_height") &&
              results_number(coarse, "off_cells_worst") < 1.1 * results_number(result, "claim_height"),
          "16-bit samples are off by %g, and claim %g", results_number(coarse, "off_cells_worst"),
          results_number(result, "claim_height"));
    static const char *const tolerant[] = {"tolerance-1/pyramid1", "cone-pixel/pyramid1"};
    for (size_t k = 0; k < 2; k++) {
        const json_t *near = find(lines, "summary", "contender", tolerant[k]);
        check(near && results_number(near, "broken_per_million") == 0, "%s breaks its claim", tolerant[k]);
        /* On a field as small as this no detail is below a pixel. */
        check(k == 1 || results_number(near, "off_cells_worst") > 10 * results_number(strict, "off_cells_worst"),
              "%s is no less exact than strict", tolerant[k]);
    }
    check(find(lines, "summary", "contender", "tolerance-1/cell") == NULL, "a kernel has a tolerance that ignores it");
    check((find(lines, "summary", "mode", "embree") != NULL) == (peer_embree_version() != NULL), "Embree is missing");
    check(find(lines, "summary", "contender", "moller-trumbore/grid3d-early") == NULL,
          "a mode has a kernel that is another's");

    /* Walks with equal bits share their errors, another leaf test's bits are its own. */
    size_t index, shared = 0;
    const json_t *line;
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

    const json_t *exact = find(lines, "picture", "mode", "strict"),
                 *other = find(lines, "picture", "mode", "samples-16");
    check(exact && results_number(exact, "rmse") == 0 && results_number(exact, "pixels_differ") == 0,
          "strict differs from itself");
    check(other && results_number(other, "pixels_differ") > 0, "16-bit samples change nothing");
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

/* Two groups; one contender that lost a group to time; numbers by hand. */
static void sums_are_of_their_lines(void **state) {
    (void)state;
    static const char *const texts[] = {
        "{\"kind\":\"run\",\"command\":\"tradeoff\",\"rays_a_class\":100}",
        ("{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":\"early/"
         "grid3d-early\","
         "\"mode\":\"early\",\"kernel\":\"grid3d-early\",\"ray_count\":100,\"leaks\":0,\"phantoms\":0,\"wrong\":1,"
         "\"leaks_per_million\":0,\"phantoms_per_million\":0,\"wrong_per_million\":10000,\"mrays_per_s\":2,"
         "\"t_ulp_median\":0.5,\"t_ulp_worst\":2,\"off_cells_median\":1e-6,\"off_cells_worst\":1e-4}"),
        ("{\"kind\":\"result\",\"field\":\"257\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":\"early/"
         "grid3d-early\","
         "\"mode\":\"early\",\"kernel\":\"grid3d-early\",\"ray_count\":50,\"leaks\":1,\"phantoms\":1,\"wrong\":1,"
         "\"leaks_per_million\":20000,\"phantoms_per_million\":20000,\"wrong_per_million\":20000,\"mrays_per_s\":8,"
         "\"t_ulp_median\":1.5,\"t_ulp_worst\":1.75,\"off_cells_median\":1e-6,\"off_cells_worst\":2e-4}"),
        ("{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":"
         "\"moller-trumbore/grid3d\",\"mode\":\"moller-trumbore\",\"kernel\":\"grid3d\",\"ray_count\":100,\"leaks\":0,"
         "\"phantoms\":0,\"wrong\":0,\"leaks_per_million\":0,\"phantoms_per_million\":0,\"wrong_per_million\":0,"
         "\"mrays_per_s\":1,\"off_cells_worst\":1e-5}"),
        ("{\"kind\":\"result\",\"field\":\"257\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":"
         "\"moller-trumbore/grid3d\",\"mode\":\"moller-trumbore\",\"kernel\":\"grid3d\",\"ray_count\":100,\"leaks\":0,"
         "\"phantoms\":0,\"wrong\":0,\"leaks_per_million\":0,\"phantoms_per_million\":0,\"wrong_per_million\":0,"
         "\"mrays_per_s\":4,\"off_cells_worst\":2e-5}"),
        ("{\"kind\":\"result\",\"field\":\"65\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":\"strict/"
         "cell\","
         "\"mode\":\"strict\",\"kernel\":\"cell\",\"ray_count\":100,\"leaks_per_million\":0,\"phantoms_per_million\":0,"
         "\"wrong_per_million\":0,\"mrays_per_s\":99,\"off_cells_worst\":1e-7}"),
        ("{\"kind\":\"result\",\"field\":\"257\",\"rays\":\"random\",\"query\":\"closest\",\"contender\":\"strict/"
         "cell\","
         "\"mode\":\"strict\",\"kernel\":\"cell\",\"left_out_seconds\":9}"),
    };
    json_t *lines = parse(texts, sizeof texts / sizeof texts[0]);
    summary_add(lines);
    const json_t *early = find(lines, "summary", "contender", "early/grid3d-early");
    check(is_near(results_number(early, "mrays_per_s"), 4), "the mean of 2 and 8 is %g",
          results_number(early, "mrays_per_s"));
    check(is_near(results_number(early, "wrong_answers_per_million"), 35000), "the rate is %g",
          results_number(early, "wrong_answers_per_million"));
    check(is_near(results_number(early, "wrong_per_million"), 15000), "the rate is %g",
          results_number(early, "wrong_per_million"));
    check(results_number(early, "t_ulp_median") == 1 && results_number(early, "t_ulp_worst") == 2,
          "the errors are others");
    check(results_number(early, "ray_count") == 150, "%.0f rays", results_number(early, "ray_count"));
    const json_t *left_out = find(lines, "summary", "contender", "strict/cell");
    check(json_is_true(json_object_get(left_out, "partial")) &&
              !json_is_true(json_object_get(left_out, "frontier_answers")),
          "who was left out is on the frontier");
    const json_t *grid = find(lines, "summary", "contender", "moller-trumbore/grid3d");
    check(json_is_true(json_object_get(grid, "frontier_answers")) &&
              json_is_true(json_object_get(early, "frontier_place")),
          "who belongs to a frontier is not on it");
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
        {"--scene nonesuch", 2},
        {"--isa mmx", 2},
        {"--count 0", 2},
        {"--seconds", 2},
        {"--nonesuch", 2},
        {"loose", 2},
        {"--field 65 --rays random --scene none --out file/out", 1},
        {"--field 65 --rays random --scene none --out file", 1},
        {"--field 65 --rays random --count 64 --seconds 0.01 --mode early --kernel cell --scene none --out out", 1},
        {"--field 65 --rays random --count 64 --seconds 0.01 --mode strict --kernel cell --scene hftest --scenes "
         "nowhere "
         "--out out",
         1},
    };
    scratch_write("file", "", 0);
    for (size_t k = 0; k < sizeof mistakes / sizeof mistakes[0]; k++) {
        const int status = run(mistakes[k].arguments);
        check(status == mistakes[k].status, "\"%s\" ends with %d", mistakes[k].arguments, status);
    }
    check(access("out/tradeoff.json", F_OK) != 0, "a failure has left files");
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
    return cmocka_run_group_tests_name("bench_tradeoff_program", tests, NULL, NULL);
}
