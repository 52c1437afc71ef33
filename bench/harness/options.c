/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/options.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool take_list(option_list *list, char *text, const char *name, io_error *error) {
    for (char *rest = text; rest;) {
        char *item = strsep(&rest, ",");
        if (*item == '\0') return io_fail(error, "%s: an empty name in its list", name);
        if (list->count == OPTION_LIST_MAX) return io_fail(error, "%s: more than %d names", name, OPTION_LIST_MAX);
        list->items[list->count++] = item;
    }
    return true;
}

static bool take_number(const option *o, const char *text, io_error *error) {
    char *end;
    errno = 0;
    const double value = strtod(text, &end);
    const bool number = end != text && *end == '\0' && errno == 0 && isfinite(value);
    if (!number || value < o->low || value > o->high || (o->kind == OPTION_COUNT && value != floor(value)))
        return io_fail(error, "%s %s: must be a %snumber from %.15g to %.15g", o->name, text,
                       o->kind == OPTION_COUNT ? "whole " : "", o->low, o->high);
    if (o->kind == OPTION_COUNT)
        *(uint64_t *)o->target = (uint64_t)value;
    else
        *(double *)o->target = value;
    return true;
}

static bool take(const option *o, char *value, io_error *error) {
    switch (o->kind) {
    case OPTION_FLAG:
        *(bool *)o->target = true;
        return true;
    case OPTION_TEXT:
        *(const char **)o->target = value;
        return true;
    case OPTION_LIST:
        return take_list(o->target, value, o->name, error);
    case OPTION_COUNT:
    case OPTION_REAL:
        return take_number(o, value, error);
    }
    return false;
}

static const option *find(const option *options, size_t option_count, const char *name, size_t length) {
    for (size_t k = 0; k < option_count; k++)
        if (strlen(options[k].name) == length && memcmp(options[k].name, name, length) == 0) return &options[k];
    return NULL;
}

bool options_parse(const option *options, size_t option_count, char **arguments, int *count, io_error *error) {
    int kept = 0;
    for (int k = 0; k < *count; k++) {
        char *argument = arguments[k];
        if (argument[0] != '-' || argument[1] != '-') {
            arguments[kept++] = argument;
            continue;
        }
        char *equals = strchr(argument, '=');
        const size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
        const option *o = find(options, option_count, argument, length);
        if (o == NULL) return io_fail(error, "%s: no such option", argument);
        char *value = equals ? equals + 1 : NULL;
        if (o->kind == OPTION_FLAG && value) return io_fail(error, "%s: takes no value", argument);
        if (o->kind != OPTION_FLAG && !value) {
            if (k + 1 == *count) return io_fail(error, "%s: its value %s is missing", o->name, o->value);
            value = arguments[++k];
        }
        if (!take(o, value, error)) return false;
    }
    *count = kept;
    return true;
}

void options_print(FILE *file, const option *options, size_t option_count) {
    for (size_t k = 0; k < option_count; k++)
        fprintf(file, "  %s%s%s\n      %s\n", options[k].name, options[k].value ? " " : "",
                options[k].value ? options[k].value : "", options[k].help);
}

bool options_check_names(option_list *list, const char *flag, const char *const *known, size_t count, size_t by_default,
                         io_error *error) {
    if (list->count == 0)
        for (size_t k = 0; k < by_default; k++) list->items[list->count++] = known[k];
    for (size_t k = 0; k < list->count; k++) {
        size_t found = 0;
        while (found < count && strcmp(known[found], list->items[k]) != 0) found++;
        if (found < count) continue;
        io_fail(error, "%s %s: no such name; there are", flag, list->items[k]);
        for (size_t n = 0; n < count && error; n++) {
            const size_t used = strlen(error->text);
            snprintf(error->text + used, sizeof error->text - used, "%s %s", n ? "," : "", known[n]);
        }
        return false;
    }
    return true;
}

int options_misused(const char *command, const io_error *error) {
    fprintf(stderr, "cellwalk-bench %s: %s\nTry 'cellwalk-bench %s --help'.\n", command, error->text, command);
    return 2;
}

int options_failed(const char *command, const io_error *error) {
    fprintf(stderr, "cellwalk-bench %s: %s\n", command, error->text);
    return EXIT_FAILURE;
}

bool options_begin(const option_frame *frame, char **arguments, int *count, int *status) {
    io_error error = {{0}};
    for (int k = 0; k < *count; k++)
        if (strcmp(arguments[k], "--help") == 0) {
            fputs(frame->usage, stdout);
            options_print(stdout, frame->options, frame->option_count);
            fputs("  --help\n      this text\n", stdout);
            if (frame->examples) fputs(frame->examples, stdout);
            *status = EXIT_SUCCESS;
            return false;
        }
    bool good = options_parse(frame->options, frame->option_count, arguments, count, &error);
    if (good && *count > 0 && frame->loose == 0)
        good = io_fail(&error, "%s: %s takes options alone", arguments[0], frame->command);
    if (good && *count != frame->loose)
        good = io_fail(&error, "%d %s are needed, not %d", frame->loose, frame->loose_what, *count);
    if (!good) *status = options_misused(frame->command, &error);
    return good;
}
