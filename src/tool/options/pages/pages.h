/* SPDX-License-Identifier: Apache-2.0 */
/* Man pages and completions for shells, written from the tables that the help is printed from. */
#ifndef CELLWALK_OPTIONS_PAGES_H
#define CELLWALK_OPTIONS_PAGES_H

#include "command.h"
#include "options.h"

/* Writes the pages of a program and all its subcommands into the folder, which is made if need be, with the layout
 * of share/: man/man1, bash-completion/completions, zsh/vendor-completions, fish/vendor_completions.d. Returns an
 * exit status. */
int pages_write(const program *p, const char *folder);

/* ---- for the writers ---- */

/* Calls in this order: head, command for each subcommand, tail. They print to one file or, if a writer has a file
 * for each subcommand, head and each command to a separate one. */
typedef struct page_writer {
    const char *before, *after; /* of the file's name */
    bool each;                  /* subcommands have files: PROGRAM-COMMAND */
    void (*head)(FILE *to, const program *p);
    void (*command)(FILE *to, const program *p, const command *c, const options_usage *usage);
    void (*tail)(FILE *to, const program *p); /* or NULL */
} page_writer;

extern const page_writer pages_man, pages_bash, pages_zsh, pages_fish;

/* The kinds of values of an option. */
typedef enum page_value {
    PAGE_NOTHING,
    PAGE_WORD,  /* one of the option's names */
    PAGE_WORDS, /* several of them, between commas */
    PAGE_FILE,
    PAGE_ANYTHING
} page_value;
page_value pages_value(const option_spec *o);

/* The subcommand's option number k; the last is --help. NULL behind it. */
const option_spec *pages_option(const options_usage *usage, size_t k);

/* The first clause of an option's help, on one line. */
enum { PAGE_BRIEF = 72 };
void pages_brief(const option_spec *o, char brief[PAGE_BRIEF]);

/* The option's names, with that between them. */
void pages_print_names(FILE *to, const option_spec *o, const char *between);

/* Text between quotes ' of a shell. In front of each of the characters in special stands a backslash. */
void pages_print_quoted(FILE *to, const char *text, const char *special);

/* A name for a shell's function: PROGRAM with _ for -. */
void pages_print_function(FILE *to, const program *p);

#endif
