/* SPDX-License-Identifier: Apache-2.0 */
/* A program and its subcommands, their messages and exit statuses. Standard output carries results only; messages,
 * warnings and progress go to standard error. */
#ifndef CELLWALK_OPTIONS_COMMAND_H
#define CELLWALK_OPTIONS_COMMAND_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct command {
    const char *name; /* "trace" */
    const char *what; /* one line for the list in the program's --help */
    /* argv[0] is the subcommand's name. Returns the program's exit status. */
    int (*run)(int argc, char **argv);
} command;

typedef struct program {
    const char *name; /* "cellwalk" */
    const char *what; /* its purpose: a line */
    const command *const *commands;
    size_t command_count;
    const char *ending;  /* of the help, indented examples among it: lines; or NULL */
    void (*about)(void); /* prints the lines of --version below the version; or NULL */
} program;

/* Runs the subcommand that argv[1] names, and handles --help, --version and unknown subcommands. Returns the exit
 * status, which is not 0 if standard output could not be written. */
int program_main(const program *p, int argc, char **argv);

/* Exit statuses: EXIT_USAGE for a wrong command line, EXIT_FAILURE for all later errors. A program that was interrupted
 * ends with the signal. */
enum { EXIT_USAGE = 2 };

/* Prints "PROGRAM NAME: message", or "PROGRAM: message" if name is empty, and returns EXIT_FAILURE. */
__attribute__((format(printf, 2, 3))) int command_fail(const char *name, const char *format, ...);
/* The same: false, for checks; for what is no failure; and "PROGRAM NAME: warning: message". */
#define command_refuse(...)     (command_fail(__VA_ARGS__) == EXIT_SUCCESS)
#define command_note(...)       ((void)command_fail(__VA_ARGS__))
#define command_warn(name, ...) command_note(name, "warning: " __VA_ARGS__)

/* Prints the line at the end of a command, "FILE: TEXT, 0.31 s". Not if quiet, nor if the file is NULL or "-".
 * start: clock_seconds() at its beginning. */
__attribute__((format(printf, 5, 6))) void command_wrote(const char *name, bool quiet, const char *file, double start,
                                                         const char *format, ...);

/* Prints "PROGRAM NAME". */
void command_print_name(FILE *to, const char *name);

/* The line on the terminal that says how far a long run is; none where standard error is no terminal. step, "tracing",
 * must stay; another one begins a new line. share is in [0, 1]. Prints at most ten times a second, and not in a run
 * that is over at once. Calls must not overlap. */
void progress_show(const char *step, double share);
/* Removes the line. Messages do so themselves; to be called before anything is printed to standard output. */
void progress_end(void);
/* Whether there is a line. For signal handlers. */
bool progress_is_shown(void);

/* Of count words the one that is closest to word, by edit distance, if it is close enough to be meant; else NULL. */
const char *words_closest(const char *word, const char *const *words, size_t count);
/* Prints "PROGRAM NAME: WHAT 'word' is unknown; there are a, b, c" with the closest before the list. Returns false. */
bool words_unknown(const char *name, const char *what, const char *word, const char *const *words, size_t count);
/* Prints text from column on, which is where the cursor is, on lines of at most 80 columns, all of them indented by
 * column. An empty line ends a paragraph. A line that begins with a space is one of a list: it begins on a new line,
 * and goes on, if it is too long, below the text behind its first gap of two spaces. All other line breaks are spaces.
 * Ends with a line break. */
void words_wrap(const char *text, size_t column);

#endif
