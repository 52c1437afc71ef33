/* SPDX-License-Identifier: Apache-2.0 */
/* Completions for zsh: one function, which the completion system loads from the file. */

#include "pages.h"

/* In the input of _describe and _arguments a colon would end a part, a bracket the description. */
static const char special[] = "\\:[]";

static void print_rows(FILE *to, const char *name, const char *what) {
    fprintf(to, "            '%s:", name);
    pages_print_quoted(to, what, special);
    fputs("'\n", to);
}

static void head(FILE *to, const program *p) {
    fprintf(to, "#compdef %s\n_", p->name);
    pages_print_function(to, p);
    fputs("() {\n"
          "    if ((CURRENT == 2)); then\n"
          "        local -a commands options\n"
          "        commands=(\n",
          to);
    for (size_t k = 0; k < p->command_count; k++) print_rows(to, p->commands[k]->name, p->commands[k]->what);
    fputs("        )\n"
          "        options=(\n",
          to);
    print_rows(to, "--help", option_help.help);
    print_rows(to, "--version", option_version.help);
    fputs("        )\n"
          "        _describe -t commands command commands -- options\n"
          "        return\n"
          "    fi\n"
          "    local command=$words[2]\n"
          "    shift words\n"
          "    ((CURRENT--))\n"
          "    case $command in\n",
          to);
}

/* 'OPTION[description]:VALUE:values', with both forms of an option that has a letter; after a star where it may be
 * repeated. */
static void print_option(FILE *to, const option_spec *o) {
    const page_value value = pages_value(o);
    const bool again =
        o->kind == OPTION_AGAIN || o->kind == OPTION_LIST || o->kind == OPTION_COUNTS || o->kind == OPTION_REALS;
    const char *equals = value == PAGE_NOTHING ? "" : "=";
    char brief[PAGE_BRIEF];
    pages_brief(o, brief);
    fputs(" \\\n            ", to);
    if (o->letter && again)
        fprintf(to, "'*'{-%c%s,--%s%s}'", o->letter, *equals ? "+" : "", o->name, equals);
    else if (o->letter)
        fprintf(to, "'(-%c --%s)'{-%c%s,--%s%s}'", o->letter, o->name, o->letter, *equals ? "+" : "", o->name, equals);
    else
        fprintf(to, "'%s--%s%s", again ? "*" : "", o->name, equals);
    putc('[', to);
    pages_print_quoted(to, brief, special);
    putc(']', to);
    if (value != PAGE_NOTHING) {
        putc(':', to);
        pages_print_quoted(to, o->value, special);
        putc(':', to);
    }
    if (value == PAGE_FILE) fputs("_files", to);
    if (value == PAGE_WORD) putc('(', to);
    if (value == PAGE_WORDS) fprintf(to, "_values -s , %s ", o->value);
    pages_print_names(to, o, " ");
    if (value == PAGE_WORD) putc(')', to);
    putc('\'', to);
}

static void command_case(FILE *to, const program *p, const command *c, const options_usage *usage) {
    (void)p;
    fprintf(to, "    %s)\n        _arguments", c->name);
    for (size_t k = 0; pages_option(usage, k); k++) print_option(to, pages_option(usage, k));
    for (size_t k = 0; k < usage->operand_most; k++) {
        fputs(" \\\n            ':", to);
        pages_print_quoted(to, usage->operands[k], special);
        fputs(":_files'", to);
    }
    fputs(" ;;\n", to);
}

static void tail(FILE *to, const program *p) {
    fputs("    esac\n}\n_", to);
    pages_print_function(to, p);
    fputs(" \"$@\"\n", to);
}

const page_writer pages_zsh = {"zsh/vendor-completions/_", "", false, head, command_case, tail};
