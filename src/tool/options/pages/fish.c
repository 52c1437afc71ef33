/* SPDX-License-Identifier: Apache-2.0 */
/* Completions for fish: one line an option. */

#include "pages.h"

static const char special[] = "\\";

static void head(FILE *to, const program *p) {
    fprintf(to, "# fish completion of %s\ncomplete -c %s -f\n", p->name, p->name);
    for (size_t k = 0; k < p->command_count; k++) {
        fprintf(to, "complete -c %s -n __fish_use_subcommand -a %s -d '", p->name, p->commands[k]->name);
        pages_print_quoted(to, p->commands[k]->what, special);
        fputs("'\n", to);
    }
    fprintf(to, "complete -c %s -n __fish_use_subcommand -l %s -s h -d '%s'\n", p->name, option_help.name,
            option_help.help);
    fprintf(to, "complete -c %s -n __fish_use_subcommand -l %s -d '%s'\n", p->name, option_version.name,
            option_version.help);
}

/* __fish_complete_list takes a command, which it evaluates. */
static void print_value(FILE *to, const option_spec *o) {
    switch (pages_value(o)) {
    case PAGE_NOTHING:
        break;
    case PAGE_WORD:
        fputs(" -x -a '", to);
        pages_print_names(to, o, " ");
        fputs("'", to);
        break;
    case PAGE_WORDS:
        fputs(" -x -a '(__fish_complete_list , \"string split , ", to);
        pages_print_names(to, o, ",");
        fputs("\")'", to);
        break;
    case PAGE_FILE:
        fputs(" -r -F", to);
        break;
    default:
        fputs(" -x", to);
        break;
    }
}

static void command_lines(FILE *to, const program *p, const command *c, const options_usage *usage) {
    for (size_t k = 0; pages_option(usage, k); k++) {
        const option_spec *o = pages_option(usage, k);
        char brief[PAGE_BRIEF];
        pages_brief(o, brief);
        fprintf(to, "complete -c %s -n '__fish_seen_subcommand_from %s' -l %s", p->name, c->name, o->name);
        if (o->letter) fprintf(to, " -s %c", o->letter);
        print_value(to, o);
        fputs(" -d '", to);
        pages_print_quoted(to, brief, special);
        fputs("'\n", to);
    }
    if (usage->operand_most > 0)
        fprintf(to, "complete -c %s -n '__fish_seen_subcommand_from %s' -F\n", p->name, c->name);
}

const page_writer pages_fish = {"fish/vendor_completions.d/", ".fish", false, head, command_lines, NULL};
