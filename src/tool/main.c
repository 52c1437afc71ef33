/* SPDX-License-Identifier: Apache-2.0 */
/* The program cellwalk: a table of subcommands, and signals. */

#include "command.h"
#include "gdal_host.h"
#include "image.h"
#include "inputs.h"
#include "output.h"
#include "raster_out.h"
#include "reference.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

extern const command command_horizon, command_info, command_los, command_render, command_shadow, command_sun,
    command_trace, command_viewshed, command_visibility;

static const command *const commands[] = {&command_render,     &command_trace,   &command_shadow,
                                          &command_sun,        &command_horizon, &command_viewshed,
                                          &command_visibility, &command_los,     &command_info};

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

/* The commands by task: the whole help fits on a screen of 24 lines. */
static const char tasks[] = "By task, for a terrain dem.tif with places X,Y on its map:\n"
                            "  its contents     cellwalk info dem.tif\n"
                            "  cast shadow      cellwalk shadow dem.tif --sun 225,30 -o shadow.tif\n"
                            "  hours of sun     cellwalk sun dem.tif --date 2024-06-21 -o hours.tif\n"
                            "  visible area     cellwalk viewshed dem.tif --from X,Y -o seen.tif\n"
                            "  how much is seen cellwalk visibility dem.tif -o km2.tif\n"
                            "  line of sight    cellwalk los dem.tif X,Y,2 X,Y,2\n"
                            "  sky-view factor  cellwalk horizon dem.tif --svf -o sky.tif\n"
                            "  a picture        cellwalk render dem.tif -o view.png\n"
                            "  hits of rays     cellwalk trace dem.tif lidar.npy --user -o hits.npy\n";

/* Leaves no output, and stops a script that runs the program. A container's first process cannot end by a signal. */
static void on_signal(int number) {
    const char *text = progress_is_shown() ? "\r\033[Kcellwalk: interrupted\n" : "cellwalk: interrupted\n";
    io_output_discard_all();
    const ssize_t told = write(gdal_host_messages(), text, strlen(text));
    (void)told; /* no other place for a message is left */
    signal(number, SIG_DFL);
    raise(number);
    _exit(128 + number);
}

static void handle_signals(void) {
    static const int asked[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
    struct sigaction old, action = {.sa_handler = on_signal, .sa_flags = SA_NODEFER}; /* a raise takes effect at once */
    for (size_t k = 0; k < sizeof asked / sizeof *asked; k++)
        /* nohup and background jobs of simple shells start programs with these ignored: so they stay. */
        if (sigaction(asked[k], NULL, &old) == 0 && old.sa_handler != SIG_IGN) sigaction(asked[k], &action, NULL);
    /* Writing fails with EFBIG or EPIPE instead. */
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGPIPE, SIG_IGN);
}

int main(int argc, char **argv) {
    static const program cellwalk = {
        .name = "cellwalk",
        .what = "Shadow, visibility and horizons of terrain, and where rays hit a height field.",
        .commands = commands,
        .command_count = sizeof commands / sizeof commands[0],
        .ending = tasks,
        .about = print_parts};
    cw_reference_add();
    handle_signals();
    io_inputs_protect();
    gdal_host_install();
    return program_main(&cellwalk, argc, argv);
}
