/* SPDX-License-Identifier: Apache-2.0 */
#include "rights.h"

#include "linux.h"

#include <errno.h>
#include <unistd.h>

#if CELLWALK_LINUX
#include <sys/xattr.h>

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

bool io_rights_keep(int fd, const char *old_path, const struct stat *old) {
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
