/* SPDX-License-Identifier: Apache-2.0 */
/* The program's subcommands, and what they share in talking to people. Standard output carries results only; messages,
 * warnings and progress go to standard error. */
#ifndef CELLWALK_TOOL_COMMAND_H
#define CELLWALK_TOOL_COMMAND_H

#include <stddef.h>

typedef struct command {
    const char *name; /* "trace" */
    const char *what; /* one line for the list in `cellwalk --help` */
    /* argv[0] is the subcommand's name. Returns the program's exit status. */
    int (*run)(int argc, char **argv);
} command;

extern const command command_info;
extern const command command_render;
extern const command command_trace;
/* terrain/ */
extern const command command_horizon;
extern const command command_los;
extern const command command_shadow;
extern const command command_viewshed;

/* Exit statuses: EXIT_USAGE where the command line asks for something that does not exist, EXIT_FAILURE for all that
 * goes wrong later. A program that was interrupted dies of the signal. */
enum { EXIT_USAGE = 2 };

/* Prints "cellwalk NAME: message" and returns EXIT_FAILURE. */
__attribute__((format(printf, 2, 3))) int command_fail(const char *name, const char *format, ...);

/* The one of count words that is closest to word, by edit distance, if it is close enough to be what was meant; else
 * NULL. Words may be NULL and are then passed over. */
const char *closest_match(const char *word, const char *const *words, size_t count);

#endif
