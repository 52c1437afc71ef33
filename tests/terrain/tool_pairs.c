/* SPDX-License-Identifier: Apache-2.0 */
/* `cellwalk los` with a table of pairs and with profiles. */

#include "program.h"
#include "refused.h"
#include "tool_files.h"

#include <math.h>
#include <signal.h>

enum { NX = 60, NY = 50 };

static void text_file(const char *name, const char *text) { scratch_write(name, text, strlen(text)); }

/* A wall of 40 m along row 20, y = 290, on level ground with a hole at x = 300, y = 250. */
static int enter(void **state) {
    signal(SIGXFSZ, SIG_IGN);
    if (scratch_enter(state) != 0) return -1;
    static float z[NX * NY];
    for (size_t k = 0; k < NX * NY; k++) z[k] = k / NX == 20 ? 40 : k == 24 * NX + 30 ? NAN : 0;
    field_file("wall.npy", z, NX, NY);
    return 0;
}

static const program_result *run_well(program_arguments arguments) {
    const program_result *r = program_run(NULL, arguments);
    check(r->status == 0 && r->err[0] == '\0', "exit status %d: %s", r->status, r->err);
    return r;
}

#define LOS "los", "wall.npy", "--cellsize", "10", "--curvature", "0"

/* Each row is answered as the two places alone are. */
static void pairs(void **state) {
    (void)state;
    static const char *const ends[][2] = {
        {"200,190,2", "200,390,=30"}, {"200,190,2", "200,390,85"}, {"10,20,0", "333.3,401.5,1"}, {"5,5,=3", "580,5,3"}};
    text_file("p.csv", "x1,y1,height1,height2,x2,y2\n200,190,2,=30,200,390\n200,190,2,85,200,390\n"
                       "10,20,,1,333.3,401.5\n5,5,=3,3,580,5\n");
    run_well((const char *const[]){LOS, "--pairs", "p.csv", "-o", "a.csv", NULL});
    size_t size;
    char *answers = scratch_read("a.csv", &size), *line = answers;
    static const char head[] =
        "pair,x1,y1,x2,y2,visible,distance,blocked_distance,blocked_x,blocked_y,blocked_height\n";
    check(strncmp(answers, head, sizeof head - 1) == 0, "%s", answers);
    for (int k = 0; k < 4; k++) {
        line = strchr(line, '\n') + 1;
        const program_result *r = run_well((const char *const[]){LOS, "--json", ends[k][0], ends[k][1], NULL});
        double length, x, y, z, block, got[9];
        int number, visible;
        const bool blocked = strstr(r->out, "false") != NULL;
        const int count = sscanf(line, "%d,%lf,%lf,%lf,%lf,%d,%lf,%lf,%lf,%lf,%lf", &number, &got[0], &got[1], &got[2],
                                 &got[3], &visible, &got[4], &got[5], &got[6], &got[7], &got[8]);
        check(count == (blocked ? 11 : 7) && number == k + 1 && visible == !blocked, "%s", line);
        static const char says[] = "{\"visible\": false, \"distance\": %lf, \"blocked_at\": [%lf, %lf], "
                                   "\"blocked_height\": %lf, \"blocked_distance\": %lf}";
        if (blocked) {
            assert_int_equal(sscanf(r->out, says, &length, &x, &y, &z, &block), 5);
            check(fabs(got[5] - block) < 6e-4 && fabs(got[6] - x) < 1e-6 && fabs(got[7] - y) < 1e-6 &&
                      fabs(got[8] - z) < 6e-4,
                  "%s, not %s", line, r->out);
        } else {
            assert_int_equal(sscanf(r->out, "{\"visible\": true, \"distance\": %lf", &length), 1);
        }
        check(fabs(got[4] - length) < 6e-4, "%s, not %s", line, r->out);
    }
    /* To standard output the same. */
    const program_result *r = run_well((const char *const[]){LOS, "--pairs", "p.csv", NULL});
    assert_string_equal(r->out, answers);
    free(answers);
}

/* Over level ground, up and down the wall, and into its shadow: heights are known at every crossing. */
static void profile_over_a_wall(void **state) {
    (void)state;
    const program_result *r =
        run_well((const char *const[]){LOS, "200,190,2", "200,390,=30", "--profile", "p.csv", NULL});
    assert_true(strncmp(r->out, "blocked: ", 9) == 0);
    size_t size;
    char *text = scratch_read("p.csv", &size), *row = strchr(text, '\n') + 1;
    assert_true(strncmp(text, "pair,distance,x,y,ground,line,seen\n", 35) == 0);
    for (int k = 0; k <= 20; k++, row = strchr(row, '\n') + 1) {
        char wanted[100];
        snprintf(wanted, sizeof wanted, "1,%.3f,200,%d,%.3f,%.3f,%d\n", 10.0 * k, 190 + 10 * k, k == 10 ? 40.0 : 0.0,
                 2 + 1.4 * k, k <= 10);
        check(strncmp(row, wanted, strlen(wanted)) == 0, "%.60s instead of %s", row, wanted);
    }
    check(*row == '\0', "more: %s", row);
    free(text);
    /* Between two rows: columns and diagonals in turn. On a row: a hole has no ground. */
    text_file("l.csv", "x1,y1,x2,y2,height2\n100,255,500,255,3\n280,250,320,250,3\n");
    r = run_well((const char *const[]){LOS, "--pairs", "l.csv", "--profile", "p.csv", NULL});
    text = scratch_read("p.csv", &size);
    static const char hole[] =
        "\n2,0.000,280,250,0.000,0.000,1\n2,10.000,290,250,0.000,0.750,1\n2,20.000,300,250,,1.500,\n"
        "2,30.000,310,250,0.000,2.250,0\n2,40.000,320,250,0.000,3.000,0\n";
    check(strstr(text, hole) != NULL, "%s", text);
    size_t rows = 0;
    for (char *c = text; *c; c++) rows += *c == '\n';
    assert_int_equal(rows, 1 + 81 + 5); /* every 10 m a column, halfway between a diagonal */
    free(text);
}

/* Rows are as long as their numbers: metres of 151 digits. */
static void long_rows(void **state) {
    (void)state;
    text_file("p.csv", "x1,y1,x2,y2,height1,height2\n2e150,1e150,2e150,40e150,5,1\n");
    run_well((const char *const[]){"los", "wall.npy", "--cellsize", "1e150", "--pairs", "p.csv", "-o", "a.csv",
                                   "--profile", "b.csv", NULL});
    for (int k = 0; k < 2; k++) {
        size_t size, commas = 0, rows = 0, digits = 0;
        char *text = scratch_read(k ? "b.csv" : "a.csv", &size);
        for (size_t n = 0; n < size; n++) {
            commas += text[n] == ',';
            rows += text[n] == '\n';
            digits += text[n] >= '0' && text[n] <= '9';
            check(text[n] == '\n' || (text[n] >= ' ' && text[n] <= '~'), "character %d is none of a table", text[n]);
        }
        assert_int_equal(commas, (k ? 6 : 10) * rows);
        check(rows == (k ? 41 : 2) && digits > 150 * (rows - 1), "%zu digits in %zu rows", digits, rows);
        free(text);
    }
}

static void what_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *why;
    } tables[] = {
        {"x1,y1,x2\n1,2,3\n", "p.csv: has no column 'y2'; its first line names x1, y1, x2"},
        {"x1,y1,x2,y2\n", "p.csv: holds no pairs"},
        {"x1,y1,x2,y2\n1,2,3,4\n1,2,b,4\n", "p.csv:3: 'b' stands where a number should, in x2"},
        {"x1,y1,x2,y2\n1,2,3,4\n1,2,3,999\n", "p.csv:3: 3,999,0: lies outside"},
        {"x1,y1,height1,x2,y2\n1,2,low,3,4\n", "p.csv:2: 'low' stands where a height"},
        {"x1;y1;x2;y2\n1;2;3;4\n", "p.csv:1: cells are separated by semicolons"},
    };
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++) {
        text_file("p.csv", tables[k].text);
        check_refused((const char *const[]){LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv", NULL}, 1,
                      tables[k].why);
    }
    text_file("p.csv", "x1,y1,x2,y2\n1,2,3,4\n");
    check_refused((const char *const[]){LOS, "--pairs", "p.csv", "-o", "./p.csv", NULL}, 1, "p.csv");
    static const struct {
        const char *more[5], *why;
    } cases[] = {
        {{"--pairs", "p.csv", "1,2", "3,4"}, "do not go together"},
        {{NULL}, "FROM is missing, or --pairs FILE"},
        {{"1,2"}, "TO is missing, or --pairs FILE"},
        {{"1,2", "3,4", "-o", "a.csv"}, "-o goes with --pairs"},
        {{"--pairs", "p.csv", "--json"}, "--json goes with two places"},
        {{"--pairs", "p.csv", "--profile", "-"}, "--profile needs a file that nothing else is written to"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const char *arguments[16] = {LOS};
        for (size_t n = 0; n < 5 && cases[k].more[n]; n++) arguments[6 + n] = cases[k].more[n];
        check_refused(arguments, 2, cases[k].why);
    }
}

/* So many pairs that they take a while: the disk is full, and Ctrl-C. */
static void endings(void **state) {
    (void)state;
    enum { PAIRS = 200000 };
    char *text = malloc(PAIRS * 16 + 30);
    assert_non_null(text);
    size_t used = (size_t)sprintf(text, "x1,y1,x2,y2\n");
    for (int k = 0; k < PAIRS; k++) used += (size_t)sprintf(text + used, "0,0,%d,400\n", k % 590);
    scratch_write("p.csv", text, used);
    free(text);
    const size_t entries = scratch_entries();
    static const char *const run[] = {LOS, "--pairs", "p.csv", "-o", "a.csv", "--profile", "b.csv", NULL};
    const program_setting little = {.file_size_limit = 1000000};
    const program_result *r = program_run(&little, run);
    check(r->status == EXIT_FAILURE && strstr(r->err, "b.csv: cannot write: File too large"), "%d: %s", r->status,
          r->err);
    assert_int_equal(scratch_entries(), entries);
    check_interrupted(run, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(pairs, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(profile_over_a_wall, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(long_rows, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(what_is_refused, enter, scratch_leave),
        cmocka_unit_test_setup_teardown(endings, enter, scratch_leave),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
