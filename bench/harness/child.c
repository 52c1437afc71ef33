/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/child.h"

#include <errno.h>
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

int child_run(const char *const *argv, const char *out, const char *err) {
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status, failure = posix_spawn_file_actions_init(&actions);
    fflush(stdout);
    if (failure == 0) {
        const int flags = O_WRONLY | O_CREAT | O_TRUNC;
        if (out) posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out, flags, 0666);
        if (err) posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err, flags, 0666);
        failure = posix_spawnp(&child, argv[0], &actions, NULL, (char *const *)argv, environ);
        posix_spawn_file_actions_destroy(&actions);
    }
    if (failure == ENOENT) return 127;
    if (failure != 0) {
        errno = failure;
        return -1;
    }
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); /* a fork that could not: 127, too */
}
