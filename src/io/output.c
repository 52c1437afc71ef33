/* SPDX-License-Identifier: Apache-2.0 */
#include "output.h"

#include "inputs.h"
#include "linux.h"
#include "number.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#if CELLWALK_LINUX
#include <sys/xattr.h>
#endif

/* ---- where an output goes ---------------------------------------------------------------------------------------- */

int io_output_descriptor(const char *path) {
    const char *number = strncmp(path, "/dev/fd/", 8) == 0          ? path + 8
                         : strncmp(path, "/proc/self/fd/", 14) == 0 ? path + 14
                                                                    : "";
    const size_t digits = strspn(number, "0123456789");
    if (strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0) return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0) return STDERR_FILENO;
    return digits > 0 && digits < 10 && number[digits] == '\0' ? atoi(number) : -1;
}

/* The part of path behind its last slash. */
static const char *base_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static bool stat_folder(const char *path, struct stat *about) {
    char folder[PATH_MAX];
    const int length = (int)(base_of(path) - path);
    errno = ENAMETOOLONG;
    return snprintf(folder, PATH_MAX, "%.*s", length > 0 ? length : 2, length > 0 ? path : "./") < PATH_MAX &&
           stat(folder, about) == 0;
}

/* The rule of Linux's fs.protected_symlinks, which opening by name would obey: in a shared folder anybody can put a
 * link where an output is expected. */
static bool may_follow(const char *path) {
    struct stat link, folder;
    if (lstat(path, &link) != 0 || !stat_folder(path, &folder)) return false;
    const bool shared = (folder.st_mode & (S_ISVTX | S_IWOTH)) == (S_ISVTX | S_IWOTH);
    if (!shared || link.st_uid == geteuid() || link.st_uid == folder.st_uid) return true;
    errno = EACCES;
    return false;
}

/* The end of a chain of links: a file, which need not exist, or a descriptor's name. To be freed; NULL with errno. */
static char *follow(const char *path) {
    enum { LINKS_MAX = 40 };
    char name[PATH_MAX], link[PATH_MAX];
    errno = ENAMETOOLONG;
    if (snprintf(name, sizeof name, "%s", path) >= (int)sizeof name) return NULL;
    for (int k = 0; k < LINKS_MAX; k++) {
        const ssize_t length = io_output_descriptor(name) >= 0 ? -1 : readlink(name, link, sizeof link - 1);
        if (length < 0) return strdup(name);
        if (!may_follow(name)) return NULL;
        char *to = link[0] == '/' ? name : name + (base_of(name) - name);
        errno = ENAMETOOLONG;
        if ((size_t)length >= sizeof name - (size_t)(to - name)) return NULL;
        memcpy(to, link, (size_t)length);
        to[length] = '\0';
    }
    errno = ELOOP;
    return NULL;
}

/* Two names that lead to one file are equal before and after it exists. Devices equal nothing. Inode 0: not known. */
typedef struct identity {
    struct stat file, folder;
    const char *base; /* in the folder; the target's own text */
} identity;

/* about: of the file, or NULL if there is none; direct: it is no file of the folder. */
static void identify(identity *i, const char *target, bool direct, const struct stat *about) {
    *i = (identity){.base = base_of(target)};
    if (about != NULL && !S_ISCHR(about->st_mode)) i->file = *about;
    if (direct || !stat_folder(target, &i->folder)) i->folder.st_ino = 0;
}

static bool is_one(const struct stat *a, const struct stat *b) {
    return a->st_ino != 0 && a->st_ino == b->st_ino && a->st_dev == b->st_dev;
}

static bool is_same(const identity *a, const identity *b) {
    return is_one(&a->file, &b->file) || (is_one(&a->folder, &b->folder) && strcmp(a->base, b->base) == 0);
}

/* ---- what stays of a file that is replaced ----------------------------------------------------------------------- */

/* With a list, the mode's bits for the group are the most that the list grants: without the list, they would be the
 * group's own. A new file may have inherited a list from its folder. */
static bool keep_list(int fd, const char *old_path) {
#if CELLWALK_LINUX
    static const char list[] = "system.posix_acl_access";
    char bytes[4096];
    const ssize_t size = getxattr(old_path, list, bytes, sizeof bytes);
    if (size > 0) return fsetxattr(fd, list, bytes, (size_t)size, 0) == 0;
    if (size < 0 && errno != ENODATA && errno != ENOTSUP) return false;
    return fremovexattr(fd, list) == 0 || errno == ENODATA || errno == ENOTSUP;
#else
    (void)fd, (void)old_path;
    return true;
#endif
}

/* Gives the new file fd the owner, group, access control list and permissions of the old one, so nobody may do more
 * with it. Set-user-ID, set-group-ID and sticky bits are never kept. Where the group or the list cannot be, group and
 * others get the permissions both had. False if the owner cannot be kept: without it the old rights mean nothing. */
static bool keep_rights(int fd, const char *old_path, const struct stat *old) {
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

/* ---- temporary files --------------------------------------------------------------------------------------------- */

/* The names stand in a static table that never moves and is never freed, so that a signal handler can remove the files
 * while another thread opens or closes one. A slot goes FREE -> CLAIMED -> LIVE -> CLAIMED -> FREE by its owner; a
 * signal handler may take LIVE to GONE. */
enum { FREE, CLAIMED, LIVE, GONE };

static struct slot {
    atomic_int state;
    pid_t process; /* a forked child removes no file of its parent's */
    identity identity;
    char temporary[PATH_MAX];
} slots[IO_OUTPUT_MAX];

/* True for the one caller that removes or renames the temporary file; others find it gone. */
static bool take(struct slot *s, int next) {
    int expected = LIVE;
    return s->process == getpid() && atomic_compare_exchange_strong(&s->state, &expected, next);
}

/* Also what is GONE: a handler interrupted by a second signal, which ends the process, may not have removed it yet. */
void io_output_discard_all(void) {
    for (struct slot *s = slots; s < slots + IO_OUTPUT_MAX; s++)
        if (take(s, GONE) || (s->process == getpid() && atomic_load(&s->state) == GONE)) unlink(s->temporary);
}

static bool claim(io_output *out) {
    static atomic_flag registered = ATOMIC_FLAG_INIT;
    if (!atomic_flag_test_and_set(&registered)) atexit(io_output_discard_all);
    for (int k = 0; k < IO_OUTPUT_MAX; k++) {
        int expected = FREE;
        if (!atomic_compare_exchange_strong(&slots[k].state, &expected, CLAIMED)) continue;
        slots[k].process = getpid();
        slots[k].identity = (identity){0};
        out->slot = k;
        return true;
    }
    errno = EMFILE;
    return false;
}

void io_output_discard(io_output *out) {
    if (out->name == NULL) return;
    if (out->file != NULL) fclose(out->file);
    if (out->slot >= 0) {
        if (take(&slots[out->slot], CLAIMED)) unlink(slots[out->slot].temporary);
        atomic_store(&slots[out->slot].state, FREE);
    }
    free(out->target);
    free(out->name);
    *out = (io_output){0};
}

static bool fail_write(const io_output *out, io_error *error) {
    return io_fail(error, "%s: cannot write: %s", out->name, strerror(errno));
}

/* Not by mkstemp, so that a new file gets the rights that umask and folder give. */
static int create_temporary(struct slot *s, const char *name, int length, mode_t mode) {
    errno = ENAMETOOLONG;
    if (length < 0 || (size_t)length >= sizeof s->temporary) return -1;
    memcpy(s->temporary, name, (size_t)length + 1);
    atomic_store(&s->state, LIVE);
    const int fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd < 0) atomic_store(&s->state, CLAIMED);
    return fd;
}

/* By a hidden name beside target, which nobody can foresee and so nobody can be in the way of. */
static int create(const io_output *out, const char *target, mode_t mode) {
    enum { BASE_MAX = 200 }; /* leaves room for the rest of the name in NAME_MAX */
    const char *base = base_of(target);
    char name[PATH_MAX];
    unsigned long long number;
    if (getentropy(&number, sizeof number) != 0) return -1;
    const int length =
        snprintf(name, sizeof name, "%.*s.%.*s.%016llx.tmp", (int)(base - target), target, BASE_MAX, base, number);
    return create_temporary(&slots[out->slot], name, length, mode);
}

static int create_in_place_of(io_output *out, const struct stat *old) {
    if (faccessat(AT_FDCWD, out->target, W_OK, AT_EACCESS) != 0) return -1;
    const int fd = create(out, out->target, 0600); /* nobody else may read the first bytes either */
    if (fd < 0 || keep_rights(fd, out->target, old)) return fd;
    close(fd);
    if (take(&slots[out->slot], CLAIMED)) unlink(slots[out->slot].temporary);
    return create(out, out->target, 0666);
}

static bool check_input(const io_output *out, const struct stat *about, io_error *error) {
    return !io_inputs_have(about) ||
           io_fail(error, "%s: is also an input; choose another name for the output", out->name);
}

/* Refuses a file that the process reads or writes already. */
static bool check_conflicts(const io_output *out, const struct stat *about, io_error *error) {
    static const char *const streams[] = {"output", "error"};
    struct slot *own = &slots[out->slot];
    if (!io_inputs_are_protected()) return true;
    if (about != NULL && !check_input(out, about, error)) return false;
    identify(&own->identity, out->target, out->direct, about);
    for (struct slot *s = slots; s < slots + IO_OUTPUT_MAX; s++)
        if (s != own && atomic_load(&s->state) != FREE && is_same(&s->identity, &own->identity))
            return io_fail(error, "%s: is also another output; choose another name for one of them", out->name);
    for (int k = 0; k < 2 && about != NULL && !out->direct; k++) {
        struct stat stream;
        if (fstat(STDOUT_FILENO + k, &stream) == 0 && is_one(&stream, about))
            return io_fail(error, "%s: is also where standard %s leads; choose another name for the output", out->name,
                           streams[k]);
    }
    return true;
}

/* A descriptor, or -1 with a message. */
static int open_target(io_output *out, io_error *error) {
    struct stat about;
    const int number = io_output_descriptor(out->target);
    const bool exists = (number >= 0 ? fstat(number, &about) : stat(out->target, &about)) == 0;
    out->direct = number >= 0 || (exists && !S_ISREG(about.st_mode));
    if (!check_conflicts(out, exists ? &about : NULL, error)) return -1;
    const int fd = number >= 0   ? fcntl(number, F_DUPFD_CLOEXEC, 0)
                   : out->direct ? open(out->target, O_WRONLY | O_CLOEXEC) /* of a directory: EISDIR */
                   : exists      ? create_in_place_of(out, &about)
                                 : create(out, out->target, 0666);
    if (fd < 0) fail_write(out, error);
    return fd;
}

/* Makes a stream of a descriptor; -1 is one that could not be had, which error says already. */
static bool start(io_output *out, int fd, io_error *error) {
    if (fd >= 0 && (out->file = fdopen(fd, "wb")) != NULL) return true;
    if (fd >= 0) {
        fail_write(out, error);
        close(fd);
    }
    io_output_discard(out);
    return false;
}

bool io_output_open(io_output *out, const char *path, io_error *error) {
    *out = (io_output){.slot = -1};
    if (path[0] == '\0') return io_fail(error, "the output file's name is empty");
    out->name = strdup(strcmp(path, "-") == 0 ? "standard output" : path);
    out->target = out->name ? follow(path) : NULL;
    const bool good =
        (out->target != NULL && claim(out)) || io_fail(error, "%s: cannot write: %s", path, strerror(errno));
    return start(out, good ? open_target(out, error) : -1, error);
}

const char *io_output_temporary(const io_output *out) { return slots[out->slot].temporary; }

bool io_output_open_scratch(io_output *out, const io_output *beside, const char *suffix, io_error *error) {
    *out = (io_output){.slot = -1, .name = strdup(beside->name)};
    char name[PATH_MAX];
    const int length = snprintf(name, sizeof name, "%s%s", io_output_temporary(beside), suffix);
    const int fd = out->name != NULL && claim(out) ? create_temporary(&slots[out->slot], name, length, 0600) : -1;
    if (fd < 0) fail_write(beside, error);
    return start(out, fd, error);
}

bool io_output_reserve(io_output *out, uint64_t bytes, io_error *error) {
    if (out->direct || bytes == 0) return true;
    errno = EFBIG;
    if (bytes > INT64_MAX) return fail_write(out, error);
#if CELLWALK_LINUX
    /* Not posix_fallocate, which writes to every block itself where the file system has no such call. */
    return fallocate(fileno(out->file), FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes) == 0 ||
           (errno != ENOSPC && errno != EFBIG && errno != EDQUOT) || fail_write(out, error);
#else
    return true; /* a full disk is found out while writing */
#endif
}

bool io_output_write(io_output *out, const void *bytes, size_t size, io_error *error) {
    return fwrite(bytes, 1, size, out->file) == size || fail_write(out, error);
}

bool io_output_has_room(io_output *out, io_error *error) {
    static const char more[1 << 16];
    if (out->file == NULL) return true;
    return (fseek(out->file, 0, SEEK_END) == 0 && fwrite(more, 1, sizeof more, out->file) == sizeof more &&
            fflush(out->file) == 0) ||
           fail_write(out, error);
}

bool io_output_print(io_output *out, io_error *error, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = number_print(out->file, format, arguments);
    va_end(arguments);
    return length >= 0 || fail_write(out, error);
}

bool io_output_settle(io_output *out, io_error *error) {
    FILE *file = out->file;
    struct stat about;
    if (file == NULL) return true;
    out->file = NULL;
    errno = 0;
    bool good = fflush(file) == 0 && !ferror(file) && fstat(fileno(file), &about) == 0;
    good = good && (out->direct || fsync(fileno(file)) == 0 || errno == EINVAL);
    int reason = errno;
    if (fclose(file) != 0 && good) {
        good = false;
        reason = errno;
    }
    errno = reason != 0 ? reason : EIO; /* a write that failed earlier left its mark on the stream alone */
    if (!good) fail_write(out, error);
    /* Found out late if the input was opened after the output. */
    if (good && out->direct && S_ISREG(about.st_mode)) good = check_input(out, &about, error);
    if (!good) io_output_discard(out);
    return good;
}

bool io_output_commit(io_output *out, io_error *error) {
    struct stat old;
    if (!io_output_settle(out, error)) return false;
    struct slot *s = &slots[out->slot];
    bool good = out->direct || stat(out->target, &old) != 0 || check_input(out, &old, error);
    if (good && !out->direct) {
        /* Stays LIVE until it has its name: a signal handler finds it under one of the two, or removes it first. */
        good = rename(s->temporary, out->target) == 0;
        if (!good && atomic_load(&s->state) == GONE) errno = EINTR;
        if (good) take(s, CLAIMED);
        if (!good) fail_write(out, error);
    }
    io_output_discard(out);
    return good;
}
