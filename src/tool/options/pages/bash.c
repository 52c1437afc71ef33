/* SPDX-License-Identifier: Apache-2.0 */
/* Options without words to choose from get file names, or nothing. */

#include "pages.h"

#include <string.h>

/* A name for the function: the program's with _ for -. */
static void print_function(FILE *to, const program *p) {
    putc('_', to);
    for (const char *c = p->name; *c; c++) putc(*c == '-' ? '_' : *c, to);
}

/* bash takes --option=value for three words, since = is one of its breaks. */
void bash_head(FILE *to, const program *p) {
    fprintf(to, "# bash completion of %s -*- shell-script -*-\n", p->name);
    print_function(to, p);
    fputs("() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
          "    if [[ $word == '=' ]]; then\n"
          "        word=\n"
          "    elif [[ $before == '=' ]]; then\n"
          "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
          "    fi\n"
          "    COMPREPLY=()\n"
          "    if ((COMP_CWORD == 1)); then\n"
          "        mapfile -t COMPREPLY < <(compgen -W '",
          to);
    for (size_t k = 0; k < p->command_count; k++) fprintf(to, "%s ", p->commands[k]->name);
    fprintf(to,
            "--%s --%s' -- \"$word\")\n"
            "        return\n"
            "    fi\n"
            "    case ${COMP_WORDS[1]}:$before in\n",
            option_help.name, option_version.name);
}

/* Values of options that take some: words, files, or anything. */
static void print_case(FILE *to, const command *c, const option_spec *o) {
    static const char *const files[] = {"FILE", "FOLDER", "IMAGE"};
    if (o->value == NULL) return;
    if (o->letter) fprintf(to, "    %s:-%c | ", c->name, o->letter);
    fprintf(to, "%s%s:--%s) ", o->letter ? "" : "    ", c->name, o->name);
    if (o->names) {
        fputs("words='", to);
        for (size_t k = 0; o->names(k); k++) fprintf(to, "%s%s", k ? " " : "", o->names(k));
        fputs("' ;;\n", to);
        return;
    }
    bool file = strchr(o->value, '.') != NULL;
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) file = file || strcmp(o->value, files[k]) == 0;
    fputs(file ? "words=: ;;\n" : "return ;;\n", to);
}

void bash_command(FILE *to, const command *c, const options_usage *usage) {
    for (size_t k = 0; pages_option(usage, k); k++) print_case(to, c, pages_option(usage, k));
    fprintf(to, "    %s:*) [[ $word == -* ]] && words='", c->name);
    for (size_t k = 0; pages_option(usage, k); k++) {
        const option_spec *o = pages_option(usage, k);
        fprintf(to, "%s--%s", k ? " " : "", o->name);
        if (o->letter) fprintf(to, " -%c", o->letter);
    }
    fputs("' || words=: ;;\n", to);
}

void bash_tail(FILE *to, const program *p) {
    fputs("    esac\n"
          "    if [[ $words == : ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
          "    else\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
          "    fi\n"
          "}\n"
          "complete -F ",
          to);
    print_function(to, p);
    fprintf(to, " %s\n", p->name);
}
