/* SPDX-License-Identifier: Apache-2.0 */
/* A man page for the program and one for each subcommand. */

#include "pages.h"

#include <ctype.h>
#include <stdarg.h>
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

/* roff, with texts for %s, and for %S in capitals. */
static void print(FILE *to, const char *roff, ...) {
    va_list texts;
    va_start(texts, roff);
    for (; *roff; roff++) {
        if (*roff != '%') {
            putc(*roff, to);
            continue;
        }
        const char *text = va_arg(texts, const char *);
        if (*++roff == 's')
            print_bytes(to, text, strlen(text));
        else
            for (; *text; text++) putc(toupper((unsigned char)*text), to);
    }
    va_end(texts);
}

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

static void print_lines(FILE *to, const char *heading, const char *text) {
    if (text == NULL) return;
    print(to, ".SH %s\n.nf\n", heading);
    while (*text) {
        const size_t length = strcspn(text, "\n");
        print_line(to, text, length);
        text += length + (text[length] == '\n');
    }
    fputs(".fi\n", to);
}

/* The page's title, name and the beginning of the synopsis. dash is "-" and name the subcommand's, or both are empty. */
static void print_title(FILE *to, const program *p, const char *dash, const char *name, const char *what) {
    print(to, ".TH \"%S", p->name);
    fputs(dash, to);
    print(to, "%S\" 1 \"\" \"cellwalk ", name);
    fputs(CW_VERSION, to);
    print(to, "\" \"Cellwalk\"\n.nh\n.ad l\n.SH NAME\n%s%s%s \\- %s\n.SH SYNOPSIS\n\\fB%s", p->name, dash, name, what,
          p->name);
}

static void print_option(FILE *to, const option_spec *o) {
    fputs(".TP\n", to);
    if (o->letter) fprintf(to, "\\fB\\-%c\\fR, ", o->letter);
    print(to, "\\fB\\-\\-%s\\fR", o->name);
    if (o->value) print(to, " \\fI%s\\fR", o->value);
    print(to, "\n\\&%s", o->help);
    for (size_t k = 0; o->names && o->names(k); k++) print(to, "%s%s", k ? ", " : ": ", o->names(k));
    putc('\n', to);
}

static void print_end(FILE *to) {
    fprintf(to,
            ".SH EXIT STATUS\n0 if all went well, %d if the command line is wrong, %d after any other failure.\n.SH "
            "SEE ALSO\n",
            EXIT_USAGE, EXIT_FAILURE);
}

void man_program(FILE *to, const program *p) {
    print_title(to, p, "", "", p->what);
    fputs("\\fR \\fICOMMAND\\fR [\\fIARGUMENTS\\fR]\n.SH COMMANDS\n", to);
    for (size_t k = 0; k < p->command_count; k++)
        print(to, ".TP\n\\fB%s\\fR\n\\&%s\n", p->commands[k]->name, p->commands[k]->what);
    fputs(".SH OPTIONS\n", to);
    print_option(to, &option_help);
    print_option(to, &option_version);
    print_lines(to, "NOTES", p->ending);
    print_end(to);
    for (size_t k = 0; k < p->command_count; k++)
        print(to, ".BR %s%s%s (1)%s\n", p->name, "-", p->commands[k]->name, k + 1 < p->command_count ? "," : "");
}

void man_command(FILE *to, const program *p, const command *c, const options_usage *usage) {
    print_title(to, p, "-", c->name, c->what);
    print(to, " %s\\fR %s\n.SH DESCRIPTION\n", c->name, usage->synopsis);
    print_paragraphs(to, usage->what);
    fputs(".SH OPTIONS\n", to);
    for (size_t k = 0; pages_option(usage, k); k++) print_option(to, pages_option(usage, k));
    print_lines(to, "EXAMPLES", usage->examples);
    print_end(to);
    print(to, ".BR %s (1)\n", p->name);
}
