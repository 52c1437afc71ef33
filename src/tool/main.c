/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk: a table of subcommands. */

#include "cancel.h"
#include "cellwalk.h"
#include "command.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const command *const commands[] = {&command_render,   &command_trace, &command_shadow, &command_horizon,
                                          &command_viewshed, &command_los,   &command_info};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(FILE *to) {
    fputs("Usage: cellwalk COMMAND [ARGUMENTS]\n\nWhere does this ray hit this height field?\n\nCommands:\n", to);
    for (size_t k = 0; k < COMMAND_COUNT; k++) fprintf(to, "  %-9s %s\n", commands[k]->name, commands[k]->what);
    fputs(
        "\n'cellwalk COMMAND --help' explains a command and gives examples; 'cellwalk --version' says what this is.\n",
        to);
}

static int unknown(const char *word) {
    const char *names[COMMAND_COUNT];
    for (size_t k = 0; k < COMMAND_COUNT; k++) names[k] = commands[k]->name;
    const char *meant = closest_match(word, names, COMMAND_COUNT);
    fprintf(stderr, "cellwalk: unknown %s '%s'", word[0] == '-' ? "option" : "command", word);
    if (meant) fprintf(stderr, "; did you mean %s?", meant);
    fputs("\nTry 'cellwalk --help'.\n", stderr);
    return EXIT_USAGE;
}

static int run(int argc, char **argv) {
    if (argc < 2) {
        print_help(stderr);
        return EXIT_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
        print_help(stdout);
        return EXIT_SUCCESS;
    }
    if (strcmp(word, "--version") == 0) {
        puts("cellwalk " CW_VERSION);
        return EXIT_SUCCESS;
    }
    for (size_t k = 0; k < COMMAND_COUNT; k++)
        if (strcmp(word, commands[k]->name) == 0) return commands[k]->run(argc - 1, argv + 1);
    return unknown(word);
}

int main(int argc, char **argv) {
    cancel_install();
    int status = run(argc, argv);
    /* What could not be printed is a failure as much as what could not be written. */
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == EXIT_SUCCESS) {
        fprintf(stderr, "cellwalk: cannot write to standard output: %s\n", strerror(errno));
        status = EXIT_FAILURE;
    }
    if (status != EXIT_SUCCESS) cancel_finish();
    return status;
}
