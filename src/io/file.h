/* SPDX-License-Identifier: Apache-2.0 */
/* Input files, opened and measured, with errors for a person. */
#ifndef CELLWALK_IO_FILE_H
#define CELLWALK_IO_FILE_H

#include "io_error.h"

#include <stddef.h>
#include <stdint.h>

/* Opens a regular file for reading. Returns the descriptor, which the caller closes, or -1: a directory, a pipe or a
 * device is also an error, because it has no size to check and cannot be mapped. */
int io_file_open(const char *path, uint64_t *size, io_error *error);

/* size bytes from offset on. False if the file ends before. */
bool io_file_read_at(int fd, const char *path, void *to, size_t size, uint64_t offset, io_error *error);

/* The whole file with a NUL byte behind it, to be freed by the caller; NULL on failure. */
char *io_file_read(const char *path, size_t *size, io_error *error);

#endif
