/* SPDX-License-Identifier: Apache-2.0 */
/* A man page for the program and one for each subcommand. */

#include "pages.h"

#include <stdlib.h>
#include <string.h>

/* So many bytes of text, so that roff prints them as they are; a line break is a space. Every "-" becomes one that can be
 * copied into a shell. */
static void print_bytes(FILE *to, const char *text, size_t bytes) {
    static const char from[] = "\\-'`^~\"\n";
    static const char *const becomes[] = {"\\e", "\\-", "\\(aq", "\\(ga", "\\(ha", "\\(ti", "\\(dq", " "};
    for (const char *end = text + bytes; text < end; text++) {
        const char *found = *text ? strchr(from, *text) : NULL;
        if (found)
            fputs(becomes[found - from], to);
        else
            putc(*text, to);
    }
}
static void print_text(FILE *to, const char *text) { print_bytes(to, text, strlen(text)); }

/* A line of text: one that begins with a dot would be a request. */
static void print_line(FILE *to, const char *text, size_t bytes) {
    fputs("\\&", to);
    print_bytes(to, text, bytes);
    putc('\n', to);
}

/* Paragraphs and lists, as words_wrap takes them. */
static void print_paragraphs(FILE *to, const char *text) {
    while (*text) {
        size_t length = strcspn(text, "\n");
        while (text[length] == '\n' && !strchr("\n ", text[length + 1])) length += 1 + strcspn(text + length + 1, "\n");
        const size_t indent = strspn(text, " ");
        const char *gap = strstr(text + indent, "  ");
        if (indent > 0 && gap && gap < text + length) {
            fputs(".TP 11\n", to);
            print_line(to, text + indent, (size_t)(gap - text) - indent);
            gap += strspn(gap, " ");
            print_line(to, gap, (size_t)(text + length - gap));
        } else {
            if (indent > 0) fputs(".br\n", to);
            print_line(to, text + indent, length - indent);
        }
        text += length;
        const size_t breaks = strspn(text, "\n");
        if (breaks > 1 && text[breaks]) fputs(".PP\n", to);
        text += breaks;
    }
}

static void print_lines(FILE *to, const char *text) {
    fputs(".nf\n", to);
    while (*text) {
        const size_t length = strcspn(text, "\n");
        print_line(to, text, length);
        text += length + (text[length] == '\n');
    }
    fputs(".fi\n", to);
}

static void print_capitals(FILE *to, const char *text) {
    for (; *text; text++) putc(*text >= 'a' && *text <= 'z' ? *text - 'a' + 'A' : *text, to);
}

/* The page's title and name. */
static void print_title(FILE *to, const program *p, const command *c) {
    fputs(".TH \"", to);
    print_capitals(to, p->name);
    if (c) putc('-', to);
    if (c) print_capitals(to, c->name);
    fprintf(to, "\" 1 \"\" \"cellwalk %s\" \"Cellwalk\"\n.nh\n.ad l\n.SH NAME\n", CW_VERSION);
    print_text(to, p->name);
    if (c) print_text(to, "-");
    if (c) print_text(to, c->name);
    fputs(" \\- ", to);
    print_text(to, c ? c->what : p->what);
    fputs("\n.SH SYNOPSIS\n", to);
}

static void print_option(FILE *to, const option_spec *o) {
    fputs(".TP\n", to);
    if (o->letter) fprintf(to, "\\fB\\-%c\\fR, ", o->letter);
    fputs("\\fB\\-\\-", to);
    print_text(to, o->name);
    fputs("\\fR", to);
    if (o->value) {
        fputs(" \\fI", to);
        print_text(to, o->value);
        fputs("\\fR", to);
    }
    putc('\n', to);
    fputs("\\&", to);
    print_text(to, o->help);
    for (size_t k = 0; o->names && o->names(k); k++) {
        fputs(k ? ", " : ": ", to);
        print_text(to, o->names(k));
    }
    putc('\n', to);
}

static void print_status(FILE *to) {
    fprintf(to, ".SH EXIT STATUS\n0 if all went well, %d if the command line is wrong, %d after any other failure.\n",
            EXIT_USAGE, EXIT_FAILURE);
}

static void print_reference(FILE *to, const program *p, const command *c, const char *end) {
    fputs(".BR ", to);
    print_text(to, p->name);
    if (c) print_text(to, "-");
    if (c) print_text(to, c->name);
    fprintf(to, " (1)%s\n", end);
}

void man_program(FILE *to, const program *p) {
    print_title(to, p, NULL);
    fputs("\\fB", to);
    print_text(to, p->name);
    fputs("\\fR \\fICOMMAND\\fR [\\fIARGUMENTS\\fR]\n.SH COMMANDS\n", to);
    for (size_t k = 0; k < p->command_count; k++) {
        fputs(".TP\n\\fB", to);
        print_text(to, p->commands[k]->name);
        fputs("\\fR\n", to);
        print_line(to, p->commands[k]->what, strlen(p->commands[k]->what));
    }
    fputs(".SH OPTIONS\n", to);
    print_option(to, &option_help);
    print_option(to, &option_version);
    if (p->ending) {
        fputs(".SH NOTES\n", to);
        print_lines(to, p->ending);
    }
    print_status(to);
    fputs(".SH SEE ALSO\n", to);
    for (size_t k = 0; k < p->command_count; k++)
        print_reference(to, p, p->commands[k], k + 1 < p->command_count ? "," : "");
}

void man_command(FILE *to, const program *p, const command *c, const options_usage *usage) {
    print_title(to, p, c);
    fputs("\\fB", to);
    print_text(to, p->name);
    fprintf(to, " %s\\fR ", c->name);
    print_text(to, usage->synopsis);
    fputs("\n.SH DESCRIPTION\n", to);
    print_paragraphs(to, usage->what);
    fputs(".SH OPTIONS\n", to);
    for (size_t k = 0; pages_option(usage, k); k++) print_option(to, pages_option(usage, k));
    if (usage->examples) {
        fputs(".SH EXAMPLES\n", to);
        print_lines(to, usage->examples);
    }
    print_status(to);
    fputs(".SH SEE ALSO\n", to);
    print_reference(to, p, NULL, "");
}
