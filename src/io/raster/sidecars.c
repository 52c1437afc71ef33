/* SPDX-License-Identifier: Apache-2.0 */
#include "sidecars.h"

#include "inputs.h"

#include <errno.h>
#include <limits.h>
#include <string.h>
#include <unistd.h>

/* False if there is no such file. A folder of that name is none. */
static bool find(char name[PATH_MAX], const char *ending, const char *path, struct stat *about) {
    const char *slash = strrchr(path, '/'), *point = strrchr(slash ? slash : path, '.');
    const int stem = ending[0] == '*' && point != NULL ? (int)(point - path) : (int)strlen(path);
    const int length = snprintf(name, PATH_MAX, "%.*s%s", stem, path, ending + (ending[0] == '*'));
    return length > 0 && length < PATH_MAX && lstat(name, about) == 0 && !S_ISDIR(about->st_mode);
}

bool io_sidecars_check(io_sidecar_list list, const char *path, bool replaces, io_error *error) {
    char name[PATH_MAX];
    struct stat about;
    for (; list != NULL && *list != NULL; list++) {
        if (!find(name, *list, path, &about)) continue;
        if (!replaces)
            return io_fail(error,
                           "%s: cannot write: %s, left of another file, would be read with it; remove that first", path,
                           name);
        if (io_inputs_have(&about))
            return io_fail(error, "%s: cannot write: %s belongs to it and is also an input", path, name);
    }
    return true;
}

bool io_sidecars_remove(io_sidecar_list list, const char *path, io_error *error) {
    char name[PATH_MAX];
    struct stat about;
    for (; list != NULL && *list != NULL; list++)
        if (find(name, *list, path, &about) && unlink(name) != 0 && errno != ENOENT)
            return io_fail(error, "%s: is written, but %s of the file before it cannot be removed: %s", path, name,
                           strerror(errno));
    return true;
}
