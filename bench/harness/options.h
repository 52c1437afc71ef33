/* SPDX-License-Identifier: Apache-2.0 */
/* Command-line options as a table, so that help, parsing and error messages cannot disagree. */
#ifndef CELLWALK_BENCH_HARNESS_OPTIONS_H
#define CELLWALK_BENCH_HARNESS_OPTIONS_H

#include "error.h"

#include <stddef.h>
#include <stdint.h>

enum { OPTION_LIST_MAX = 64 };

/* Values of an option that may be given several times or as a,b,c. */
typedef struct option_list {
    const char *items[OPTION_LIST_MAX];
    size_t count;
} option_list;

typedef enum option_kind { OPTION_FLAG, OPTION_TEXT, OPTION_LIST, OPTION_COUNT, OPTION_REAL } option_kind;

typedef struct option {
    const char *name;  /* "--kernel" */
    const char *value; /* how help calls the value, "NAME"; NULL for a flag */
    const char *help;
    option_kind kind;
    void *target;     /* bool, const char *, option_list, uint64_t, double, by kind */
    double low, high; /* of counts and reals */
} option;

/* Takes the options out of arguments, which keeps the *count others in order. Lists split their text in place. False
 * with the option and the value in error. */
bool options_parse(const option *options, size_t option_count, char **arguments, int *count, io_error *error);

/* The options, one paragraph each. */
void options_print(FILE *file, const option *options, size_t option_count);

/* Fills a list that is empty with the first by_default of the known names. False if it holds any other name, which error
 * then tells, after the flag, with those known. */
bool options_check_names(option_list *list, const char *flag, const char *const *known, size_t count, size_t by_default,
                         io_error *error);

/* What every subcommand begins with. --help need not be among the options. */
typedef struct option_frame {
    const char *command;  /* "report", for messages */
    const char *usage;    /* what --help begins with, the title of the options included */
    const char *examples; /* what it ends with, or NULL */
    const option *options;
    size_t option_count;
    int loose;              /* how many arguments besides options there have to be */
    const char *loose_what; /* what they are, in the plural; NULL if there are none */
} option_frame;

/* True if the work is to be done, with arguments that are not options left over. Else *status is what the program ends
 * with: help has been printed, or on standard error what is wrong with the arguments. */
bool options_begin(const option_frame *frame, char **arguments, int *count, int *status);

/* Prints the error with the command's name; what to end with: 2 if the arguments were wrong, 1 if the work failed. */
int options_misused(const char *command, const io_error *error);
int options_failed(const char *command, const io_error *error);

#endif
