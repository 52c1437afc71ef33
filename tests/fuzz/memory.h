/* SPDX-License-Identifier: Apache-2.0 */
/* A fuzzer's input as files, for readers that take names: in memory, since calls to the system would take ten times as long
 * as most readers do. memory.c stands between the readers and libc; there are no other files, whatever an input names. */
#ifndef CELLWALK_TESTS_FUZZ_MEMORY_H
#define CELLWALK_TESTS_FUZZ_MEMORY_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MEMORY_FILES_MAX = 8 };

/* There are these files alone until memory_done. File number holds these bytes, which stay the caller's. */
void memory_file(size_t number, const char *name, const uint8_t *data, size_t size);
void memory_done(void);

#endif
