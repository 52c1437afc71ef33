/* SPDX-License-Identifier: Apache-2.0 */
#include "instructions/callgrind.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { WORDS_MAX = 8, OPTIONS = 10, OPTIONS_MAX = OPTIONS + 4 };

int guard_callgrind(char *const *options, char *const *workload, const char *runs, const char *errors,
                    const char *profile) {
    static char valgrind[] = "valgrind", quiet[] = "-q", tool[] = "--tool=callgrind", off[] = "--collect-atstart=no",
                toggle[] = "--toggle-collect=guard_trace", dump[] = "--dump-after=guard_trace",
                combine[] = "--combine-dumps=yes", names[] = "--compress-strings=no", lines[] = "--compress-pos=no";
    char out[4096];
    snprintf(out, sizeof out, "--callgrind-out-file=%s", profile);
    char *arguments[OPTIONS_MAX + WORDS_MAX + 1] = {valgrind, quiet,   tool,  off,   toggle,
                                                    dump,     combine, names, lines, out};
    size_t count = OPTIONS;
    for (; options && *options && count < OPTIONS_MAX; options++) arguments[count++] = *options;
    for (size_t k = 0; k < WORDS_MAX && workload[k]; k++) arguments[count++] = workload[k];
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status, failure = posix_spawn_file_actions_init(&actions);
    if (failure == 0) {
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, runs, O_WRONLY | O_CREAT | O_TRUNC, 0666);
        if (errors)
            posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, errors, O_WRONLY | O_CREAT | O_TRUNC, 0666);
        failure = posix_spawnp(&child, valgrind, &actions, NULL, arguments, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    if (failure == ENOENT) return 127;
    if (failure != 0) {
        errno = failure;
        return -1;
    }
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : EXIT_FAILURE; /* where posix_spawn is a plain fork, 127 too */
}
