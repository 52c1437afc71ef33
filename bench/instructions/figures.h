/* SPDX-License-Identifier: Apache-2.0 */
/* Instruction counts: read from what callgrind wrote, read from and written to the committed file, compared. */
#ifndef CELLWALK_BENCH_INSTRUCTIONS_FIGURES_H
#define CELLWALK_BENCH_INSTRUCTIONS_FIGURES_H

#include "error.h"
#include "output.h"

#include <stddef.h>
#include <stdint.h>

enum { GUARD_FIGURES_MAX = 256, GUARD_NAME = 32, GUARD_BUILD = 256 };

typedef struct guard_figure {
    char kernel[GUARD_NAME], leaf[GUARD_NAME], rays[GUARD_NAME];
    uint64_t count; /* rays traced */
    uint64_t
        instructions; /* for all of them; 0 where this machine cannot run the kernel, which then has no leaf, rays */
} guard_figure;

typedef struct guard_figures {
    char compiler[GUARD_BUILD], flags[GUARD_BUILD]; /* the figures hold for these alone */
    guard_figure items[GUARD_FIGURES_MAX];
    size_t count;
} guard_figures;

/* Takes the lines that the workload printed and the profile that callgrind wrote meanwhile, one part a line. Only what
 * runs in the program itself counts, whose file is called program: libc and libm differ between machines of the same
 * system, because they choose their functions by the CPU. Does not touch compiler and flags. */
bool guard_read_counts(guard_figures *figures, const char *runs_path, const char *profile_path, const char *program,
                       io_error *error);

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
guard_verdict guard_compare(const guard_figures *committed, const guard_figures *counted, FILE *report);

#endif
