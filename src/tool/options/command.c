/* SPDX-License-Identifier: Apache-2.0 */
#include "command.h"

#include "cellwalk.h"
#include "clock.h"
#include "printable.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- progress ---- */

static struct {
    const char *step;   /* NULL: there is no line */
    double start, last; /* seconds on the monotonic clock */
    volatile sig_atomic_t shown;
} line;

bool progress_is_shown(void) { return line.shown; }

void progress_show(const char *step, double share) {
    const double now = clock_seconds();
    if (line.step == NULL || strcmp(line.step, step) != 0) {
        progress_end();
        line.step = step;
        line.start = line.last = now;
    }
    if (now - line.last < (line.shown ? 0.1 : 0.5)) return;
    line.last = now;
    if (isatty(STDERR_FILENO) != 1) return;
    line.shown = true;
    const double passed = now - line.start;
    /* "\r" goes to the line's start, "\033[K" clears the rest of the old text. */
    fprintf(stderr, "\r%s %3.0f %%", step, 100 * share);
    if (share > 0.01) fprintf(stderr, ", %.0f s left", passed / share - passed);
    fprintf(stderr, "\033[K");
    fflush(stderr);
}

void progress_end(void) {
    if (line.shown) fprintf(stderr, "\r\033[K");
    fflush(stderr);
    line.step = NULL;
    line.shown = false;
}

/* ---- messages ---- */

static const char *running = "cellwalk"; /* the program's name */

/* All of the program's standard error but the line of progress comes this way. It takes that line's place. */
int command_fail(const char *name, const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    make_printable(text);
    progress_end();
    fprintf(stderr, "%s%s%s: %s\n", running, *name ? " " : "", name, text);
    return EXIT_FAILURE;
}

void command_wrote(const char *name, bool quiet, const char *file, double start, const char *format, ...) {
    char text[300];
    va_list arguments;
    if (quiet || file == NULL || strcmp(file, "-") == 0) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    command_note(name, "%s: %s, %.2f s", file, text, clock_seconds() - start);
}

void command_print_name(FILE *to, const char *name) { fprintf(to, "%s%s%s", running, *name ? " " : "", name); }

/* ---- the program ---- */

static void print_help(const program *p, FILE *to) {
    fprintf(to, "Usage: %s COMMAND [ARGUMENTS]\n%s\n\nCommands:\n", p->name, p->what);
    for (size_t k = 0; k < p->command_count; k++)
        fprintf(to, "  %-10s %s\n", p->commands[k]->name, p->commands[k]->what);
    fprintf(to, "%s", p->ending ? p->ending : "\n");
    fprintf(to, "More: '%s COMMAND --help' with examples, '%s --version'.\n", p->name, p->name);
}

static int unknown(const program *p, const char *word) {
    enum { NAMES_MAX = 32 };
    const char *names[NAMES_MAX];
    size_t count = 0;
    for (; count < p->command_count && count < NAMES_MAX; count++) names[count] = p->commands[count]->name;
    const char *meant = words_closest(word, names, count);
    command_fail("", "unknown %s '%s'%s%s%s", word[0] == '-' ? "option" : "command", word,
                 meant ? "; did you mean " : "", meant ? meant : "", meant ? "?" : "");
    fprintf(stderr, "Try '%s --help'.\n", p->name);
    return EXIT_USAGE;
}

static int run(const program *p, int argc, char **argv) {
    if (argc < 2) {
        print_help(p, stderr);
        return EXIT_USAGE;
    }
    const char *word = argv[1];
    if (strcmp(word, "--help") == 0 || strcmp(word, "-h") == 0) {
        print_help(p, stdout);
        return EXIT_SUCCESS;
    }
    if (strcmp(word, "--version") == 0) {
        printf("%s %s\n", p->name, CW_VERSION);
        if (p->about) p->about();
        return EXIT_SUCCESS;
    }
    for (size_t k = 0; k < p->command_count; k++)
        if (strcmp(word, p->commands[k]->name) == 0) return p->commands[k]->run(argc - 1, argv + 1);
    return unknown(p, word);
}

/* Where a standard stream is closed, the next file to be opened would take its number, and an output would have
 * messages written into it. The streams opened here instead fail as closed ones do. */
static void hold_streams(void) {
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0) open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

int program_main(const program *p, int argc, char **argv) {
    hold_streams();
    running = p->name;
    const int status = run(p, argc, argv);
    /* A failure to print counts as much as a failure to write a file. */
    const bool flushed = fflush(stdout) == 0; /* if an earlier one was not, errno no longer tells why */
    if ((flushed && !ferror(stdout)) || status != EXIT_SUCCESS) return status;
    struct pollfd out = {.fd = STDOUT_FILENO, .events = POLLOUT};
    if (poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0) return EXIT_FAILURE; /* a pipe that nobody reads on */
    fprintf(stderr, "%s: cannot write to standard output: %s\n", p->name, flushed ? "text is lost" : strerror(errno));
    return EXIT_FAILURE;
}
