/* SPDX-License-Identifier: Apache-2.0 */
/* The names of open temporary files stand in a static table that never moves and is never freed, so that a signal
 * handler can remove the files while another thread opens or closes one. */

#include "output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
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

/* Whoever gets true removes or renames the temporary file; the other finds it gone. */
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

/* A hidden name beside target that shows whose it is. The number tells apart outputs of one process and what an earlier
 * process of the same number may have left when it was killed. */
static bool temporary_name(char name[PATH_MAX], const char *target, unsigned number) {
    enum { BASE_MAX = 200 }; /* leaves room for the rest of the name in NAME_MAX */
    const char *slash = strrchr(target, '/');
    const char *base = slash ? slash + 1 : target;
    const int length = snprintf(name, PATH_MAX, "%.*s.%.*s.%ld-%u.tmp", (int)(base - target), target, BASE_MAX, base,
                                (long)getpid(), number);
    return length > 0 && length < PATH_MAX;
}

/* Opened by hand and not by mkstemp, so that the file gets the permissions that umask and directory give new files. */
static int create_temporary(struct slot *s, const char *target) {
    static atomic_uint counter;
    for (unsigned attempt = 0; attempt < 1000; attempt++) {
        if (!temporary_name(s->temporary, target, atomic_fetch_add(&counter, 1))) {
            errno = ENAMETOOLONG;
            return -1;
        }
        const int fd = open(s->temporary, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd >= 0 || errno != EEXIST) return fd;
    }
    return -1;
}

/* Opens out's file, temporary or, for a device or a pipe, the target itself. -1 with errno on failure. */
static int open_file(io_output *out, const char *path) {
    struct stat old;
    if (strcmp(path, "-") == 0) return fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    const bool exists = stat(out->target, &old) == 0;
    if (exists && !S_ISREG(old.st_mode)) {
        out->slot = DIRECT;
        out->temporary = out->target;
        return open(out->target, O_WRONLY | O_CLOEXEC); /* of a directory: EISDIR */
    }
    if (exists && faccessat(AT_FDCWD, out->target, W_OK, AT_EACCESS) != 0) return -1;
    out->slot = claim_slot();
    if (out->slot == DIRECT) {
        errno = EMFILE;
        return -1;
    }
    struct slot *s = &slots[out->slot];
    const int fd = create_temporary(s, out->target);
    if (fd < 0) {
        atomic_store(&s->state, FREE);
        return -1;
    }
    atomic_store(&s->state, LIVE);
    /* The new file keeps the old one's permissions; where that is not allowed, it has the usual ones. */
    if (exists) fchmod(fd, old.st_mode & 07777);
    out->temporary = s->temporary;
    return fd;
}

bool io_output_open(io_output *out, const char *path, io_error *error) {
    *out = (io_output){.slot = DIRECT};
    if (path[0] == '\0') return io_fail(error, "the output file's name is empty");
    /* Follow links, so that the file behind a link is replaced and not the link. A new file has nothing to follow. */
    out->target = realpath(path, NULL);
    if (out->target == NULL && errno == ENOENT) out->target = strdup(path);
    out->name = strdup(strcmp(path, "-") == 0 ? "standard output" : path);
    const int fd = out->target && out->name ? open_file(out, path) : -1;
    if (fd >= 0 && (out->file = fdopen(fd, "wb")) != NULL) return true;
    io_fail(error, "%s: cannot write: %s", path, strerror(errno));
    if (fd >= 0) {
        close(fd);
        if (out->slot != DIRECT && take(&slots[out->slot], CLAIMED)) unlink(slots[out->slot].temporary);
    }
    release(out);
    return false;
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
    /* Not posix_fallocate, which writes to every block itself where the file system has no such call. */
    if (fallocate(fileno(out->file), FALLOC_FL_KEEP_SIZE, 0, (off_t)bytes) == 0) return true;
    if (errno != ENOSPC && errno != EFBIG && errno != EDQUOT) return true;
    return fail_write(out, error);
}

bool io_output_write(io_output *out, const void *bytes, size_t size, io_error *error) {
    if (fwrite(bytes, 1, size, out->file) == size) return true;
    return fail_write(out, error);
}

bool io_output_commit(io_output *out, io_error *error) {
    errno = 0;
    bool good = fflush(out->file) == 0 && !ferror(out->file);
    int reason = errno;
    if (fclose(out->file) != 0 && good) {
        good = false;
        reason = errno;
    }
    if (out->slot != DIRECT) {
        /* Stays LIVE until it has its name: a signal handler finds it under one of the two, or removes it first. */
        struct slot *s = &slots[out->slot];
        if (good && rename(s->temporary, out->target) != 0) {
            good = false;
            reason = atomic_load(&s->state) == GONE ? EINTR : errno;
        }
        if (take(s, CLAIMED) && !good) unlink(s->temporary);
    }
    /* A write that failed earlier left its mark on the stream and took its reason along. */
    errno = reason ? reason : EIO;
    if (!good) fail_write(out, error);
    release(out);
    return good;
}
