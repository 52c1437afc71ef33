/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-bench. */

#include "accuracy/run.h"
#include "harness/measure.h"
#include "harness/run_record.h"
#include "micro/compare.h"
#include "micro/micro.h"
#include "output.h"
#include "scenes/table.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct command {
    const char *name, *what;
    int (*run)(char **arguments, int count);
} command;

static const command commands[] = {
    {"table", "renders the six scenes along every path and prints the performance table", table_main},
    {"micro", "times kernels and Embree on classes of rays and fields", micro_main},
    {"measure", "makes every file of results that the papers quote", measure_main},
    {"tradeoff", "holds speed against error for every mode of accuracy", tradeoff_main},
    {"compare", "says what changed between two runs of micro", compare_main},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(FILE *to) {
    fputs(
        "Usage: cellwalk-bench COMMAND [ARGUMENTS]\n\nHow fast does Cellwalk find where rays hit, and against whom?\n\n"
        "Commands:\n",
        to);
    for (size_t k = 0; k < COMMAND_COUNT; k++) fprintf(to, "  %-8s %s\n", commands[k].name, commands[k].what);
    fputs("\n'cellwalk-bench COMMAND --help' explains a command. A first look:\n\n"
          "  cellwalk-bench micro --field 257 --seconds 10\n",
          to);
}

/* Ctrl-C leaves no unfinished file behind, and the exit status tells the shell what happened. */
static void stop(int number) {
    io_output_discard_all();
    signal(number, SIG_DFL);
    raise(number);
}

int main(int argc, char **argv) {
    signal(SIGINT, stop);
    signal(SIGTERM, stop);
    if (argc < 2) {
        print_help(stderr);
        return 2;
    }
    run_record_begin(argv + 1, argc - 1);
    const char *word = argv[1];
    if (strncmp(word, "--", 2) == 0) word += 2; /* --compare and --help as well as compare and help */
    if (strcmp(word, "help") == 0 || strcmp(argv[1], "-h") == 0) {
        print_help(stdout);
        return EXIT_SUCCESS;
    }
    for (size_t k = 0; k < COMMAND_COUNT; k++) {
        if (strcmp(word, commands[k].name) != 0) continue;
        int status = commands[k].run(argv + 2, argc - 2);
        if ((fflush(stdout) != 0 || ferror(stdout)) && status == EXIT_SUCCESS) {
            fprintf(stderr, "cellwalk-bench: cannot write to standard output: %s\n", strerror(errno));
            status = EXIT_FAILURE;
        }
        return status;
    }
    fprintf(stderr, "cellwalk-bench: unknown command '%s'\nTry 'cellwalk-bench --help'.\n", argv[1]);
    return 2;
}
