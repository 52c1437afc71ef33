/* SPDX-License-Identifier: Apache-2.0 */
/* Input files, opened and measured, with errors for a person; and remembered, so that no output replaces one of them.
 * They are known by device and inode: a name may be spelt in many ways, and links give a file several. */
#ifndef CELLWALK_IO_INPUTS_H
#define CELLWALK_IO_INPUTS_H

#include "io_error.h"

#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

/* From now on files are remembered as they are opened for reading, and outputs that would replace one or each other are
 * refused. A program that brings files up to date in place does without. */
void io_inputs_protect(void);
bool io_inputs_are_protected(void);

/* Remembers a file that will be read later than the output is opened; nothing unless protected. False when out of
 * memory. One that is not there is passed over: reading it will fail. */
bool io_inputs_note_path(const char *path);

/* True if that file is remembered. */
bool io_inputs_have(const struct stat *about);

/* Opens a regular file for reading. Returns the descriptor, which the caller closes, or -1: a directory, a pipe or a
 * device is also an error, because it has no size to check and cannot be mapped. */
int io_file_open(const char *path, uint64_t *size, io_error *error);

/* size bytes from offset on. False if the file ends before. */
bool io_file_read_at(int fd, const char *path, void *to, size_t size, uint64_t offset, io_error *error);

/* The whole file with a NUL byte behind it, to be freed by the caller; NULL on failure. */
char *io_file_read(const char *path, size_t *size, io_error *error);

#endif
