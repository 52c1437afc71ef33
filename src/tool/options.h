/* SPDX-License-Identifier: Apache-2.0 */
/* Command lines: one table describes a subcommand to the parser and to the reader of --help, so that the two cannot
 * disagree. Options and operands may come in any order; `--name=value` and `--name value` mean the same, as do `-o value`
 * and `-ovalue`; `--` ends the options. */
#ifndef CELLWALK_TOOL_OPTIONS_H
#define CELLWALK_TOOL_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

typedef enum option_kind {
    OPTION_FLAG,   /* to: bool *; takes no value */
    OPTION_TEXT,   /* to: const char **; the argument itself, not a copy */
    OPTION_COUNT,  /* to: unsigned *; a whole number in [low, high] */
    OPTION_REAL,   /* to: float *; finite, not negative */
    OPTION_NUMBER, /* to: double *; finite */
    OPTION_LIST    /* to: option_list *; may be given several times */
} option_kind;

/* The values of an option that may be given several times, the arguments themselves, in order. */
enum { OPTION_LIST_MOST = 256 };
typedef struct option_list {
    size_t count;
    const char *values[OPTION_LIST_MOST];
} option_list;

typedef struct option_spec {
    const char *name;  /* without dashes */
    char letter;       /* a one-letter form, or 0 */
    const char *value; /* what stands for the value in the help; NULL for a flag */
    const char *help;  /* may have several lines */
    option_kind kind;
    void *to; /* untouched while the option is not given */
    unsigned low, high;
} option_spec;

typedef struct options_usage {
    const char *name;     /* the subcommand */
    const char *synopsis; /* all that follows the name: "FIELD RAYS.npy -o HITS.npy [OPTIONS]" */
    const char *what;     /* paragraphs, each line at most 80 columns, ending in a newline */
    const char *examples; /* lines, indented, ending in a newline */
    const option_spec *options;
    size_t option_count;
    const char *const *operands; /* names of the operands, in order */
    size_t operand_least, operand_most;
} options_usage;

typedef enum options_result {
    OPTIONS_GO,   /* everything is in its place */
    OPTIONS_HELP, /* the help was asked for and printed: end with success */
    OPTIONS_WRONG /* a message was printed: end with EXIT_USAGE */
} options_result;

/* operands has room for usage->operand_most; those that are not given become NULL. */
options_result options_parse(const options_usage *usage, int argc, char **argv, const char **operands);

#endif
