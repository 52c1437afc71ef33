/* SPDX-License-Identifier: Apache-2.0 */
#include "pages.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct pages {
    const program *program;
    const char *folder;
    const command *command; /* whose table is looked at */
    FILE *bash;
    bool good;
} pages;

static void fail(pages *g, const char *path) {
    command_fail("", "%s: %s", path, strerror(errno));
    g->good = false;
}

/* The file's name has between and last after the program's. */
static FILE *open_page(pages *g, const char *folder, const char *between, const char *last) {
    char path[PATH_MAX];
    const int length = snprintf(path, sizeof path, "%s/%s/%s%s%s", g->folder, folder, g->program->name, between, last);
    for (char *slash = path; length < PATH_MAX && (slash = strchr(slash + 1, '/')) != NULL; *slash = '/') {
        *slash = '\0';
        mkdir(path, 0755); /* opening the file finds out if that failed */
    }
    errno = ENAMETOOLONG;
    FILE *file = length < PATH_MAX ? fopen(path, "w") : NULL;
    if (file == NULL) fail(g, path);
    return file;
}

static void close_page(pages *g, FILE *file) {
    if (file == NULL) return;
    const bool written = !ferror(file);
    if (fclose(file) != 0 || !written) fail(g, g->folder);
}

static void write_command(const options_usage *usage, void *context) {
    pages *g = context;
    char last[64];
    snprintf(last, sizeof last, "%s.1", g->command->name);
    FILE *man = open_page(g, "man/man1", "-", last);
    if (man) man_command(man, g->program, g->command, usage);
    close_page(g, man);
    bash_command(g->bash, g->command, usage);
}

int pages_write(const program *p, const char *folder) {
    pages g = {.program = p, .folder = folder, .good = true};
    FILE *man = open_page(&g, "man/man1", "", ".1");
    if (man) man_program(man, p);
    close_page(&g, man);
    g.bash = open_page(&g, "bash-completion/completions", "", "");
    if (!g.good) return EXIT_FAILURE;
    bash_head(g.bash, p);
    options_show(write_command, &g);
    for (size_t k = 0; g.good && k < p->command_count; k++) {
        char name[64], *argv[] = {name, NULL};
        snprintf(name, sizeof name, "%s", p->commands[k]->name);
        g.command = p->commands[k];
        p->commands[k]->run(1, argv);
    }
    options_show(NULL, NULL);
    bash_tail(g.bash, p);
    close_page(&g, g.bash);
    return g.good ? EXIT_SUCCESS : EXIT_FAILURE;
}
