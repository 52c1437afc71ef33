/* SPDX-License-Identifier: Apache-2.0 */
/* Command lines: one table describes a subcommand to the parser and to the reader of --help, so that the two cannot
 * disagree. Options and operands may come in any order; `--name=value` and `--name value` mean the same, as do `-o
 * value` and `-ovalue`; `--` ends the options. An option with a value is given once, unless it is an OPTION_AGAIN. */
#ifndef CELLWALK_OPTIONS_OPTIONS_H
#define CELLWALK_OPTIONS_OPTIONS_H

#include "cellwalk_expert.h"

#include <float.h>
#include <stdbool.h>
#include <stddef.h>

typedef enum option_kind {
    OPTION_FLAG,  /* to: bool *; takes no value */
    OPTION_TEXT,  /* to: const char **; the argument itself, not a copy */
    OPTION_COUNT, /* to: unsigned *; a whole number in [low, high] */
    OPTION_REAL,  /* to: double *; a finite number, in [low, high] if low < high or takes is set */
    OPTION_NAME,  /* to: int *; the number of the name given */
    OPTION_AGAIN  /* to: option_again *; may be given several times */
} option_kind;

/* The values of an option that may be given several times, the arguments themselves, in order. */
enum { OPTION_AGAIN_MAX = 256 };
typedef struct option_again {
    size_t count;
    const char *values[OPTION_AGAIN_MAX];
} option_again;

/* The name with that number; NULL from the count on. */
typedef const char *option_names(size_t number);

typedef struct option_spec {
    const char *name;  /* without dashes */
    const char *value; /* name of the value in the help; NULL for a flag. FILE, FOLDER, IMAGE and NAME.END are paths */
    const char *help;  /* is wrapped; the names are appended */
    option_kind kind;
    void *to; /* untouched while the option is not given */
    double low, high;
    const char *takes;   /* a number: "metres above 0" */
    option_names *names; /* that the value may have; NULL for any */
    char letter;         /* a one-letter form, or 0 */
} option_spec;

/* Rows by kind: name, the value's name, where it goes, help. */
static inline option_spec option_flag(const char *name, bool *to, const char *help) {
    return (option_spec){name, NULL, help, OPTION_FLAG, .to = to};
}
static inline option_spec option_text(const char *name, const char *value, const char **to, const char *help) {
    return (option_spec){name, value, help, OPTION_TEXT, .to = to};
}
static inline option_spec option_output(const char *value, const char **to, const char *help) {
    return (option_spec){.name = "output", .letter = 'o', .value = value, .help = help, .kind = OPTION_TEXT, .to = to};
}
static inline option_spec option_number(const char *name, const char *value, double *to, const char *help) {
    return (option_spec){name, value, help, OPTION_REAL, .to = to};
}
static inline option_spec option_range(const char *name, const char *value, double *to, double low, double high,
                                       const char *takes, const char *help) {
    return (option_spec){name, value, help, OPTION_REAL, .to = to, .low = low, .high = high, .takes = takes};
}
/* 0: not given. */
static inline option_spec option_metres(const char *name, double *to, const char *help) {
    return option_range(name, "D", to, DBL_MIN, DBL_MAX, "metres above 0", help);
}
static inline option_spec option_several(const char *name, const char *value, option_again *to, const char *help) {
    return (option_spec){name, value, help, OPTION_AGAIN, .to = to};
}
static inline option_spec option_count(const char *name, const char *value, unsigned *to, double low, double high,
                                       const char *help) {
    return (option_spec){name, value, help, OPTION_COUNT, .to = to, .low = low, .high = high};
}
/* Of names: the number of the one given. */
static inline option_spec option_choice(const char *name, const char *value, int *to, option_names *names,
                                        const char *help) {
    return (option_spec){name, value, help, OPTION_NAME, .to = to, .names = names};
}

typedef struct options_usage {
    const char *name;     /* the subcommand; "" if the program has none */
    const char *synopsis; /* all that follows the name: "FIELD RAYS.npy -o HITS.npy [OPTIONS]" */
    const char *what;     /* paragraphs, which are wrapped */
    const char *examples; /* lines, indented, ending in a newline; or NULL */
    const option_spec *options;
    size_t option_count;
    const char *const *operands; /* names of the operands, in order */
    size_t operand_least, operand_most;
} options_usage;

/* An array as the options of a usage. */
#define OPTIONS_OF(rows) .options = (rows), .option_count = sizeof(rows) / sizeof *(rows)

/* OPTIONS_GO if the command line is right; else the exit status: EXIT_SUCCESS where the help was requested and
 * printed, EXIT_USAGE where a message was. operands has room for usage->operand_most; those not given become NULL. */
enum { OPTIONS_GO = -1 };
int options_parse(const options_usage *usage, int argc, char **argv, const char **operands);

/* Whether the last command line had the option. */
bool options_given(const char *name);
/* That it had none, up to a NULL; false after a message with the reason: "--band is for rasters, not for scenes". */
bool options_lack(const char *name, const char *const *options, const char *reason);

/* Names for options: of kernels, instruction sets and leaf tests. */
const char *option_kernel_names(size_t number);
const char *option_isa_names(size_t number);
const char *option_leaf_names(size_t number);

/* Instruction sets that a user names. Functions return false after a message that begins with the subcommand's name.
 *  - CELLWALK_ISA: an upper bound that may exceed the machine's; a misspelt one fails: the library would ignore it.
 *  - The library is limited to isa. It is an error if CPU or CELLWALK_ISA rule that out, or else a measurement would
 *    carry the wrong label. */
bool option_isa_environment(const char *name);
bool option_isa_limit(const char *name, cw_isa isa);

#endif
