/* SPDX-License-Identifier: Apache-2.0 */
#include "target.h"

#include "linux.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#if CELLWALK_LINUX
#include <sys/xattr.h>
#endif

int io_target_descriptor(const char *path) {
    static const char *const folders[] = {"/dev/fd/", "/proc/self/fd/"};
    if (strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0) return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0) return STDERR_FILENO;
    for (size_t k = 0; k < sizeof folders / sizeof folders[0]; k++) {
        const char *digits = path + strlen(folders[k]);
        if (strncmp(path, folders[k], strlen(folders[k])) != 0 || strlen(digits) == 0 || strlen(digits) > 9) continue;
        if (strspn(digits, "0123456789") == strlen(digits)) return atoi(digits);
    }
    return -1;
}

const char *io_target_base(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static bool stat_folder(const char *path, struct stat *about) {
    char folder[PATH_MAX];
    const int length = (int)(io_target_base(path) - path);
    errno = ENAMETOOLONG;
    return snprintf(folder, PATH_MAX, "%.*s", length > 0 ? length : 2, length > 0 ? path : "./") < PATH_MAX &&
           stat(folder, about) == 0;
}

/* The rule of Linux's fs.protected_symlinks, which opening by name would obey: in a shared folder anybody can put a link
 * where an output is expected. */
static bool may_follow(const char *path) {
    struct stat link, folder;
    if (lstat(path, &link) != 0 || !stat_folder(path, &folder)) return false;
    const bool shared = (folder.st_mode & (S_ISVTX | S_IWOTH)) == (S_ISVTX | S_IWOTH);
    if (!shared || link.st_uid == geteuid() || link.st_uid == folder.st_uid) return true;
    errno = EACCES;
    return false;
}

char *io_target_follow(const char *path) {
    enum { LINKS_MAX = 40 };
    char name[PATH_MAX], link[PATH_MAX];
    if (snprintf(name, sizeof name, "%s", path) >= (int)sizeof name) {
        errno = ENAMETOOLONG;
        return NULL;
    }
    for (int k = 0; k < LINKS_MAX; k++) {
        const ssize_t length = io_target_descriptor(name) >= 0 ? -1 : readlink(name, link, sizeof link - 1);
        if (length < 0) return strdup(name);
        if (!may_follow(name)) return NULL;
        link[length] = '\0';
        char *base = link[0] == '/' ? name : name + (io_target_base(name) - name);
        if ((size_t)length >= sizeof name - (size_t)(base - name)) {
            errno = ENAMETOOLONG;
            return NULL;
        }
        memcpy(base, link, (size_t)length + 1);
    }
    errno = ELOOP;
    return NULL;
}

void io_target_identify(io_target_identity *i, const char *target, bool direct, const struct stat *about) {
    struct stat folder;
    *i = (io_target_identity){.base = io_target_base(target)};
    if (about != NULL && !S_ISCHR(about->st_mode)) {
        i->device = about->st_dev;
        i->inode = about->st_ino;
    }
    if (direct || !stat_folder(target, &folder)) return;
    i->folder_device = folder.st_dev;
    i->folder_inode = folder.st_ino;
}

bool io_target_same(const io_target_identity *a, const io_target_identity *b) {
    return (a->inode != 0 && a->inode == b->inode && a->device == b->device) ||
           (a->folder_inode != 0 && a->folder_inode == b->folder_inode && a->folder_device == b->folder_device &&
            strcmp(a->base, b->base) == 0);
}

#if CELLWALK_LINUX
/* With a list, the mode's bits for the group are the most that the list grants: without the list, they would be the
 * group's own. A new file may have inherited a list from its folder. */
static bool keep_list(int fd, const char *old_path) {
    static const char list[] = "system.posix_acl_access";
    char bytes[4096];
    const ssize_t size = getxattr(old_path, list, bytes, sizeof bytes);
    if (size > 0) return fsetxattr(fd, list, bytes, (size_t)size, 0) == 0;
    if (size < 0 && errno != ENODATA && errno != ENOTSUP) return false;
    return fremovexattr(fd, list) == 0 || errno == ENODATA || errno == ENOTSUP;
}
#else
static bool keep_list(int fd, const char *old_path) {
    (void)fd, (void)old_path;
    return true;
}
#endif

bool io_target_keep_rights(int fd, const char *old_path, const struct stat *old) {
    struct stat now;
    if (fstat(fd, &now) != 0) return false;
    if (now.st_uid != old->st_uid && fchown(fd, old->st_uid, (gid_t)-1) != 0) return false;
    const bool group = now.st_gid == old->st_gid || fchown(fd, (uid_t)-1, old->st_gid) == 0;
    mode_t mode = old->st_mode & 0777;
    if (!group || !keep_list(fd, old_path)) {
        const mode_t both = mode >> 3 & mode & 07;
        mode = (mode & 0700) | both << 3 | both;
    }
    return fchmod(fd, mode) == 0;
}
