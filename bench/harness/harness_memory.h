/* SPDX-License-Identifier: Apache-2.0 */
/* Room for rays, answers and results. Without it a program that measures has nothing left to do: it ends, with a
 * message and without unfinished files. */
#ifndef CELLWALK_BENCH_HARNESS_HARNESS_MEMORY_H
#define CELLWALK_BENCH_HARNESS_HARNESS_MEMORY_H

#include "command.h"
#include "output.h"

#include <stdlib.h>

/* Ends the program. */
static inline _Noreturn void memory_end(void) {
    io_output_discard_all();
    exit(command_fail("", "out of memory"));
}

/* count things of this size, all zero, to be freed with free(). */
static inline void *memory(size_t count, size_t size) {
    void *room = calloc(count ? count : 1, size);
    if (room == NULL) memory_end();
    return room;
}

#endif
