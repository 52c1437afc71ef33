/* SPDX-License-Identifier: Apache-2.0 */
/* The files that a program has read, so that no output replaces one of them. Known by device and inode: a name may be
 * spelt in many ways, and links give a file several. */
#ifndef CELLWALK_IO_INPUTS_H
#define CELLWALK_IO_INPUTS_H

#include "io_error.h"

#include <sys/stat.h>

/* From now on files are remembered as they are opened for reading, and outputs that would replace one or each other are
 * refused. A program that brings files up to date in place does without. */
void io_inputs_protect(void);
bool io_inputs_are_protected(void);

/* For readers: notes that the file described by about is read. False when out of memory. Remembers nothing unless protected. */
bool io_inputs_note(const struct stat *about);

/* The same by name, for a file that will be read later than the output is opened. One that is not there is passed over:
 * reading it will fail. */
bool io_inputs_note_path(const char *path);

/* True if that file is remembered. */
bool io_inputs_have(const struct stat *about);

#endif
