/* SPDX-License-Identifier: Apache-2.0 */
#include "inputs.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_bool protected;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of the list */
static struct identity {
    dev_t device;
    ino_t inode;
} * list;
static size_t count;

void io_inputs_protect(void) { atomic_store(&protected, true); }

bool io_inputs_are_protected(void) { return atomic_load(&protected); }

bool io_inputs_have(const struct stat *about) {
    bool have = false;
    pthread_mutex_lock(&lock);
    for (size_t k = 0; k < count; k++) have |= list[k].device == about->st_dev && list[k].inode == about->st_ino;
    pthread_mutex_unlock(&lock);
    return have;
}

static bool note(const struct stat *about) {
    if (!io_inputs_are_protected() || io_inputs_have(about)) return true;
    pthread_mutex_lock(&lock);
    struct identity *more = realloc(list, (count + 1) * sizeof *more);
    if (more != NULL) {
        list = more;
        list[count++] = (struct identity){about->st_dev, about->st_ino};
    }
    pthread_mutex_unlock(&lock);
    return more != NULL;
}

bool io_inputs_note_path(const char *path) {
    struct stat about;
    return stat(path, &about) != 0 || note(&about);
}

int io_file_open(const char *path, uint64_t *size, io_error *error) {
    /* Without O_NONBLOCK opening a pipe would wait for its writer. */
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat about;
    if (fd < 0 || fstat(fd, &about) != 0) {
        io_fail(error, "%s: cannot read: %s", path, strerror(errno));
    } else if (!S_ISREG(about.st_mode)) {
        io_fail(error, "%s: cannot read: %s", path, S_ISDIR(about.st_mode) ? strerror(EISDIR) : "not a regular file");
    } else if (!note(&about)) {
        io_fail(error, "%s: out of memory", path);
    } else {
        *size = (uint64_t)about.st_size;
        return fd;
    }
    if (fd >= 0) close(fd);
    return -1;
}

bool io_file_read_at(int fd, const char *path, void *to, size_t size, uint64_t offset, io_error *error) {
    char *bytes = to;
    size_t have = 0;
    while (have < size) {
        const ssize_t got = pread(fd, bytes + have, size - have, (off_t)(offset + have));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return io_fail(error, "%s: cannot read: %s", path, strerror(errno));
        if (got == 0)
            return io_fail(error, "%s: the file ends at byte %llu, where more was to come", path,
                           (unsigned long long)(offset + have));
        have += (size_t)got;
    }
    return true;
}

char *io_file_read(const char *path, size_t *size, io_error *error) {
    uint64_t bytes = 0;
    const int fd = io_file_open(path, &bytes, error);
    if (fd < 0) return NULL;
    char *text = bytes < SIZE_MAX ? malloc((size_t)bytes + 1) : NULL;
    if (text == NULL) {
        io_fail(error, "%s: out of memory for %llu bytes", path, (unsigned long long)bytes);
    } else if (!io_file_read_at(fd, path, text, (size_t)bytes, 0, error)) {
        free(text);
        text = NULL;
    } else {
        text[bytes] = '\0';
        *size = (size_t)bytes;
    }
    close(fd);
    return text;
}
