/* SPDX-License-Identifier: Apache-2.0 */
/* The guard's instruction counts: the committed file, and the changes since. */
#ifndef CELLWALK_BENCH_INSTRUCTIONS_FIGURES_H
#define CELLWALK_BENCH_INSTRUCTIONS_FIGURES_H

#include "instructions/callgrind.h"
#include "output.h"

enum { GUARD_BUILD = 512 };

typedef struct guard_figures {
    char compiler[GUARD_BUILD], flags[GUARD_BUILD]; /* the figures hold for these alone */
    counted all;
} guard_figures;

/* The committed file: comments with compiler and flags, a heading, a line a figure. */
bool guard_read(guard_figures *figures, const char *path, io_error *error);
bool guard_write(const guard_figures *figures, io_output *out, io_error *error);

/* Per cent that may change unremarked. The same compiler repeats a build to the instruction, so this is for changes of
 * the source that mean nothing, such as a constant in another register. */
enum { GUARD_TOLERANCE = 2 };

typedef struct guard_verdict {
    size_t compared, above, below; /* beyond the tolerance */
    size_t missing;                /* counted, but without a committed figure, or for other rays */
    size_t stale;                  /* committed, but of no kernel that the program has */
    size_t absent;                 /* committed, but not for this machine */
} guard_verdict;

/* A line on report for each that is not as it should be. */
guard_verdict guard_compare(const counted *committed, const counted *now, FILE *report);

#endif
