/* SPDX-License-Identifier: Apache-2.0 */
/* Output files, renamed into place when complete. The bytes go to a nameless file in the same directory (O_TMPFILE),
 * or to a temporary one if the file system has no nameless files. It takes its name in one step, after its bytes are
 * on the disk. A failure before that changes neither the directory nor an existing file of that name, and a nameless
 * file vanishes even after SIGKILL. Devices and pipes (/dev/stdout) have no such step and are written directly; "-"
 * is standard output. No output replaces an input (inputs.h). */
#ifndef CELLWALK_IO_OUTPUT_H
#define CELLWALK_IO_OUTPUT_H

#include "error.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct io_output {
    FILE *file;   /* open for writing, at its start; NULL while the output is not open */
    char *name;   /* as the caller gave it, for messages */
    char *target; /* the final name: name with symbolic links followed */
    bool unnamed; /* it has no name at all yet */
    int slot;
} io_output;

/* Creates the file; path "-" is standard output, which is written to as it is. Outputs may be open side by side, at
 * most IO_OUTPUT_MAX in a process. A target that is a directory or may not be written to is refused here, before any
 * work. On failure out needs no discard. */
enum { IO_OUTPUT_MAX = 16 };
bool io_output_open(io_output *out, const char *path, io_error *error);

/* Makes a folder and those that it lies in; it may exist already. */
bool io_folder_make(const char *path, io_error *error);
/* Opens the file in the folder, which is made if need be. */
bool io_output_open_in(io_output *out, const char *folder, const char *name, io_error *error);
/* The same file by a temporary name, which it gets here if it had none: for libraries and programs that open files
 * themselves. Valid until the output is committed or discarded; NULL, with errno, if no name can be given. */
const char *io_output_temporary(io_output *out);

/* Claims room for a file of this size, so that a full disk is found out before the work and not after it. File systems
 * that cannot promise room do not fail here. */
bool io_output_reserve(io_output *out, uint64_t bytes, io_error *error);

/* Writes to out->file. False, with the file and the system's reason in error, when that fails. */
bool io_output_write(io_output *out, const void *bytes, size_t size, io_error *error);

/* The same of text as printf writes it. */
__attribute__((format(printf, 3, 4))) bool io_output_print(io_output *out, io_error *error, const char *format, ...);

/* Flushes, closes and gives the file its name. On failure everything is discarded. out may be discarded again. */
bool io_output_commit(io_output *out, io_error *error);

/* The same of two files that belong together: neither gets its name before the bytes of both are on the disk. Then beside
 * gets its name first. If out cannot get its own after that, beside is removed again. A file that beside replaced comes back if it
 * can have two names at a time (hard links); else beside stays. */
bool io_output_commit_both(io_output *out, io_output *beside, io_error *error);

/* Closes and removes the file. Does nothing on an output that is not open (all zero, committed, discarded). */
void io_output_discard(io_output *out);

/* Removes the files of all open outputs, whose commit then fails. Async-signal-safe: for a handler that is
 * about to end the process. */
void io_output_discard_all(void);

#endif
