/* SPDX-License-Identifier: Apache-2.0 */
#include "harness/folder.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool folder_make(const char *path, io_error *error) {
    char *copy = strdup(path);
    if (copy == NULL) return io_fail(error, "out of memory");
    bool good = true;
    for (char *end = copy + 1; good; end++) {
        const char held = *end;
        if (held != '/' && held != '\0') continue;
        *end = '\0';
        struct stat there;
        if (mkdir(copy, 0777) != 0 && errno != EEXIST)
            good = io_fail(error, "folder %s: cannot make %s: %s", path, copy, strerror(errno));
        else if (stat(copy, &there) != 0 || !S_ISDIR(there.st_mode))
            good = io_fail(error, "folder %s: %s is not a folder", path, copy);
        *end = held;
        if (held == '\0') break;
    }
    free(copy);
    return good;
}

bool folder_open(io_output *out, const char *folder, const char *name, io_error *error) {
    char *path = NULL;
    if (!folder_make(folder, error)) return false;
    if (asprintf(&path, "%s/%s", folder, name) < 0) return io_fail(error, "out of memory");
    const bool good = io_output_open(out, path, error);
    free(path);
    return good;
}
