/* SPDX-License-Identifier: Apache-2.0 */
/* The names of open temporary files stand in a static table that never moves and is never freed, so that a signal
 * handler can remove the files while another thread opens or closes one. */

#include "output.h"

#include "inputs.h"
#include "linux.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A slot goes FREE -> CLAIMED -> LIVE -> CLAIMED -> FREE by its owner; a signal handler may take LIVE to GONE. */
enum { FREE, CLAIMED, LIVE, GONE };

static struct slot {
    atomic_int state;
    char temporary[PATH_MAX];
} slots[IO_OUTPUT_MAX];

enum { DIRECT = -1 }; /* no slot: the target is a device or a pipe */

/* DIRECT when none is free. */
static int claim_slot(void) {
    for (int k = 0; k < IO_OUTPUT_MAX; k++) {
        int expected = FREE;
        if (atomic_compare_exchange_strong(&slots[k].state, &expected, CLAIMED)) return k;
    }
    return DIRECT;
}

/* The caller that gets true removes or renames the temporary file; the other finds it gone. */
static bool take(struct slot *s, int next) {
    int expected = LIVE;
    return atomic_compare_exchange_strong(&s->state, &expected, next);
}

void io_output_discard_all(void) {
    for (int k = 0; k < IO_OUTPUT_MAX; k++)
        if (take(&slots[k], GONE)) unlink(slots[k].temporary);
}

static void release(io_output *out) {
    if (out->slot != DIRECT) atomic_store(&slots[out->slot].state, FREE);
    free(out->target);
    free(out->name);
    *out = (io_output){0};
}

void io_output_discard(io_output *out) {
    if (out->file == NULL) return;
    fclose(out->file);
    if (out->slot != DIRECT && take(&slots[out->slot], CLAIMED)) unlink(slots[out->slot].temporary);
    release(out);
}

enum { ATTEMPTS = 1000 };

/* A hidden name beside target with the process's number. A further number distinguishes outputs of one process, and
 * files that an earlier process of the same number left when it was killed. */
static bool next_name(struct slot *s, const char *target) {
    enum { BASE_MAX = 200 }; /* leaves room for the rest of the name in NAME_MAX */
    static atomic_uint counter;
    const char *slash = strrchr(target, '/');
    const char *base = slash ? slash + 1 : target;
    const int length = snprintf(s->temporary, sizeof s->temporary, "%.*s.%.*s.%ld-%u.tmp", (int)(base - target), target,
                                BASE_MAX, base, (long)getpid(), atomic_fetch_add(&counter, 1));
    errno = ENAMETOOLONG;
    return length > 0 && (size_t)length < sizeof s->temporary;
}

/* Not by mkstemp, so that the file gets the permissions that umask and directory give new files. */
static int create_temporary(struct slot *s, const char *target) {
    for (unsigned attempt = 0; attempt < ATTEMPTS && next_name(s, target); attempt++) {
        const int fd = open(s->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd >= 0 || errno != EEXIST) return fd;
    }
    return -1;
}

#if CELLWALK_LINUX
/* An open file by a name in /proc, which is how a file without any other is given one. */
static void descriptor_name(char name[32], int fd) { snprintf(name, 32, "/proc/self/fd/%d", fd); }

static bool link_open_file(int fd, const char *name) {
    char descriptor[32];
    descriptor_name(descriptor, fd);
    return linkat(AT_FDCWD, descriptor, AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
}

/* -1 with errno; ENOTSUP where such a file could not get a name later. */
static int open_unnamed(const char *target) {
    char directory[PATH_MAX];
    const char *slash = strrchr(target, '/');
    const int length = slash == NULL     ? snprintf(directory, sizeof directory, ".")
                       : slash == target ? snprintf(directory, sizeof directory, "/")
                                         : snprintf(directory, sizeof directory, "%.*s", (int)(slash - target), target);
    if (length < 0 || (size_t)length >= sizeof directory) {
        errno = ENAMETOOLONG;
        return -1;
    }
    const int fd = open(directory, O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    char name[32];
    descriptor_name(name, fd);
    if (fd < 0 || access(name, F_OK) == 0) return fd;
    close(fd);
    errno = ENOTSUP; /* no /proc */
    return -1;
}
#else
static bool link_open_file(int fd, const char *name) {
    (void)fd, (void)name;
    errno = ENOTSUP;
    return false;
}

static int open_unnamed(const char *target) {
    (void)target;
    errno = ENOTSUP;
    return -1;
}
#endif

/* Errors of systems and file systems without nameless files. */
static bool knows_no_unnamed(int reason) {
    return reason == ENOTSUP || reason == EOPNOTSUPP || reason == EISDIR || reason == EINVAL || reason == ENOSYS;
}

/* Opens out's file: its own or, for a device or a pipe, the target itself. -1 with errno on failure. */
static int open_file(io_output *out) {
    struct stat old;
    const bool exists = stat(out->target, &old) == 0;
    if (exists && !S_ISREG(old.st_mode)) return open(out->target, O_WRONLY | O_CLOEXEC); /* of a directory: EISDIR */
    if (exists && faccessat(AT_FDCWD, out->target, W_OK, AT_EACCESS) != 0) return -1;
    out->slot = claim_slot();
    if (out->slot == DIRECT) {
        errno = EMFILE;
        return -1;
    }
    struct slot *s = &slots[out->slot];
    s->temporary[0] = '\0';
    int fd = open_unnamed(out->target);
    out->unnamed = fd >= 0;
    if (fd < 0 && (!knows_no_unnamed(errno) || (fd = create_temporary(s, out->target)) < 0)) {
        atomic_store(&s->state, FREE);
        out->slot = DIRECT;
        return -1;
    }
    atomic_store(&s->state, LIVE);
    /* The new file keeps the old one's permissions; where that is not allowed, it has the usual ones. */
    if (exists) fchmod(fd, old.st_mode & 07777);
    return fd;
}

/* False, with a message, if the output would take the place of a file that is read. */
static bool is_no_input(const io_output *out, io_error *error) {
    struct stat old;
    if (out->target == NULL || stat(out->target, &old) != 0 || !io_inputs_have(&old)) return true;
    return io_fail(error, "%s: is also an input; choose another name for the output", out->name);
}

/* The descriptor that a name stands for, "-" or one of the system's; else -1. Such an output goes where the
 * descriptor leads: a file that a shell opened to append to must not be replaced. */
static int descriptor_of(const char *path) {
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

/* The file at the end of a chain of links, which need not be there: so the file behind a link is written, and not
 * the link. Stops at a name of a descriptor. NULL with errno. */
static char *follow_links(const char *path) {
    enum { LINKS_MAX = 40 };
    char name[PATH_MAX], link[PATH_MAX];
    if (snprintf(name, sizeof name, "%s", path) >= (int)sizeof name) {
        errno = ENAMETOOLONG;
        return NULL;
    }
    for (int k = 0; k < LINKS_MAX; k++) {
        ssize_t length = descriptor_of(name) >= 0 ? -1 : readlink(name, link, sizeof link - 1);
        if (length < 0) return strdup(name);
        link[length] = '\0';
        char *slash = strrchr(name, '/');
        char *base = link[0] == '/' || slash == NULL ? name : slash + 1;
        if ((size_t)length >= sizeof name - (size_t)(base - name)) {
            errno = ENAMETOOLONG;
            return NULL;
        }
        memcpy(base, link, (size_t)length + 1);
    }
    errno = ELOOP;
    return NULL;
}

/* A second descriptor; -1 with errno, or with error filled in if it leads to a file that is read. */
static int open_descriptor(io_output *out, int number, io_error *error) {
    struct stat about;
    if (fstat(number, &about) == 0 && S_ISREG(about.st_mode) && io_inputs_have(&about)) {
        io_fail(error, "%s: is also an input; choose another name for the output", out->name);
        errno = 0;
        return -1;
    }
    return fcntl(number, F_DUPFD_CLOEXEC, 0);
}

bool io_output_open(io_output *out, const char *path, io_error *error) {
    *out = (io_output){.slot = DIRECT};
    if (path[0] == '\0') return io_fail(error, "the output file's name is empty");
    out->target = follow_links(path);
    out->name = strdup(strcmp(path, "-") == 0 ? "standard output" : path);
    const int number = out->target != NULL ? descriptor_of(out->target) : -1;
    if (out->target != NULL && out->name != NULL && number < 0 && !is_no_input(out, error)) {
        release(out);
        return false;
    }
    const int fd = out->target == NULL || out->name == NULL ? -1
                   : number >= 0                            ? open_descriptor(out, number, error)
                                                            : open_file(out);
    if (fd >= 0 && (out->file = fdopen(fd, "wb")) != NULL) return true;
    if (errno == 0) { /* the error is told */
        release(out);
        return false;
    }
    io_fail(error, "%s: cannot write: %s", path, strerror(errno));
    if (fd >= 0) {
        close(fd);
        if (out->slot != DIRECT && take(&slots[out->slot], CLAIMED)) unlink(slots[out->slot].temporary);
    }
    release(out);
    return false;
}

/* Gives an output without a name a temporary one, which a signal handler knows before it exists. */
static bool give_name(io_output *out, int fd) {
    struct slot *s = &slots[out->slot];
    for (unsigned attempt = 0; attempt < ATTEMPTS && out->unnamed; attempt++) {
        if (!take(s, CLAIMED)) {
            errno = EINTR;
            return false;
        }
        const bool named = next_name(s, out->target);
        atomic_store(&s->state, LIVE);
        out->unnamed = !(named && link_open_file(fd, s->temporary));
        if (!named || (out->unnamed && errno != EEXIST)) break;
    }
    return !out->unnamed;
}

const char *io_output_temporary(io_output *out) {
    if (out->slot == DIRECT) return out->target;
    if (out->unnamed && !give_name(out, fileno(out->file))) return NULL;
    return slots[out->slot].temporary;
}

static bool fail_write(const io_output *out, io_error *error) {
    return io_fail(error, "%s: cannot write: %s", out->name, strerror(errno));
}

bool io_output_reserve(io_output *out, uint64_t bytes, io_error *error) {
    if (out->slot == DIRECT || bytes == 0) return true;
    if (bytes > INT64_MAX) {
        errno = EFBIG;
        return fail_write(out, error);
    }
#if CELLWALK_LINUX
    /* Not posix_fallocate, which writes to every block itself where the file system has no such call. */
    if (fallocate(fileno(out->file), FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes) == 0) return true;
    if (errno != ENOSPC && errno != EFBIG && errno != EDQUOT) return true;
    return fail_write(out, error);
#else
    return true; /* a full disk is found out while writing */
#endif
}

bool io_output_write(io_output *out, const void *bytes, size_t size, io_error *error) {
    if (fwrite(bytes, 1, size, out->file) == size) return true;
    return fail_write(out, error);
}

bool io_output_print(io_output *out, io_error *error, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = vfprintf(out->file, format, arguments);
    va_end(arguments);
    return length >= 0 || fail_write(out, error);
}

/* Whether the file's data are on the disk; errno is set if not. */
static bool settle(int fd) { return fsync(fd) == 0 || errno == EINVAL; }

/* The file, of which fd is a second descriptor, gets its name in one step. */
static bool take_name(io_output *out, int fd, io_error *error) {
    struct slot *s = &slots[out->slot];
    if (!is_no_input(out, error)) return false;
    bool good = atomic_load(&s->state) == LIVE;
    errno = EINTR;
    if (good && out->unnamed) {
        /* Nothing has the name yet, or else linking says so. */
        if (link_open_file(fd, out->target)) return true;
        good = errno == EEXIST && give_name(out, fd);
    }
    /* Stays LIVE until it has its name: a signal handler finds it under one of the two, or removes it first. */
    good = good && rename(s->temporary, out->target) == 0;
    if (!good && atomic_load(&s->state) == GONE) errno = EINTR;
    return good || fail_write(out, error);
}

/* Closes the stream, and leaves a second descriptor, or -1 with errno. */
static int close_stream(io_output *out) {
    errno = 0;
    bool good = fflush(out->file) == 0 && !ferror(out->file);
    int reason = errno;
    int fd = good ? fcntl(fileno(out->file), F_DUPFD_CLOEXEC, 0) : -1;
    if (good && fd < 0) {
        good = false;
        reason = errno;
    }
    if (fclose(out->file) != 0 && good) {
        good = false;
        reason = errno;
    }
    if (!good && fd >= 0) close(fd);
    /* A write that failed earlier left its mark on the stream and took its reason along. */
    errno = reason ? reason : EIO;
    return good ? fd : -1;
}

/* Flushes, and waits until the bytes are on the disk. A second descriptor, or -1 after a message. */
static int finish_bytes(io_output *out, io_error *error) {
    struct stat about;
    /* Found out late where the input was opened after the output. */
    if (out->slot == DIRECT && fstat(fileno(out->file), &about) == 0 && S_ISREG(about.st_mode) &&
        io_inputs_have(&about)) {
        io_fail(error, "%s: is also an input; choose another name for the output", out->name);
        fclose(out->file);
        return -1;
    }
    const int fd = close_stream(out);
    if (fd >= 0 && (out->slot == DIRECT || settle(fd))) return fd;
    fail_write(out, error);
    if (fd >= 0) close(fd);
    return -1;
}

/* The last step, for an output whose stream is closed: gives it its name, or with good false and any fd removes it. */
static bool finish_name(io_output *out, int fd, bool good, io_error *error) {
    if (out->slot != DIRECT) {
        good = good && take_name(out, fd, error);
        if (take(&slots[out->slot], CLAIMED) && !good) unlink(slots[out->slot].temporary);
    }
    if (fd >= 0) close(fd);
    release(out);
    return good;
}

bool io_output_commit(io_output *out, io_error *error) {
    const int fd = finish_bytes(out, error);
    return finish_name(out, fd, fd >= 0, error);
}

/* Gives the file a second name, which keeps it if another takes its own. DIRECT if it has no name or cannot have two. */
static int keep_old(const char *target) {
    const int k = claim_slot();
    if (k == DIRECT) return DIRECT;
    struct slot *s = &slots[k];
    for (unsigned attempt = 0; attempt < ATTEMPTS && next_name(s, target); attempt++) {
        atomic_store(&s->state, LIVE);
        if (link(target, s->temporary) == 0) return k;
        if (!take(s, CLAIMED) || errno != EEXIST) break;
    }
    atomic_store(&s->state, FREE);
    return DIRECT;
}

/* Ends that, with the name given back or not. */
static void leave_old(int k, const char *target, bool back) {
    if (take(&slots[k], CLAIMED) && !(back && rename(slots[k].temporary, target) == 0)) unlink(slots[k].temporary);
    atomic_store(&slots[k].state, FREE);
}

bool io_output_commit_both(io_output *out, io_output *beside, io_error *error) {
    char target[PATH_MAX];
    struct stat old;
    const int fd = finish_bytes(out, error);
    if (fd < 0) {
        io_output_discard(beside);
        return finish_name(out, fd, false, error);
    }
    const int fd_beside = finish_bytes(beside, error);
    snprintf(target, sizeof target, "%s", beside->target);
    const bool replaces = lstat(target, &old) == 0;
    const int kept = replaces && beside->slot != DIRECT && fd_beside >= 0 ? keep_old(target) : DIRECT;
    const bool named = finish_name(beside, fd_beside, fd_beside >= 0, error);
    const bool good = finish_name(out, fd, named, error);
    if (kept != DIRECT) leave_old(kept, target, named && !good);
    if (named && !good && !replaces) unlink(target);
    return good;
}

bool io_folder_make(const char *path, io_error *error) {
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

bool io_output_open_in(io_output *out, const char *folder, const char *name, io_error *error) {
    *out = (io_output){.slot = DIRECT};
    if (!io_folder_make(folder, error)) return false;
    const size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (!path) return io_fail(error, "out of memory");
    snprintf(path, size, "%s/%s", folder, name);
    const bool good = io_output_open(out, path, error);
    free(path);
    return good;
}
