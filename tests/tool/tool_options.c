/* SPDX-License-Identifier: Apache-2.0 */
/* Command lines are taken apart as their table says, and mistakes are told with what was probably meant. */

#include "options.h"

#include "check.h"
#include "command.h"
#include "scratch.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *colours(size_t number) {
    static const char *const names[] = {"red", "green", "grey"};
    return number < 3 ? names[number] : NULL;
}

typedef struct settings {
    bool flag;
    const char *text;
    unsigned count;
    double real;
    int name;
    option_again again;
    const char *operands[2];
} settings;

/* What is printed goes to the files out and err. */
static int parse(settings *s, const char *line) {
    *s = (settings){.name = -1};
    const option_spec options[] = {
        {"flag", NULL, "a flag", OPTION_FLAG, .to = &s->flag, .letter = 'f'},
        {"text", "TEXT", "a text", OPTION_TEXT, .to = &s->text, .letter = 't'},
        {"count", "N", "a whole number", OPTION_COUNT, .to = &s->count, .low = 2, .high = 9},
        {"real", "X", "a number", OPTION_REAL, .to = &s->real, .low = -0.5, .high = 1.5},
        {"name", "NAME", "one of these", OPTION_NAME, .to = &s->name, .names = colours},
        {"again", "TEXT", "several of anything", OPTION_AGAIN, .to = &s->again},
    };
    static const char *const operands[] = {"FROM", "TO"};
    const options_usage usage = {.name = "paint",
                                 .synopsis = "FROM [TO] [OPTIONS]",
                                 .what = "Paints.",
                                 .options = options,
                                 .option_count = sizeof options / sizeof options[0],
                                 .operands = operands,
                                 .operand_least = 1,
                                 .operand_most = 2};
    static char copy[512]; /* values point into it */
    char *argv[32];
    int argc = 0;
    snprintf(copy, sizeof copy, "paint %s", line);
    for (char *word = strtok(copy, " "); word; word = strtok(NULL, " ")) argv[argc++] = word;
    fflush(stdout);
    fflush(stderr);
    const int held[2] = {dup(STDOUT_FILENO), dup(STDERR_FILENO)};
    assert_true(held[0] >= 0 && held[1] >= 0 && freopen("out", "w", stdout) && freopen("err", "w", stderr));
    const int status = options_parse(&usage, argc, argv, s->operands);
    fflush(stdout);
    fflush(stderr);
    for (int k = 0; k < 2; k++) {
        assert_true(dup2(held[k], STDOUT_FILENO + k) >= 0);
        close(held[k]);
    }
    return status;
}

static void values_are_taken(void **state) {
    (void)state;
    settings s;
    check(parse(&s, "here --again x --again=") != OPTIONS_GO, "an empty value is taken");
    check(parse(&s, "here -f --text=a=b --count 9 --real -0.5 --name grey --again x,y --again x,y") == OPTIONS_GO,
          "good options are refused");
    check(s.flag && strcmp(s.text, "a=b") == 0 && s.count == 9 && s.real == -0.5 && s.name == 2, "a value is another");
    check(s.again.count == 2 && strcmp(s.again.values[1], "x,y") == 0, "an option given twice is another");
    check(strcmp(s.operands[0], "here") == 0 && s.operands[1] == NULL, "the operands are others");
    check(parse(&s, "-tx -- -f --flag") == OPTIONS_GO && strcmp(s.text, "x") == 0 && !s.flag &&
              strcmp(s.operands[1], "--flag") == 0,
          "-- does not end the options");
}

static void mistakes_are_told(void **state) {
    (void)state;
    static const struct {
        const char *line, *told;
    } cases[] = {
        {"here --cuont 3", "paint: unknown option --cuont; did you mean --count?\nTry '"},
        {"here -x", "unknown option -x\n"},
        {"here --count 1", "--count takes a whole number from 2 to 9, not '1'"},
        {"here --count 10", "--count takes a whole number from 2 to 9, not '10'"},
        {"here --count 3x", "not '3x'"},
        {"here --real 1.6", "--real takes a number from -0.5 to 1.5, not '1.6'"},
        {"here --real nan", "not 'nan'"},
        {"here --name gren", "--name 'gren' is unknown; did you mean green? There are red, green, grey"},
        {"here --name blue", "--name 'blue' is unknown; there are red, green, grey"},
        {"here --text", "--text needs a value: --text TEXT"},
        {"here --flag=1", "--flag takes no value, but got '1'"},
        {"", "FROM is missing"},
        {"here there everywhere", "'everywhere' is one argument too many"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        settings s;
        size_t size;
        check(parse(&s, cases[k].line) == EXIT_USAGE, "\"%s\" is not refused", cases[k].line);
        char *told = scratch_read("err", &size), *printed = scratch_read("out", &size);
        check(strstr(told, cases[k].told) != NULL, "\"%s\" is told as %s", cases[k].line, told);
        check(printed[0] == '\0', "\"%s\" prints %s", cases[k].line, printed);
        free(printed);
        free(told);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(values_are_taken, scratch_enter, scratch_leave),
        cmocka_unit_test_setup_teardown(mistakes_are_told, scratch_enter, scratch_leave),
    };
    return cmocka_run_group_tests_name("tool_options", tests, NULL, NULL);
}
