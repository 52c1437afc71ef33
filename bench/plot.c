/* SPDX-License-Identifier: Apache-2.0 */
#include "plot.h"

#include "folder.h"
#include "options.h"
#include "output.h"
#include "results.h"

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

static const char *const usage =
    "Usage: cellwalk-bench plot [OPTIONS] --json FILE --out DIR\n"
    "       cellwalk-bench plot [OPTIONS] --data FOLDER --out DIR\n"
    "\n"
    "Draws results of 'micro --json', 'table' and 'tradeoff' with gnuplot (Debian: gnuplot-nox) into the directory "
    "DIR:\n"
    "  speed-FIELD.svg  speed by class of rays, one picture a field\n"
    "  scaling.svg      speed over the size of the field, if the results have at least two sizes\n"
    "  building.svg     memory and building time over the size of the field, likewise\n"
    "  threads.svg      speed of several threads over one, if the results have them\n"
    "  widths.svg       speed over the width of packets, if they have several\n"
    "  coursework.svg   of table: time over that of a triangle mesh, beside the coursework's\n"
    "  tradeoff.svg     of tradeoff: speed against error\n"
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

typedef bool plot_of_all(FILE *to, const json_t *lines);
static const struct {
    const char *command, *file; /* of whose results; without .svg */
    plot_of_all *draw;
} pictures[] = {
    {"micro", "scaling", plot_scaling},       {"micro", "building", plot_building},
    {"micro", "threads", plot_threads},       {"micro", "widths", plot_widths},
    {"table", "coursework", plot_coursework}, {"tradeoff", "tradeoff", plot_tradeoff},
};
enum { PICTURES = sizeof pictures / sizeof pictures[0] };

/* *drawn says whether the results have what the picture takes. */
static bool draw(plot_of_all *picture, const json_t *lines, const char *field, const char *path, bool *drawn,
                 io_error *error) {
    io_output out = {0};
    FILE *commands = tmpfile();
    if (commands == NULL) return io_fail(error, "%s: no temporary file: %s", path, strerror(errno));
    bool good = io_output_open(&out, path, error);
    *drawn = false;
    const char *by_name = good ? io_output_temporary(&out) : NULL;
    if (good && by_name == NULL) good = io_fail(error, "%s: cannot write: %s", path, strerror(errno));
    if (good) {
        put_style(commands, by_name);
        *drawn = picture ? picture(commands, lines) : plot_speed(commands, lines, field);
        if (*drawn) good = run_gnuplot(commands, path, error) && io_output_commit(&out, error);
    }
    io_output_discard(&out);
    fclose(commands);
    if (good && *drawn) printf("%s\n", path);
    return good;
}

/* Draws those pictures whose names stand in the list, or all if it is NULL. */
static bool draw_some(const json_t *lines, const char *directory, const char *list, size_t *count, io_error *error) {
    enum { FIELDS_MAX = 32 };
    const char *fields[FIELDS_MAX];
    const size_t field_count = results_distinct(lines, "field", fields, FIELDS_MAX);
    const char *command = results_text(json_array_get(lines, 0), "command");
    const bool speeds = strcmp(command, "micro") == 0 && (!list || strstr(list, "speed"));
    char path[4096];
    bool good = folder_make(directory, error), drawn;
    for (size_t k = 0; good && speeds && k < field_count; k++) {
        snprintf(path, sizeof path, "%s/speed-%s.svg", directory, fields[k]);
        good = draw(NULL, lines, fields[k], path, &drawn, error);
        *count += good && drawn;
    }
    for (size_t k = 0; good && k < PICTURES; k++) {
        if (strcmp(pictures[k].command, command) != 0 || (list && !strstr(list, pictures[k].file))) continue;
        snprintf(path, sizeof path, "%s/%s.svg", directory, pictures[k].file);
        good = draw(pictures[k].draw, lines, NULL, path, &drawn, error);
        *count += good && drawn;
    }
    return good;
}

bool plot_all(const json_t *lines, const char *directory, io_error *error) {
    size_t count = 0;
    return draw_some(lines, directory, NULL, &count, error) &&
           (count > 0 || io_fail(error, "the results have nothing to draw"));
}

bool plot_tradeoff_file(const json_t *lines, const char *path, io_error *error) {
    bool drawn;
    return draw(plot_tradeoff, lines, NULL, path, &drawn, error) &&
           (drawn || io_fail(error, "%s: the results have nothing to draw", path));
}

static json_t *read_for_plot(const char *json, io_error *error) {
    json_t *lines = results_read(json, error);
    const char *command = lines ? results_text(json_array_get(lines, 0), "command") : "";
    if (lines == NULL || strcmp(command, "micro") == 0 || strcmp(command, "table") == 0 ||
        strcmp(command, "tradeoff") == 0)
        return lines;
    io_fail(error, "%s:1: results of '%s': only those of micro, table and tradeoff can be drawn", json, command);
    json_decref(lines);
    return NULL;
}

static bool plot_file(const char *json, const char *directory, io_error *error) {
    json_t *lines = read_for_plot(json, error);
    const bool good = lines && plot_all(lines, directory, error);
    json_decref(lines);
    return good;
}

/* The files that cellwalk-bench measure makes, and what is drawn of each. Of the speeds the first one that is there: the
 * widest instruction set. */
bool plot_folder(const char *folder, const char *directory, io_error *error) {
    static const struct {
        const char *file, *pictures;
    } sources[] = {
        {"speed-avx512.json", "speed scaling"},
        {"speed-avx2.json", "speed scaling"},
        {"speed-sse42.json", "speed scaling"},
        {"building.json", "building"},
        {"threads.json", "threads"},
        {"widths.json", "widths"},
        {"scenes/table.json", "coursework"},
        {"tradeoff/tradeoff.json", "tradeoff"},
    };
    bool good = true, speeds = false;
    size_t count = 0;
    for (size_t k = 0; good && k < sizeof sources / sizeof sources[0]; k++) {
        const bool speed = strncmp(sources[k].file, "speed", 5) == 0;
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", folder, sources[k].file);
        if ((speed && speeds) || access(path, F_OK) != 0) continue;
        json_t *lines = read_for_plot(path, error);
        good = lines && draw_some(lines, directory, sources[k].pictures, &count, error);
        speeds = speeds || speed;
        json_decref(lines);
    }
    return good && (count > 0 || io_fail(error, "%s: has no results to draw", folder));
}

int plot_main(char **arguments, int count) {
    const char *json = NULL, *data = NULL, *directory = NULL;
    const option options[] = {
        {"--json", "FILE", "the results: what micro --json, table or tradeoff wrote", OPTION_TEXT, &json, 0, 0},
        {"--data", "FOLDER", "instead: the folder of files that measure made", OPTION_TEXT, &data, 0, 0},
        {"--out", "DIR", "where to put the pictures", OPTION_TEXT, &directory, 0, 0},
    };
    const option_frame frame = {
        .command = "plot", .usage = usage, .options = options, .option_count = sizeof options / sizeof options[0]};
    int status;
    if (!options_begin(&frame, arguments, &count, &status)) return status;
    io_error error = {{0}};
    bool good = true;
    if ((json == NULL) == (data == NULL))
        good = io_fail(&error, "either --json with a file of results or --data with a folder of them is needed");
    if (good && directory == NULL) good = io_fail(&error, "--out: the directory is missing");
    if (!good) return options_misused("plot", &error);
    if (json ? plot_file(json, directory, &error) : plot_folder(data, directory, &error)) return EXIT_SUCCESS;
    return options_failed("plot", &error);
}
