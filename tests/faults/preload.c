/* SPDX-License-Identifier: Apache-2.0 */
/* A library to be put in front of libc (LD_PRELOAD): lets one call of one kind fail, chosen by the environment variable
 * CELLWALK_FAULT, "memory:17" for the 17th allocation. With CELLWALK_FAULT_COUNTS it writes into that file, when the
 * program ends, how many calls of each kind there were, in the order of the kinds, and how many blocks of memory were
 * not freed. CELLWALK_THREADS, a number, is how many threads may live beside the first one; more are refused, as by a
 * container's limit. Calls count from the program's own start on, not while libraries are loaded. */

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "faults.h"

#define EXPORTED __attribute__((visibility("default")))

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

#ifndef FAULTS_IN_PROCESS /* else it is a part of a test, which says when */
__attribute__((constructor)) static void start(void) {
    const char *fault = getenv("CELLWALK_FAULT"), *threads = getenv("CELLWALK_THREADS");
    const char *number = fault ? strchr(fault, ':') : NULL;
    int kind = 0;
    while (number && strncmp(fault, fault_names[kind], (size_t)(number - fault)) != 0) kind++;
    if (threads != NULL) atomic_store(&room, strtol(threads, NULL, 10));
    faults_begin((fault_kind)kind, number ? strtoul(number + 1, NULL, 10) : 0);
}

__attribute__((destructor)) static void finish(void) {
    const fault_counts counts = faults_end();
    const char *path = getenv("CELLWALK_FAULT_COUNTS");
    char text[256];
    size_t used = 0;
    for (int k = 0; k < FAULT_KINDS; k++)
        used += (size_t)snprintf(text + used, sizeof text - used, "%lu ", counts.calls[k]);
    used += (size_t)snprintf(text + used, sizeof text - used, "%ld\n", counts.blocks);
    const int fd = path ? open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
    if (fd < 0) return;
    if (write(fd, text, used) < 0) abort();
    close(fd);
}

#endif

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void *counted(void *block) {
    if (block != NULL && atomic_load(&counting)) atomic_fetch_add(&blocks, 1);
    return block;
}

static void *no_memory(void) {
    errno = ENOMEM;
    return NULL;
}

EXPORTED void *malloc(size_t size) { return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_malloc(size)); }

EXPORTED void *calloc(size_t n, size_t size) {
    return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_calloc(n, size));
}

EXPORTED void *realloc(void *block, size_t size) {
    if (fails(FAULT_MEMORY)) return no_memory();
    return block == NULL ? counted(__libc_realloc(NULL, size)) : __libc_realloc(block, size);
}

EXPORTED int posix_memalign(void **block, size_t alignment, size_t size) {
    if (fails(FAULT_MEMORY)) return ENOMEM;
    *block = counted(__libc_memalign(alignment, size));
    return *block ? 0 : ENOMEM;
}

EXPORTED void *aligned_alloc(size_t alignment, size_t size) {
    return fails(FAULT_MEMORY) ? no_memory() : counted(__libc_memalign(alignment, size));
}

EXPORTED void free(void *block) {
    if (block != NULL && atomic_load(&counting)) atomic_fetch_sub(&blocks, 1);
    __libc_free(block);
}

/* ---- files and threads ------------------------------------------------------------------------------------------- */

/* The next library's function of that name. */
#define NEXT(result, name, parameters)                                                                                 \
    static result(*next) parameters;                                                                                   \
    if (next == NULL) *(void **)&next = dlsym(RTLD_NEXT, name)

/* A function that gives failure and an error number where condition holds, and else does what it always does. */
#define FAILING(result, name, parameters, condition, failure, number, ...)                                             \
    EXPORTED result name parameters {                                                                                  \
        NEXT(result, #name, parameters);                                                                               \
        if (!(condition)) return next(__VA_ARGS__);                                                                    \
        errno = number;                                                                                                \
        return failure;                                                                                                \
    }

FAILING(size_t, fwrite, (const void *bytes, size_t size, size_t n, FILE *file), file != stderr && fails(FAULT_WRITE), 0,
        ENOSPC, bytes, size, n, file)
FAILING(int, fflush, (FILE * file), file != stderr && fails(FAULT_WRITE), EOF, EIO, file)
FAILING(int, fallocate, (int fd, int mode, off_t offset, off_t length), fails(FAULT_WRITE), -1, ENOSPC, fd, mode,
        offset, length)
FAILING(int, fclose, (FILE * file), fails(FAULT_WRITE) && next(file) <= 0, EOF, EDQUOT, file)
FAILING(int, fsync, (int fd), fails(FAULT_WRITE), -1, EIO, fd)
FAILING(int, fchmod, (int fd, mode_t mode), fails(FAULT_WRITE), -1, EPERM, fd, mode)
FAILING(int, fchown, (int fd, uid_t owner, gid_t group), fails(FAULT_WRITE), -1, EPERM, fd, owner, group)
FAILING(ssize_t, pwrite, (int fd, const void *bytes, size_t size, off_t offset), fails(FAULT_WRITE), -1, ENOSPC, fd,
        bytes, size, offset)
FAILING(int, rename, (const char *from, const char *to), fails(FAULT_RENAME), -1, EACCES, from, to)
FAILING(FILE *, fopen, (const char *path, const char *mode), fails(FAULT_OPEN), NULL, EMFILE, path, mode)
FAILING(FILE *, fdopen, (int fd, const char *mode), fails(FAULT_OPEN), NULL, ENOMEM, fd, mode)
FAILING(ssize_t, pread, (int fd, void *to, size_t size, off_t offset), fails(FAULT_READ), -1, EIO, fd, to, size, offset)
/* With glibc's mark of an error. */
FAILING(size_t, fread, (void *to, size_t size, size_t n, FILE *file), fails(FAULT_READ) && (file->_flags |= 0x20) != 0,
        0, EIO, to, size, n, file)
FAILING(int, fstat, (int fd, struct stat *about), fails(FAULT_READ), -1, EIO, fd, about)
FAILING(ssize_t, readlink, (const char *path, char *to, size_t size), fails(FAULT_READ), -1, EIO, path, to, size)

EXPORTED int open(const char *path, int flags, ...) {
    NEXT(int, "open", (const char *, int, ...));
    va_list list;
    va_start(list, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(list, mode_t) : 0;
    va_end(list);
    if (!fails(FAULT_OPEN)) return next(path, flags, mode);
    errno = EMFILE;
    return -1;
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

EXPORTED int pthread_create(pthread_t *thread, const pthread_attr_t *how, void *(*run)(void *), void *argument) {
    NEXT(int, "pthread_create", (pthread_t *, const pthread_attr_t *, void *(*)(void *), void *));
    if (fails(FAULT_THREAD)) return EAGAIN;
    start_of_thread *s = __libc_malloc(sizeof *s);
    *s = (start_of_thread){run, argument};
    const int status = atomic_fetch_sub(&room, 1) > 0 ? next(thread, how, run_counted, s) : EAGAIN;
    if (status == 0) return 0;
    atomic_fetch_add(&room, 1);
    __libc_free(s);
    return status;
}
