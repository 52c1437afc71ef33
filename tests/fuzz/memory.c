/* SPDX-License-Identifier: Apache-2.0 */
/* The linker lets all calls to open and the like end here (--wrap): those of the readers, and between inputs libFuzzer's own,
 * which go on to libc. */

#include "memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Far from the descriptors that the process has. */
enum { FIRST_FD = 1 << 20 };

static struct {
    const char *name;
    const uint8_t *data;
    size_t size;
} files[MEMORY_FILES_MAX];

static bool at_work; /* on an input */

void memory_file(size_t number, const char *name, const uint8_t *data, size_t size) {
    if (number >= MEMORY_FILES_MAX) abort();
    files[number].name = name;
    files[number].data = data;
    files[number].size = size;
    at_work = true;
}

void memory_done(void) { at_work = false; }

static int find(const char *path) {
    while (path[0] == '.' && path[1] == '/') path += 2;
    for (int k = 0; k < MEMORY_FILES_MAX; k++)
        if (files[k].name != NULL && strcmp(files[k].name, path) == 0) return k;
    errno = ENOENT;
    return -1;
}

static int describe(int k, struct stat *about) {
    if (k < 0 || k >= MEMORY_FILES_MAX) {
        errno = EBADF;
        return -1;
    }
    memset(about, 0, sizeof *about);
    about->st_mode = S_IFREG;
    about->st_ino = (ino_t)(k + 1);
    about->st_size = (off_t)files[k].size;
    return 0;
}

int __wrap_open(const char *path, int flags, ...);
int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...) {
    if (!at_work) {
        va_list arguments;
        va_start(arguments, flags);
        const int mode = flags & O_CREAT ? va_arg(arguments, int) : 0;
        va_end(arguments);
        return __real_open(path, flags, mode);
    }
    const int k = find(path);
    return k < 0 ? -1 : FIRST_FD + k;
}

int __wrap_close(int fd);
int __real_close(int fd);
int __wrap_close(int fd) {
    if (!at_work) return __real_close(fd);
    return 0;
}

int __wrap_access(const char *path, int mode);
int __real_access(const char *path, int mode);
int __wrap_access(const char *path, int mode) {
    if (!at_work) return __real_access(path, mode);
    return find(path) < 0 ? -1 : 0;
}

int __wrap_stat(const char *path, struct stat *about);
int __real_stat(const char *path, struct stat *about);
int __wrap_stat(const char *path, struct stat *about) {
    if (!at_work) return __real_stat(path, about);
    const int k = find(path);
    return k < 0 ? -1 : describe(k, about);
}

int __wrap_fstat(int fd, struct stat *about);
int __real_fstat(int fd, struct stat *about);
int __wrap_fstat(int fd, struct stat *about) {
    return at_work ? describe(fd - FIRST_FD, about) : __real_fstat(fd, about);
}

ssize_t __wrap_pread(int fd, void *to, size_t size, off_t offset);
ssize_t __real_pread(int fd, void *to, size_t size, off_t offset);
ssize_t __wrap_pread(int fd, void *to, size_t size, off_t offset) {
    if (!at_work) return __real_pread(fd, to, size, offset);
    struct stat about;
    if (describe(fd - FIRST_FD, &about) != 0) return -1;
    if (offset < 0) {
        errno = EINVAL;
        return -1;
    }
    const size_t left = offset < about.st_size ? (size_t)(about.st_size - offset) : 0, got = size < left ? size : left;
    if (got > 0) memcpy(to, files[fd - FIRST_FD].data + offset, got);
    return (ssize_t)got;
}
