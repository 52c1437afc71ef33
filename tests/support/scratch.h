/* SPDX-License-Identifier: Apache-2.0 */
/* A new directory for a test, which is also the working directory while the test runs. */
#ifndef CELLWALK_TESTS_SCRATCH_H
#define CELLWALK_TESTS_SCRATCH_H

#include <stddef.h>

/* cmocka's setup and teardown. */
int scratch_enter(void **state);
int scratch_leave(void **state);

void scratch_write(const char *name, const void *bytes, size_t size);
/* The whole file, which the caller frees; a NUL byte stands behind it. */
char *scratch_read(const char *name, size_t *size);

/* Entries of the directory, hidden ones included, "." and ".." not. */
size_t scratch_entries(void);

#endif
