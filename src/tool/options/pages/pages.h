/* SPDX-License-Identifier: Apache-2.0 */
/* Man pages, and completions for bash, written from the tables that the help is printed from. */
#ifndef CELLWALK_OPTIONS_PAGES_H
#define CELLWALK_OPTIONS_PAGES_H

#include "command.h"
#include "options.h"

/* Writes the pages of a program and all its subcommands into the folder, which is made if need be, with the layout
 * of share/: man/man1, bash-completion/completions. Returns an exit status. */
int pages_write(const program *p, const char *folder);

/* The subcommand's option number k; the last is --help. NULL behind it. */
static inline const option_spec *pages_option(const options_usage *usage, size_t k) {
    return k < usage->option_count ? &usage->options[k] : k == usage->option_count ? &option_help : NULL;
}

/* man.c: the page of the program and that of a subcommand. */
void man_program(FILE *to, const program *p);
void man_command(FILE *to, const program *p, const command *c, const options_usage *usage);

/* bash.c: one function, whose parts are printed in this order, bash_command for each subcommand. */
void bash_head(FILE *to, const program *p);
void bash_command(FILE *to, const command *c, const options_usage *usage);
void bash_tail(FILE *to, const program *p);

#endif
