/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk: a table of subcommands. */

#include "cancel.h"
#include "commands.h"
#include "image.h"
#include "inputs.h"
#include "raster_out.h"

#include <stdio.h>
#include <stdlib.h>

static const command *const commands[] = {&command_render,   &command_trace, &command_shadow, &command_horizon,
                                          &command_viewshed, &command_los,   &command_info};

/* Optional parts, tried: GDAL may have been built and not be found, or not load. */
static void print_parts(void) {
    io_error reason;
    if (io_raster_can_write("any.tif", 1, &reason))
        puts("GDAL     yes");
    else
        printf("GDAL     no: %s\n", reason.text);
    printf("OpenEXR  %s\n", io_image_can_write("any.exr", NULL) ? "yes" : "no");
    printf("libpng   %s\n", io_image_can_write("any.png", NULL) ? "yes" : "no");
}

int main(int argc, char **argv) {
    static const program cellwalk = {.name = "cellwalk",
                                     .what = "Where does this ray hit this height field?",
                                     .commands = commands,
                                     .command_count = sizeof commands / sizeof commands[0],
                                     .about = print_parts};
    cancel_install();
    io_inputs_protect();
    const int status = program_main(&cellwalk, argc, argv);
    if (status != EXIT_SUCCESS) cancel_finish();
    return status;
}
