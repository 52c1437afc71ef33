/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk-bench. */

#include "harness/harness_run.h"
#include "inputs.h"
#include "output.h"
#include "reference.h"

#include <signal.h>
#include <unistd.h>

static const command *const commands[] = {&command_measure, &command_table};

/* Ctrl-C leaves no unfinished file behind, and the exit status names the signal. */
static void stop(int number) {
    io_output_discard_all();
    signal(number, SIG_DFL);
    raise(number);
    _exit(128 + number); /* the first process of a container cannot end by a signal */
}

int main(int argc, char **argv) {
    static const program bench = {.name = "cellwalk-bench",
                                  .what = "Measures the speed and the errors of Cellwalk's kernels, beside Embree.",
                                  .commands = commands,
                                  .command_count = sizeof commands / sizeof commands[0],
                                  .ending = "A first look:\n  cellwalk-bench measure first\n"};
    signal(SIGINT, stop);
    signal(SIGTERM, stop);
    cw_reference_add();
    io_inputs_protect();
    run_record_begin(argv + 1, argc - 1);
    return program_main(&bench, argc, argv);
}
