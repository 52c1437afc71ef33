/* SPDX-License-Identifier: Apache-2.0 */
/* Output files, renamed into place when complete. The bytes go to a hidden file in the same folder, ".NAME.16
 * digits.tmp", removed when the output fails and when the process ends or is interrupted. A file that is replaced stays
 * as it is until the new bytes are on the disk; the new one has its owner, group, access list and permissions. In a
 * sticky folder writable for all, as /tmp, only the user's links and the folder owner's are followed. Devices and pipes
 * (/dev/stdout) are written directly; "-" is standard output. No output replaces an input (inputs.h). */
#ifndef CELLWALK_IO_OUTPUT_H
#define CELLWALK_IO_OUTPUT_H

#include "io_error.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* Whether a file's name has that ending, in capitals or not. */
static inline bool io_name_ends(const char *path, const char *ending) {
    const size_t length = strlen(path), size = strlen(ending);
    return length > size && strcasecmp(path + length - size, ending) == 0;
}

typedef struct io_output {
    FILE *file;   /* open for writing, at its start; NULL once the output is settled, and while it is not open */
    char *name;   /* as the caller gave it, for messages; NULL while the output is not open */
    char *target; /* the final name: name with symbolic links followed */
    bool direct;  /* the target itself is written to: a device, a pipe or a descriptor */
    int slot;
} io_output;

/* Creates the file; path "-" is standard output. At most IO_OUTPUT_MAX outputs may be open at a time in a process. A
 * target that is a directory or may not be written to is refused here, before any work. Once io_inputs_protect was
 * called, so is an input, a file that another open output is for, and one that standard output or error leads to. On
 * failure out needs no discard. */
enum { IO_OUTPUT_MAX = 64 };
bool io_output_open(io_output *out, const char *path, io_error *error);

/* The descriptor that a name stands for, "-" or one of the system's; else -1. Such an output goes where the descriptor
 * leads: a file that a shell opened to append to must not be replaced. */
int io_output_descriptor(const char *path);

/* The name of the temporary file of an output that is not direct, for libraries that open files themselves. */
const char *io_output_temporary(const io_output *out);

/* A temporary file beside that of another output, for intermediate results: suffix is added to its name. It is
 * discarded, never committed. */
bool io_output_open_scratch(io_output *out, const io_output *beside, const char *suffix, io_error *error);

/* Claims room for a file of this size, so that a full disk is found out before the work and not after it. File systems
 * that cannot promise room do not fail here. */
bool io_output_reserve(io_output *out, uint64_t bytes, io_error *error);

/* Writes to out->file. False, with the file and the system's reason in error, when that fails. */
bool io_output_write(io_output *out, const void *bytes, size_t size, io_error *error);

/* For libraries that write to the file themselves and have failed: tries to write more, which spoils the file. False,
 * with the system's reason, if that fails. */
bool io_output_has_room(io_output *out, io_error *error);

/* Writes text as printf writes it in the C locale. */
__attribute__((format(printf, 3, 4))) bool io_output_print(io_output *out, io_error *error, const char *format, ...);

/* Flushes and closes the file, and waits until its bytes are on the disk. Of outputs that belong together, all are
 * settled before the first is committed. On failure everything is discarded. */
bool io_output_settle(io_output *out, io_error *error);

/* Settles the file and gives it its name. On failure everything is discarded. out may be discarded again. */
bool io_output_commit(io_output *out, io_error *error);

/* Closes and removes the file. Does nothing on an output that is not open (all zero, committed, discarded). */
void io_output_discard(io_output *out);

/* Removes the files of all open outputs, whose commit then fails. Async-signal-safe: for a handler that is
 * about to end the process. */
void io_output_discard_all(void);

#endif
