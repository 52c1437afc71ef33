/* SPDX-License-Identifier: Apache-2.0 */
#include "plot.h"

#include "options.h"
#include "output.h"
#include "results.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const char *const usage =
    "Usage: cellwalk-bench plot [OPTIONS] --json FILE --out DIR\n"
    "\n"
    "Draws results of 'micro --json' or 'tradeoff' with gnuplot (Debian: gnuplot-nox) into the directory DIR:\n"
    "  speed-FIELD.svg  speed by class of rays, one picture a field\n"
    "  scaling.svg      speed over the size of the field, if the results have at least two sizes\n"
    "  building.svg     memory and building time over the size of the field, likewise\n"
    "or of 'tradeoff':\n"
    "  tradeoff.svg     speed against error\n"
    "The background is transparent and the colours can be read on white and on black. The same file gives the same\n"
    "pictures.\n"
    "\n"
    "Options:\n";

/* Runs gnuplot on the commands in the file, from its start. */
static bool run_gnuplot(FILE *commands, const char *name, io_error *error) {
    static char program[] = "gnuplot", no_settings[] = "-d", from_input[] = "-";
    char *const arguments[] = {program, no_settings, from_input, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child;
    if (fflush(commands) != 0 || lseek(fileno(commands), 0, SEEK_SET) != 0)
        return io_fail(error, "%s: cannot write gnuplot's commands: %s", name, strerror(errno));
    int status, failure = posix_spawn_file_actions_init(&actions);
    if (failure == 0) {
        posix_spawn_file_actions_adddup2(&actions, fileno(commands), STDIN_FILENO);
        failure = posix_spawnp(&child, program, &actions, NULL, arguments, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    if (failure == 0)
        while (waitpid(child, &status, 0) < 0)
            if (errno != EINTR) return io_fail(error, "%s: waiting for gnuplot: %s", name, strerror(errno));
    /* Where posix_spawn is a plain fork, a program that is not there shows as 127. */
    if (failure == ENOENT || (failure == 0 && WIFEXITED(status) && WEXITSTATUS(status) == 127))
        return io_fail(error, "%s: gnuplot, which draws it, is not installed (Debian: gnuplot-nox)", name);
    if (failure != 0) return io_fail(error, "%s: gnuplot does not start: %s", name, strerror(failure));
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return io_fail(error, "%s: gnuplot failed", name);
    return true;
}

/* What all pictures have in common. Greys and colours are of medium lightness: about 4 : 1 on white and on black. */
static void put_style(FILE *to, const char *path) {
    fputs("set terminal svg size 800,460 fixed noenhanced font 'sans-serif,12'\nset output '", to);
    for (; *path; path++) {
        fputc(*path, to);
        if (*path == '\'') fputc('\'', to); /* as gnuplot quotes it */
    }
    fputs("'\n"
          "set encoding utf8\n"
          "set border 3 linecolor '#7a7a7a'\nset tics nomirror textcolor '#7a7a7a'\n"
          "set grid ytics linecolor '#7a7a7a' linewidth 0.4 dashtype 3\n"
          "set key textcolor '#7a7a7a'\nset xlabel textcolor '#7a7a7a'\nset ylabel textcolor '#7a7a7a'\n"
          "set title textcolor '#7a7a7a'\n",
          to);
}

typedef enum picture { SPEED, SCALING, BUILDING, TRADEOFF } picture;

/* *drawn says whether the results have what the picture takes. */
static bool draw(picture p, const json_t *lines, const char *field, const char *path, bool *drawn, io_error *error) {
    io_output out = {0};
    FILE *commands = tmpfile();
    if (commands == NULL) return io_fail(error, "%s: no temporary file: %s", path, strerror(errno));
    bool good = io_output_open(&out, path, error);
    *drawn = false;
    if (good) {
        put_style(commands, out.temporary);
        *drawn = p == SPEED      ? plot_speed(commands, lines, field)
                 : p == SCALING  ? plot_scaling(commands, lines)
                 : p == BUILDING ? plot_building(commands, lines)
                                 : plot_tradeoff(commands, lines);
        if (*drawn) good = run_gnuplot(commands, path, error) && io_output_commit(&out, error);
    }
    io_output_discard(&out);
    fclose(commands);
    if (good && *drawn) printf("%s\n", path);
    return good;
}

bool plot_all(const json_t *lines, const char *directory, io_error *error) {
    enum { FIELDS_MAX = 32 };
    const char *fields[FIELDS_MAX];
    const size_t count = results_distinct(lines, "field", fields, FIELDS_MAX);
    char path[4096];
    bool good = true, drawn;
    size_t pictures = 0;
    if (mkdir(directory, 0777) != 0 && errno != EEXIST) return io_fail(error, "%s: %s", directory, strerror(errno));
    for (size_t k = 0; good && k < count; k++) {
        snprintf(path, sizeof path, "%s/speed-%s.svg", directory, fields[k]);
        good = draw(SPEED, lines, fields[k], path, &drawn, error);
        pictures += good && drawn;
    }
    snprintf(path, sizeof path, "%s/scaling.svg", directory);
    good = good && draw(SCALING, lines, NULL, path, &drawn, error);
    pictures += good && drawn;
    snprintf(path, sizeof path, "%s/building.svg", directory);
    good = good && draw(BUILDING, lines, NULL, path, &drawn, error);
    pictures += good && drawn;
    return good && (pictures > 0 || io_fail(error, "the results have nothing to draw"));
}

bool plot_tradeoff_file(const json_t *lines, const char *path, io_error *error) {
    bool drawn;
    return draw(TRADEOFF, lines, NULL, path, &drawn, error) &&
           (drawn || io_fail(error, "%s: the results have nothing to draw", path));
}

static bool tradeoff_into(const json_t *lines, const char *directory, io_error *error) {
    char path[4096];
    if (mkdir(directory, 0777) != 0 && errno != EEXIST) return io_fail(error, "%s: %s", directory, strerror(errno));
    snprintf(path, sizeof path, "%s/tradeoff.svg", directory);
    return plot_tradeoff_file(lines, path, error);
}

static bool run(const char *json, const char *directory, io_error *error) {
    json_t *lines = results_read(json, error);
    if (lines == NULL) return false;
    const char *command = results_text(json_array_get(lines, 0), "command");
    const bool tradeoff = strcmp(command, "tradeoff") == 0;
    const bool good =
        (tradeoff || strcmp(command, "micro") == 0 ||
         io_fail(error, "%s:1: results of '%s': only those of micro and tradeoff can be drawn", json, command)) &&
        (tradeoff ? tradeoff_into(lines, directory, error) : plot_all(lines, directory, error));
    json_decref(lines);
    return good;
}

int plot_main(char **arguments, int count) {
    const char *json = NULL, *directory = NULL;
    const option options[] = {
        {"--json", "FILE", "the results: what micro --json wrote, or tradeoff.json", OPTION_TEXT, &json, 0, 0},
        {"--out", "DIR", "where to put the pictures", OPTION_TEXT, &directory, 0, 0},
    };
    const option_frame frame = {
        .command = "plot", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    bool good = true;
    if (good && json == NULL) good = io_fail(&error, "--json: the file of results is missing");
    if (good && directory == NULL) good = io_fail(&error, "--out: the directory is missing");
    if (!good) return options_misused("plot", &error);
    if (run(json, directory, &error)) return EXIT_SUCCESS;
    return options_failed("plot", &error);
}
