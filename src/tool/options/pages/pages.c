/* SPDX-License-Identifier: Apache-2.0 */
#include "pages.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- shared by the writers ---- */

page_value pages_value(const option_spec *o) {
    if (o->value == NULL) return PAGE_NOTHING;
    if (o->names) return o->kind == OPTION_LIST ? PAGE_WORDS : PAGE_WORD;
    const bool file = strchr(o->value, '.') || strcmp(o->value, "FILE") == 0 || strcmp(o->value, "FOLDER") == 0 ||
                      strcmp(o->value, "IMAGE") == 0;
    return file ? PAGE_FILE : PAGE_ANYTHING;
}

const option_spec *pages_option(const options_usage *usage, size_t k) {
    return k < usage->option_count ? &usage->options[k] : k == usage->option_count ? &option_help : NULL;
}

void pages_brief(const option_spec *o, char brief[PAGE_BRIEF]) {
    size_t length = 0, end = 0; /* of the last whole word outside brackets */
    bool inside = false;
    for (const char *c = o->help;; c++) {
        const bool over = *c == '\0' || (strchr(";:.", *c) && strchr(" \n", c[1]));
        if (!inside && (over || *c == ' ' || *c == '\n')) end = length;
        if (over || length == PAGE_BRIEF - 1) break;
        inside = *c == '(' || (inside && *c != ')');
        brief[length++] = *c;
        if (*c == '\n') brief[length - 1] = ' ';
    }
    while (end > 0 && strchr(" ,", brief[end - 1])) end--;
    brief[end] = '\0';
}

void pages_print_names(FILE *to, const option_spec *o, const char *between) {
    for (size_t k = 0; o->names && o->names(k); k++) fprintf(to, "%s%s", k ? between : "", o->names(k));
}

void pages_print_quoted(FILE *to, const char *text, const char *special) {
    for (; *text; text++) {
        if (strchr(special, *text)) putc('\\', to);
        if (*text == '\'')
            fputs("'\\''", to);
        else
            putc(*text, to);
    }
}

void pages_print_function(FILE *to, const program *p) {
    for (const char *c = p->name; *c; c++) putc(*c == '-' ? '_' : *c, to);
}

/* ---- files ---- */

typedef struct pages {
    const program *program;
    const page_writer *writer;
    const char *folder;
    const command *command;
    FILE *file; /* NULL: none is open */
    bool good;
} pages;

static void fail(pages *g, const char *path) {
    command_fail("", "%s: %s", path, strerror(errno));
    g->good = false;
}

/* Makes all folders on the way to a file. */
static void make_folders(char *path) {
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        mkdir(path, 0755); /* opening the file finds out if that failed */
        *slash = '/';
    }
}

/* The file's name ends in after the program's and, if there is one, the subcommand's. */
static void open_file(pages *g, const char *subcommand) {
    char path[PATH_MAX];
    const int length = snprintf(path, sizeof path, "%s/%s%s%s%s%s", g->folder, g->writer->before, g->program->name,
                                subcommand ? "-" : "", subcommand ? subcommand : "", g->writer->after);
    if (length >= PATH_MAX) {
        errno = ENAMETOOLONG;
        fail(g, g->folder);
        return;
    }
    make_folders(path);
    g->file = fopen(path, "w");
    if (g->file == NULL) fail(g, path);
}

static void close_file(pages *g) {
    if (g->file == NULL) return;
    const bool written = !ferror(g->file);
    if (fclose(g->file) != 0 || !written) fail(g, g->folder);
    g->file = NULL;
}

static void look(const options_usage *usage, void *context) {
    pages *g = context;
    if (g->writer->each) {
        close_file(g);
        open_file(g, g->command->name);
    }
    if (g->file) g->writer->command(g->file, g->program, g->command, usage);
}

static bool write_pages(const program *p, const page_writer *writer, const char *folder) {
    pages g = {.program = p, .writer = writer, .folder = folder, .good = true};
    open_file(&g, NULL);
    if (g.file) writer->head(g.file, p);
    options_show(look, &g);
    for (size_t k = 0; g.good && k < p->command_count; k++) {
        char name[64], *argv[] = {name, NULL};
        snprintf(name, sizeof name, "%s", p->commands[k]->name);
        g.command = p->commands[k];
        p->commands[k]->run(1, argv);
    }
    options_show(NULL, NULL);
    if (g.file && writer->tail) writer->tail(g.file, p);
    close_file(&g);
    return g.good;
}

int pages_write(const program *p, const char *folder) {
    static const page_writer *const writers[] = {&pages_man, &pages_bash, &pages_zsh, &pages_fish};
    for (size_t k = 0; k < sizeof writers / sizeof writers[0]; k++)
        if (!write_pages(p, writers[k], folder)) return EXIT_FAILURE;
    return EXIT_SUCCESS;
}
