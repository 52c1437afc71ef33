/* SPDX-License-Identifier: Apache-2.0 */
/* Completions for bash: one function. Options without words to choose from get file names, or nothing. */

#include "pages.h"

/* bash takes --option=value for three words, since = is one of its breaks. */
static void head(FILE *to, const program *p) {
    fprintf(to, "# bash completion of %s -*- shell-script -*-\n_", p->name);
    pages_print_function(to, p);
    fputs("() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words= first=\n"
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

static void print_case(FILE *to, const command *c, const option_spec *o) {
    const page_value value = pages_value(o);
    if (value == PAGE_NOTHING) return;
    if (o->letter) fprintf(to, "    %s:-%c | ", c->name, o->letter);
    fprintf(to, "%s%s:--%s) ", o->letter ? "" : "    ", c->name, o->name);
    if (value == PAGE_FILE) {
        fputs("words=: ;;\n", to);
    } else if (value == PAGE_ANYTHING) {
        fputs("return ;;\n", to);
    } else {
        fputs("words='", to);
        pages_print_names(to, o, " ");
        fputs(value == PAGE_WORDS ? "'; [[ $word == *,* ]] && first=${word%,*}, ;;\n" : "' ;;\n", to);
    }
}

static void command_case(FILE *to, const program *p, const command *c, const options_usage *usage) {
    (void)p;
    for (size_t k = 0; pages_option(usage, k); k++) print_case(to, c, pages_option(usage, k));
    fprintf(to, "    %s:*) [[ $word == -* ]] && words='", c->name);
    for (size_t k = 0; pages_option(usage, k); k++) {
        const option_spec *o = pages_option(usage, k);
        fprintf(to, "%s--%s", k ? " " : "", o->name);
        if (o->letter) fprintf(to, " -%c", o->letter);
    }
    fputs("' || words=: ;;\n", to);
}

static void tail(FILE *to, const program *p) {
    fputs("    esac\n"
          "    if [[ $words == : ]]; then\n"
          "        compopt -o filenames 2>/dev/null\n"
          "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
          "    else\n"
          "        mapfile -t COMPREPLY < <(compgen -P \"$first\" -W \"$words\" -- \"${word#\"$first\"}\")\n"
          "    fi\n"
          "}\n"
          "complete -F _",
          to);
    pages_print_function(to, p);
    fprintf(to, " %s\n", p->name);
}

const page_writer pages_bash = {"bash-completion/completions/", "", false, head, command_case, tail};
