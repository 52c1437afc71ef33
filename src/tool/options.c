/* SPDX-License-Identifier: Apache-2.0 */
/* Not getopt_long: it completes abbreviated names, so that a script breaks when an option is added, and its messages
 * name neither value nor remedy. */

#include "options.h"

#include "command.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_option(const option_spec *o) {
    char head[64];
    if (o->letter)
        snprintf(head, sizeof head, "-%c, --%s%s%s", o->letter, o->name, o->value ? " " : "", o->value ? o->value : "");
    else
        snprintf(head, sizeof head, "    --%s%s%s", o->name, o->value ? " " : "", o->value ? o->value : "");
    const char *line = o->help;
    for (const char *label = head;; label = "") {
        const char *end = strchr(line, '\n');
        printf("  %-22s %.*s\n", label, end ? (int)(end - line) : (int)strlen(line), line);
        if (end == NULL) return;
        line = end + 1;
    }
}

static void print_help(const options_usage *usage) {
    printf("Usage: cellwalk %s %s\n\n%s\nOptions:\n", usage->name, usage->synopsis, usage->what);
    for (size_t k = 0; k < usage->option_count; k++) print_option(&usage->options[k]);
    print_option(&(option_spec){.name = "help", .letter = 'h', .help = "this text"});
    printf("\nExamples:\n%s", usage->examples);
}

static options_result wrong(const options_usage *usage) {
    fprintf(stderr, "Try 'cellwalk %s --help'.\n", usage->name);
    return OPTIONS_WRONG;
}

static options_result unknown(const options_usage *usage, const char *argument, size_t length) {
    enum { NAMES_MAX = 32 };
    const char *names[NAMES_MAX] = {"help"};
    size_t count = 1;
    for (; count < NAMES_MAX && count <= usage->option_count; count++) names[count] = usage->options[count - 1].name;
    char word[64];
    snprintf(word, sizeof word, "%.*s", (int)length, argument);
    const char *meant = word[1] == '-' ? closest_match(word + 2, names, count) : NULL;
    if (meant)
        command_fail(usage->name, "unknown option %s; did you mean --%s?", word, meant);
    else
        command_fail(usage->name, "unknown option %s", word);
    return wrong(usage);
}

static bool add_to_list(const options_usage *usage, const option_spec *o, const char *value) {
    option_list *list = o->to;
    if (list->count == OPTION_LIST_MOST)
        return command_fail(usage->name, "--%s may be given %d times at most", o->name, OPTION_LIST_MOST), false;
    list->values[list->count++] = value;
    return true;
}

static bool set_value(const options_usage *usage, const option_spec *o, const char *value) {
    if (o->kind == OPTION_TEXT || o->kind == OPTION_LIST) {
        if (value[0] == '\0') return command_fail(usage->name, "--%s needs a value that is not empty", o->name), false;
        if (o->kind == OPTION_LIST) return add_to_list(usage, o, value);
        *(const char **)o->to = value;
        return true;
    }
    char *end = NULL;
    if (o->kind == OPTION_NUMBER) {
        const double number = strtod(value, &end);
        if (end == value || *end != '\0' || !isfinite(number))
            return command_fail(usage->name, "--%s takes a number, not '%s'", o->name, value), false;
        *(double *)o->to = number;
        return true;
    }
    if (o->kind == OPTION_REAL) {
        const float real = strtof(value, &end);
        const bool whole = end != value && *end == '\0';
        if (!whole || !(real >= 0 && real <= FLT_MAX))
            return command_fail(usage->name, "--%s takes a number from 0 on, not '%s'", o->name, value), false;
        *(float *)o->to = real;
        return true;
    }
    const unsigned long number = strtoul(value, &end, 10); /* the largest there is, if value is larger */
    const bool digits = value[0] >= '0' && value[0] <= '9' && *end == '\0'; /* strtoul would take " -1" */
    if (!digits || number < o->low || number > o->high) {
        command_fail(usage->name, "--%s takes a whole number from %u to %u, not '%s'", o->name, o->low, o->high, value);
        return false;
    }
    *(unsigned *)o->to = (unsigned)number;
    return true;
}

/* The option that argument names, and the value that is written into the same argument, if any. */
static const option_spec *find(const options_usage *usage, const char *argument, size_t *length, const char **value) {
    const bool is_long = argument[1] == '-';
    const char *equals = is_long ? strchr(argument, '=') : NULL;
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
static options_result take_option(const options_usage *usage, int argc, char **argv, int *k) {
    size_t length;
    const char *value;
    const option_spec *o = find(usage, argv[*k], &length, &value);
    if (o == NULL) return unknown(usage, argv[*k], length);
    if (o->kind == OPTION_FLAG) {
        if (value) {
            command_fail(usage->name, "--%s takes no value, but got '%s'", o->name, value);
            return wrong(usage);
        }
        *(bool *)o->to = true;
        return OPTIONS_GO;
    }
    if (value == NULL && *k + 1 < argc) value = argv[++*k];
    if (value == NULL) {
        command_fail(usage->name, "--%s needs a value: --%s %s", o->name, o->name, o->value);
        return wrong(usage);
    }
    return set_value(usage, o, value) ? OPTIONS_GO : wrong(usage);
}

/* No option begins with a digit or a point: "-3.5,7" is a place. */
static bool is_number(const char *argument) { return strchr("0123456789.", argument[1]) != NULL; }

options_result options_parse(const options_usage *usage, int argc, char **argv, const char **operands) {
    for (size_t k = 0; k < usage->operand_most; k++) operands[k] = NULL;
    size_t given = 0;
    bool options_over = false;
    for (int k = 1; k < argc; k++) {
        const char *argument = argv[k];
        if (!options_over && strcmp(argument, "--") == 0) {
            options_over = true;
        } else if (!options_over && (strcmp(argument, "--help") == 0 || strcmp(argument, "-h") == 0)) {
            print_help(usage);
            return OPTIONS_HELP;
        } else if (!options_over && argument[0] == '-' && argument[1] != '\0' && !is_number(argument)) {
            const options_result result = take_option(usage, argc, argv, &k);
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
