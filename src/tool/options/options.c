/* SPDX-License-Identifier: Apache-2.0 */
/* Not getopt_long: it completes abbreviated names, so that a script breaks when an option is added, and its messages
 * name neither value nor remedy. */

#include "options.h"

#include "command.h"
#include "number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAMES_MAX = 64 };

const char *option_kernel_names(size_t number) {
    return number < cw_kernel_count() ? cw_kernel_describe(cw_kernel_at(number)).name : NULL;
}
const char *option_isa_names(size_t number) { return cw_isa_name(CW_ISA_SCALAR + (cw_isa)number); }
const char *option_leaf_names(size_t number) { return number < CW_LEAF_COUNT ? cw_leaf_name((cw_leaf)number) : NULL; }

/* The number of the name that equals value; -1 after a message that begins with what. */
static int number_of(const char *name, const char *what, const char *value, option_names *of) {
    const char *names[NAMES_MAX];
    size_t count = 0;
    for (; count < NAMES_MAX && (names[count] = of(count)) != NULL; count++)
        if (strcmp(names[count], value) == 0) return (int)count;
    words_unknown(name, what, value, names, count);
    return -1;
}

bool option_isa_environment(const char *name) {
    const char *word = getenv("CELLWALK_ISA");
    return word == NULL || number_of(name, "CELLWALK_ISA", word, option_isa_names) >= 0;
}

bool option_isa_limit(const char *name, cw_isa isa) {
    const cw_isa most = cw_isa_best();
    cw_isa_limit(isa);
    return cw_isa_best() == isa ||
           command_refuse(name, "--isa %s: this machine, or CELLWALK_ISA, allows no more than %s", cw_isa_name(isa),
                          cw_isa_name(most));
}

/* ---- help ---- */

/* Two spaces at least stand before the text: pages.cmake finds it by them. */
static void print_option(const option_spec *o) {
    enum { HELP_COLUMN = 25 };
    char help[2048];
    int width = o->letter ? printf("  -%c, --%s", o->letter, o->name) : printf("      --%s", o->name);
    if (o->value) width += printf(" %s", o->value);
    if (width + 2 > HELP_COLUMN) width = printf("\n") - 1;
    printf("%*s", HELP_COLUMN - width, "");
    size_t used = (size_t)snprintf(help, sizeof help, "%s", o->help);
    for (size_t k = 0; o->names && o->names(k) && used < sizeof help; k++)
        used += (size_t)snprintf(help + used, sizeof help - used, "%s%s", k ? ", " : ": ", o->names(k));
    words_wrap(help, HELP_COLUMN);
}

static void print_help(const options_usage *usage) {
    fputs("Usage: ", stdout);
    command_print_name(stdout, usage->name);
    printf(" %s\n\n", usage->synopsis);
    words_wrap(usage->what, 0);
    fputs("\nOptions:\n", stdout);
    for (size_t k = 0; k < usage->option_count; k++) print_option(&usage->options[k]);
    print_option(&(option_spec){.name = "help", .letter = 'h', .help = "this text"});
    if (usage->examples) printf("\nExamples:\n%s", usage->examples);
}

/* ---- mistakes ---- */

static int wrong(const options_usage *usage) {
    fputs("Try '", stderr);
    command_print_name(stderr, usage->name);
    fputs(" --help'.\n", stderr);
    return EXIT_USAGE;
}

static int unknown(const options_usage *usage, const char *argument, size_t length) {
    const char *names[NAMES_MAX] = {"help"};
    size_t count = 1;
    for (; count < NAMES_MAX && count <= usage->option_count; count++) names[count] = usage->options[count - 1].name;
    char word[64];
    snprintf(word, sizeof word, "%.*s", (int)length, argument);
    const char *meant = word[1] == '-' ? words_closest(word + 2, names, count) : NULL;
    bool places = strstr(usage->synopsis, "X,Y[,H]") != NULL;
    for (size_t k = 0; k < usage->option_count; k++)
        places |= usage->options[k].value && strncmp(usage->options[k].value, "X,Y[,H]", 7) == 0;
    if (places && strstr(word, "height") != NULL && (meant == NULL || strstr(meant, "height") == NULL))
        command_fail(usage->name, "unknown option %s; the height of a place is its third number: X,Y,H", word);
    else
        command_fail(usage->name, meant ? "unknown option %s; did you mean --%s?" : "unknown option %s", word, meant);
    return wrong(usage);
}

/* ---- values ---- */

/* A range of numbers has two ends, or is told by takes. */
static bool set_number(const options_usage *usage, const option_spec *o, const char *value) {
    const bool whole = o->kind == OPTION_COUNT, ranged = o->low < o->high && o->takes == NULL;
    char *end = NULL, range[80] = "";
    const double number = number_read(value, &end);
    const bool digits = !whole || strspn(value, "0123456789") == strlen(value);
    if (end != value && *end == '\0' && digits && (ranged ? number >= o->low && number <= o->high : isfinite(number))) {
        if (o->takes && !(number >= o->low && number <= o->high))
            return command_refuse(usage->name, "--%s takes %s, not %g", o->name, o->takes, number);
        if (whole)
            *(unsigned *)o->to = (unsigned)number;
        else
            *(double *)o->to = number;
        return true;
    }
    if (whole)
        snprintf(range, sizeof range, " from %.0f to %.0f", o->low, o->high);
    else if (ranged)
        snprintf(range, sizeof range, " from %g to %g", o->low, o->high);
    return command_refuse(usage->name, "--%s takes a %snumber%s, not '%s'", o->name, whole ? "whole " : "", range,
                          value);
}

static bool set_value(const options_usage *usage, const option_spec *o, char *value) {
    char what[64];
    option_again *all = o->to;
    if (o->kind == OPTION_FLAG) return *(bool *)o->to = true;
    if (o->kind == OPTION_COUNT || o->kind == OPTION_REAL) return set_number(usage, o, value);
    if (o->kind == OPTION_NAME) {
        snprintf(what, sizeof what, "--%s", o->name);
        return (*(int *)o->to = number_of(usage->name, what, value, o->names)) >= 0;
    } else if (value[0] == '\0') {
        return command_refuse(usage->name, "--%s needs a value that is not empty", o->name);
    } else if (o->kind == OPTION_AGAIN && all->count == OPTION_AGAIN_MAX) {
        return command_refuse(usage->name, "--%s may be given %d times at most", o->name, OPTION_AGAIN_MAX);
    } else if (o->kind == OPTION_AGAIN) {
        all->values[all->count++] = value;
    } else {
        *(const char **)o->to = value;
    }
    return true;
}

/* ---- parsing ---- */

static const char *given_names[NAMES_MAX];
static size_t given_count;

bool options_given(const char *name) {
    for (size_t k = 0; k < given_count; k++)
        if (strcmp(given_names[k], name) == 0) return true;
    return false;
}

bool options_lack(const char *name, const char *const *options, const char *reason) {
    for (; *options; options++)
        if (options_given(*options)) return command_refuse(name, "--%s %s", *options, reason);
    return true;
}

/* The option that argument names, and the value that is written into the same argument, if any. */
static const option_spec *find(const options_usage *usage, char *argument, size_t *length, char **value) {
    const bool is_long = argument[1] == '-';
    char *equals = is_long ? strchr(argument, '=') : NULL;
    *length = equals ? (size_t)(equals - argument) : is_long ? strlen(argument) : 2;
    *value = equals ? equals + 1 : argument[*length] != '\0' ? argument + *length : NULL;
    for (size_t k = 0; k < usage->option_count; k++) {
        const option_spec *o = &usage->options[k];
        if (is_long ? strlen(o->name) == *length - 2 && strncmp(o->name, argument + 2, *length - 2) == 0
                    : o->letter != 0 && o->letter == argument[1])
            return o;
    }
    return NULL;
}

/* Takes the option at argv[*k], and the argument behind it if that is its value. */
static int take_option(const options_usage *usage, int argc, char **argv, int *k) {
    size_t length;
    char *value;
    const option_spec *o = find(usage, argv[*k], &length, &value);
    if (o == NULL) return unknown(usage, argv[*k], length);
    const bool again = options_given(o->name), flag = o->kind == OPTION_FLAG;
    if (!again && given_count < NAMES_MAX) given_names[given_count++] = o->name;
    if (!flag && value == NULL && *k + 1 < argc) value = argv[++*k];
    if (flag && value)
        command_fail(usage->name, "--%s takes no value, but got '%s'", o->name, value);
    else if (!flag && value == NULL)
        command_fail(usage->name, "--%s needs a value: --%s %s", o->name, o->name, o->value);
    else if (!flag && again && o->kind != OPTION_AGAIN)
        command_fail(usage->name, "--%s is given twice", o->name);
    else if (set_value(usage, o, value))
        return OPTIONS_GO;
    return wrong(usage);
}

/* No option begins with a digit or a point: "-3.5,7" is a place. */
static bool is_number(const char *argument) { return strchr("0123456789.", argument[1]) != NULL; }

int options_parse(const options_usage *usage, int argc, char **argv, const char **operands) {
    for (size_t k = 0; k < usage->operand_most; k++) operands[k] = NULL;
    given_count = 0;
    size_t given = 0;
    bool options_over = false;
    for (int k = 1; k < argc; k++) {
        char *argument = argv[k];
        if (!options_over && strcmp(argument, "--") == 0) {
            options_over = true;
        } else if (!options_over && (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0)) {
            print_help(usage);
            return EXIT_SUCCESS;
        } else if (!options_over && argument[0] == '-' && argument[1] != '\0' && !is_number(argument)) {
            const int result = take_option(usage, argc, argv, &k);
            if (result != OPTIONS_GO) return result;
        } else if (given < usage->operand_most) {
            operands[given++] = argument;
        } else {
            command_fail(usage->name, "'%s' is one argument too many", argument);
            return wrong(usage);
        }
    }
    if (given >= usage->operand_least) return OPTIONS_GO;
    command_fail(usage->name, "%s is missing", usage->operands[given]);
    return wrong(usage);
}
