/* SPDX-License-Identifier: Apache-2.0 */
/* Options without words to choose from get file names, or nothing. */

#include "pages.h"

#include <string.h>

/* A name for the function: the program's with _ for -. */
static void print_function(FILE *to, const char *before, const program *p, const char *after) {
    fputs(before, to);
    for (const char *c = p->name; *c; c++) putc(*c == '-' ? '_' : *c, to);
    fputs(after, to);
}

/* bash takes --option=value for three words, since = is one of its breaks. */
void bash_head(FILE *to, const program *p) {
    fprintf(to, "# bash completion of %s -*- shell-script -*-\n", p->name);
    print_function(to, "_", p,
                   "() {\n"
                   "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
                   "    if [[ $word == '=' ]]; then\n"
                   "        word=\n"
                   "    elif [[ $before == '=' ]]; then\n"
                   "        before=${COMP_WORDS[COMP_CWORD - 2]}\n"
                   "    fi\n"
                   "    COMPREPLY=()\n"
                   "    if ((COMP_CWORD == 1)); then\n"
                   "        mapfile -t COMPREPLY < <(compgen -W '");
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
    if (o->value == NULL) return;
    fputs("    ", to);
    if (o->letter) fprintf(to, "%s:-%c | ", c->name, o->letter);
    fprintf(to, "%s:--%s) ", c->name, o->name);
    for (size_t k = 0; o->names && o->names(k); k++) fprintf(to, "%s%s", k ? " " : "words='", o->names(k));
    const bool file = strchr(o->value, '.') || strcmp(o->value, "FILE") == 0 || strcmp(o->value, "FOLDER") == 0 ||
                      strcmp(o->value, "IMAGE") == 0;
    fputs(o->names ? "' ;;\n" : file ? "words=: ;;\n" : "return ;;\n", to);
}

void bash_command(FILE *to, const command *c, const options_usage *usage) {
    const option_spec *o;
    for (size_t k = 0; (o = pages_option(usage, k)) != NULL; k++) print_case(to, c, o);
    fprintf(to, "    %s:*) [[ $word == -* ]] && words='", c->name);
    for (size_t k = 0; (o = pages_option(usage, k)) != NULL; k++) {
        fprintf(to, "%s--%s", k ? " " : "", o->name);
        if (o->letter) fprintf(to, " -%c", o->letter);
    }
    fputs("' || words=: ;;\n", to);
}

void bash_tail(FILE *to, const program *p) {
    print_function(to,
                   "    esac\n"
                   "    if [[ $words == : ]]; then\n"
                   "        compopt -o filenames 2>/dev/null\n"
                   "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
                   "    else\n"
                   "        mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
                   "    fi\n"
                   "}\n"
                   "complete -F _",
                   p, "");
    fprintf(to, " %s\n", p->name);
}
