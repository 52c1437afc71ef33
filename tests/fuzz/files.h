/* SPDX-License-Identifier: Apache-2.0 */
/* A fuzzer's input as files, for readers that take names. */
#ifndef CELLWALK_TESTS_FUZZ_FILES_H
#define CELLWALK_TESTS_FUZZ_FILES_H

#include <fcntl.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static char fuzz_folder[64];

static void fuzz_leave(void) {
    if (chdir("/") == 0) rmdir(fuzz_folder);
}

/* A folder of this process alone becomes the working directory: in memory, as a disk would be what takes the time. */
static inline void fuzz_enter(void) {
    if (fuzz_folder[0] != '\0') return;
    snprintf(fuzz_folder, sizeof fuzz_folder, "%s/cellwalk-fuzz-XXXXXX",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    if (mkdtemp(fuzz_folder) == NULL || chdir(fuzz_folder) != 0) abort();
    atexit(fuzz_leave);
}

static inline void fuzz_write(const char *name, const uint8_t *data, size_t size) {
    const int fd = open(name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || write(fd, data, size) != (ssize_t)size) abort();
    close(fd);
}

#endif
