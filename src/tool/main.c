/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk: a table of subcommands. */

#include "cancel.h"
#include "commands.h"
#include "inputs.h"

#include <stdlib.h>

static const command *const commands[] = {&command_render,   &command_trace, &command_shadow, &command_horizon,
                                          &command_viewshed, &command_los,   &command_info};

int main(int argc, char **argv) {
    static const program cellwalk = {.name = "cellwalk",
                                     .what = "Where does this ray hit this height field?",
                                     .commands = commands,
                                     .command_count = sizeof commands / sizeof commands[0]};
    cancel_install();
    io_inputs_protect();
    const int status = program_main(&cellwalk, argc, argv);
    if (status != EXIT_SUCCESS) cancel_finish();
    return status;
}
