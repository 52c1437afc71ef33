/* SPDX-License-Identifier: Apache-2.0 */
/* Runs the work (work.c) under callgrind, which counts inside its function guard_trace alone, a part each time that
 * it returns, and reads the counts. */
#ifndef CELLWALK_BENCH_INSTRUCTIONS_CALLGRIND_H
#define CELLWALK_BENCH_INSTRUCTIONS_CALLGRIND_H

#include "error.h"

#include <stddef.h>
#include <stdint.h>

enum { COUNTED_MAX = 512, COUNTED_NAME = 32 };

/* The counts of each run, in callgrind's order; those from DR on only when it models caches. */
typedef enum event { IR, DR, DW, I1MR, D1MR, D1MW, ILMR, DLMR, DLMW, EVENTS } event;

typedef struct counted_run {
    char kernel[COUNTED_NAME], leaf[COUNTED_NAME], field[COUNTED_NAME], rays[COUNTED_NAME];
    uint64_t
        count; /* rays traced; 0 if this machine cannot run the kernel: then there is no leaf, field, rays and events */
    uint64_t events[EVENTS];
} counted_run;

typedef struct counted {
    counted_run runs[COUNTED_MAX];
    size_t count;
} counted;

/* Takes the lines that the work printed and the profile that callgrind wrote meanwhile, one part a line. Only code
 * of the program itself counts, whose file is called program: libc and libm differ between machines of the same
 * system, because they choose their functions by the CPU. */
bool callgrind_read(counted *all, const char *runs_path, const char *profile_path, const char *program,
                    io_error *error);

/* work: the program and its arguments, ending with NULL; at most 8. options: of callgrind, ending with NULL, at most
 * 4; or NULL for none. Leaves NAME.runs, NAME.callgrind and NAME.errors, the work's standard error, in the current
 * folder. False with *missing set if valgrind is not installed. */
bool callgrind_run(counted *all, const char *name, const char *const *work, const char *const *options, bool *missing,
                   io_error *error);

/* ---- lines of commas, also for the guard's file ---- */

/* Cuts the next name or number off a line; false if it is missing, empty, too long or anything else. */
bool callgrind_take_name(char **rest, char name[COUNTED_NAME]);
bool callgrind_take_number(char **rest, uint64_t *number);

/* Calls take for each line, without its end, until it returns false. */
typedef bool callgrind_take_line(void *context, char *line);
bool callgrind_read_lines(const char *path, callgrind_take_line *take, void *context, io_error *error);

#endif
