/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-bench. */

#include "commands.h"
#include "harness/run.h"
#include "output.h"

#include <cellwalk.h>

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const command *const commands[] = {&command_table, &command_micro, &command_tradeoff, &command_compare};

/* Ctrl-C leaves no unfinished file behind, and the exit status tells the shell what happened. */
static void stop(int number) {
    io_output_discard_all();
    signal(number, SIG_DFL);
    raise(number);
}

/* The library takes a misspelt bound for none, and figures would carry the wrong label. */
static bool knows_isa(const char *name) {
    for (int k = CW_ISA_SCALAR; k <= CW_ISA_AVX512; k++)
        if (strcmp(name, cw_isa_name((cw_isa)k)) == 0) return true;
    fprintf(stderr, "cellwalk-bench: CELLWALK_ISA '%s' is unknown; there are scalar, sse4.2, avx2, avx512\n", name);
    return false;
}

int main(int argc, char **argv) {
    static const program bench = {.name = "cellwalk-bench",
                                  .what = "How fast does Cellwalk find where rays hit, and how exactly, beside Embree?",
                                  .commands = commands,
                                  .command_count = sizeof commands / sizeof commands[0],
                                  .ending = "A first look:\n\n  cellwalk-bench micro --field 257 --seconds 10\n"};
    signal(SIGINT, stop);
    signal(SIGTERM, stop);
    if (getenv("CELLWALK_ISA") && !knows_isa(getenv("CELLWALK_ISA"))) return 2;
    run_record_begin(argv + 1, argc - 1);
    return program_main(&bench, argc, argv);
}
