/* SPDX-License-Identifier: Apache-2.0 */
/* Command-line options as a table, so that help, parsing and error messages cannot disagree. */
#ifndef CELLWALK_BENCH_OPTIONS_H
#define CELLWALK_BENCH_OPTIONS_H

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

#endif
