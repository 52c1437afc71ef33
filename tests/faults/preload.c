/* SPDX-License-Identifier: Apache-2.0 */
/* A library to be put in front of libc (LD_PRELOAD): lets one call of one kind fail, chosen by the environment variable
 * CELLWALK_FAULT, "memory:17" for the 17th allocation. With CELLWALK_FAULT_COUNTS it writes into that file, when the program
 * ends, how many calls of each kind there were, in the order of the kinds, and how many blocks of memory were not freed.
 * CELLWALK_THREADS, a number, is how many threads may live beside the first one; more are refused, as by a container's limit.
 * Calls count from the program's own start on, not while libraries are loaded. */

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "faults.h"

extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t);
extern void *__libc_memalign(size_t, size_t);
extern void __libc_free(void *);

static atomic_bool counting;
static atomic_ulong calls[FAULT_KINDS];
static atomic_long blocks;
static int failing = -1; /* kind */
static unsigned long failing_number;
static atomic_long room = LONG_MAX; /* for threads */

/* Whether this call is the one. */
static bool fails(fault_kind kind) {
    if (!atomic_load(&counting)) return false;
    return atomic_fetch_add(&calls[kind], 1) + 1 == failing_number && (int)kind == failing;
}

#ifdef FAULTS_IN_PROCESS /* a part of a test, which says when */
void faults_begin(fault_kind kind, unsigned long number) {
    failing = (int)kind;
    failing_number = number;
    for (int k = 0; k < FAULT_KINDS; k++) atomic_store(&calls[k], 0);
    atomic_store(&blocks, 0);
    atomic_store(&counting, true);
}

fault_counts faults_end(void) {
    atomic_store(&counting, false);
    fault_counts counts = {.blocks = atomic_load(&blocks)};
    for (int k = 0; k < FAULT_KINDS; k++) counts.calls[k] = atomic_load(&calls[k]);
    return counts;
}
#else
__attribute__((constructor)) static void start(void) {
    const char *fault = getenv("CELLWALK_FAULT");
    for (int k = 0; fault && k < FAULT_KINDS; k++) {
        const size_t length = strlen(fault_names[k]);
        if (strncmp(fault, fault_names[k], length) != 0 || fault[length] != ':') continue;
        failing = k;
        failing_number = strtoul(fault + length + 1, NULL, 10);
    }
    const char *threads = getenv("CELLWALK_THREADS");
    if (threads != NULL) atomic_store(&room, strtol(threads, NULL, 10));
    atomic_store(&counting, true);
}

__attribute__((destructor)) static void finish(void) {
    atomic_store(&counting, false);
    const char *path = getenv("CELLWALK_FAULT_COUNTS");
    char text[256];
    size_t used = 0;
    for (int k = 0; k < FAULT_KINDS; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%lu ", atomic_load(&calls[k]));
    used += (size_t)snprintf(text + used, sizeof text - used, "%ld\n", atomic_load(&blocks));
    const int fd = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
    if (fd < 0) return;
    if (write(fd, text, used) < 0) abort();
    close(fd);
}

#endif

/* ---- memory ------------------------------------------------------------------------------------------------------- */

static void *counted(void *block) {
    if (block != NULL && atomic_load(&counting)) atomic_fetch_add(&blocks, 1);
    return block;
}

static void *no_memory(void) {
    errno = ENOMEM;
    return NULL;
}

__attribute__((visibility("default"))) void *malloc(size_t size) {
    return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_malloc(size));
}

__attribute__((visibility("default"))) void *calloc(size_t n, size_t size) {
    return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_calloc(n, size));
}

__attribute__((visibility("default"))) void *realloc(void *block, size_t size) {
    if (fails(FAULT_MEMORY)) return no_memory();
    return block == NULL ? counted(__libc_realloc(NULL, size)) : __libc_realloc(block, size);
}

__attribute__((visibility("default"))) int posix_memalign(void **block, size_t alignment, size_t size) {
    if (fails(FAULT_MEMORY)) return ENOMEM;
    *block = counted(__libc_memalign(alignment, size));
    return *block ? 0 : ENOMEM;
}

__attribute__((visibility("default"))) void *aligned_alloc(size_t alignment, size_t size) {
    return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_memalign(alignment, size));
}

__attribute__((visibility("default"))) void free(void *block) {
    if (block != NULL && atomic_load(&counting)) atomic_fetch_sub(&blocks, 1);
    __libc_free(block);
}

/* ---- files and threads -------------------------------------------------------------------------------------------- */

#define NEXT(type, name)                                                                                               \
    static type *next;                                                                                                 \
    if (next == NULL) *(void **)&next = dlsym(RTLD_NEXT, name)

typedef size_t fwrite_fn(const void *, size_t, size_t, FILE *);
__attribute__((visibility("default"))) size_t fwrite(const void *bytes, size_t size, size_t n, FILE *file) {
    NEXT(fwrite_fn, "fwrite");
    if (file == stderr || !fails(FAULT_WRITE)) return next(bytes, size, n, file);
    errno = ENOSPC;
    return 0;
}

typedef int file_fn(FILE *);
__attribute__((visibility("default"))) int fflush(FILE *file) {
    NEXT(file_fn, "fflush");
    if (file == stderr || !fails(FAULT_WRITE)) return next(file);
    errno = EIO;
    return EOF;
}

__attribute__((visibility("default"))) int fclose(FILE *file) {
    NEXT(file_fn, "fclose");
    const bool fail = fails(FAULT_WRITE);
    const int result = next(file);
    if (fail) errno = EDQUOT;
    return fail ? EOF : result;
}

typedef int fallocate_fn(int, int, off_t, off_t);
__attribute__((visibility("default"))) int fallocate(int fd, int mode, off_t offset, off_t length) {
    NEXT(fallocate_fn, "fallocate");
    if (!fails(FAULT_WRITE)) return next(fd, mode, offset, length);
    errno = ENOSPC;
    return -1;
}

typedef int descriptor_fn(int);
__attribute__((visibility("default"))) int fsync(int fd) {
    NEXT(descriptor_fn, "fsync");
    if (!fails(FAULT_WRITE)) return next(fd);
    errno = EIO;
    return -1;
}

typedef int rename_fn(const char *, const char *);
__attribute__((visibility("default"))) int rename(const char *from, const char *to) {
    NEXT(rename_fn, "rename");
    if (!fails(FAULT_RENAME)) return next(from, to);
    errno = EACCES;
    return -1;
}

typedef int linkat_fn(int, const char *, int, const char *, int);
__attribute__((visibility("default"))) int linkat(int from_at, const char *from, int to_at, const char *to, int flags) {
    NEXT(linkat_fn, "linkat");
    if (!fails(FAULT_RENAME)) return next(from_at, from, to_at, to, flags);
    errno = EACCES;
    return -1;
}

typedef int open_fn(const char *, int, ...);
__attribute__((visibility("default"))) int open(const char *path, int flags, ...) {
    NEXT(open_fn, "open");
    va_list list;
    va_start(list, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(list, mode_t) : 0;
    va_end(list);
    if (!fails(FAULT_OPEN)) return next(path, flags, mode);
    errno = EMFILE;
    return -1;
}

typedef FILE *fopen_fn(const char *, const char *);
__attribute__((visibility("default"))) FILE *fopen(const char *path, const char *mode) {
    NEXT(fopen_fn, "fopen");
    if (!fails(FAULT_OPEN)) return next(path, mode);
    errno = EMFILE;
    return NULL;
}

typedef FILE *fdopen_fn(int, const char *);
__attribute__((visibility("default"))) FILE *fdopen(int fd, const char *mode) {
    NEXT(fdopen_fn, "fdopen");
    if (!fails(FAULT_OPEN)) return next(fd, mode);
    errno = ENOMEM;
    return NULL;
}

typedef ssize_t pread_fn(int, void *, size_t, off_t);
__attribute__((visibility("default"))) ssize_t pread(int fd, void *to, size_t size, off_t offset) {
    NEXT(pread_fn, "pread");
    if (!fails(FAULT_READ)) return next(fd, to, size, offset);
    errno = EIO;
    return -1;
}

typedef size_t fread_fn(void *, size_t, size_t, FILE *);
__attribute__((visibility("default"))) size_t fread(void *to, size_t size, size_t n, FILE *file) {
    NEXT(fread_fn, "fread");
    if (!fails(FAULT_READ)) return next(to, size, n, file);
    errno = EIO;
    file->_flags |= 0x20; /* glibc's mark of an error */
    return 0;
}

typedef int fstat_fn(int, struct stat *);
__attribute__((visibility("default"))) int fstat(int fd, struct stat *about) {
    NEXT(fstat_fn, "fstat");
    if (!fails(FAULT_READ)) return next(fd, about);
    errno = EIO;
    return -1;
}

typedef void *mmap_fn(void *, size_t, int, int, int, off_t);
__attribute__((visibility("default"))) void *mmap(void *at, size_t size, int protection, int flags, int fd,
                                                  off_t offset) {
    NEXT(mmap_fn, "mmap");
    if (!fails(FAULT_MAP)) return next(at, size, protection, flags, fd, offset);
    errno = ENOMEM;
    return MAP_FAILED;
}

typedef struct start {
    void *(*run)(void *);
    void *argument;
} start_of_thread;

/* In the new thread. */
static void *run_counted(void *context) {
    const start_of_thread s = *(start_of_thread *)context;
    __libc_free(context);
    void *result = s.run(s.argument);
    atomic_fetch_add(&room, 1);
    return result;
}

typedef int thread_fn(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
__attribute__((visibility("default"))) int pthread_create(pthread_t *thread, const pthread_attr_t *how,
                                                          void *(*run)(void *), void *argument) {
    NEXT(thread_fn, "pthread_create");
    if (fails(FAULT_THREAD)) return EAGAIN;
    start_of_thread *s = __libc_malloc(sizeof *s);
    *s = (start_of_thread){run, argument};
    const int status = atomic_fetch_sub(&room, 1) > 0 ? next(thread, how, run_counted, s) : EAGAIN;
    if (status == 0) return 0;
    atomic_fetch_add(&room, 1);
    __libc_free(s);
    return status;
}
