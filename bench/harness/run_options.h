/* SPDX-License-Identifier: Apache-2.0 */
/* The options of every subcommand that measures: which instruction sets, on which CPU, from which seed. */
#ifndef CELLWALK_BENCH_HARNESS_RUN_OPTIONS_H
#define CELLWALK_BENCH_HARNESS_RUN_OPTIONS_H

#include "cellwalk.h"
#include "error.h"
#include "options.h"

typedef struct run_options {
    unsigned seed;
    int isa;      /* a cw_isa; below 0 the best that may be used here, until run_options_check */
    unsigned cpu; /* UINT_MAX: the one that the program is on */
    bool no_pin;
} run_options;

enum { RUN_OPTION_COUNT = 4 };

/* Sets the defaults and fills in the rows of a subcommand's table that change them. */
void run_options_rows(run_options *run, option_spec rows[RUN_OPTION_COUNT]);

/* Limits the library to the instruction set; false, after a message, if this machine or CELLWALK_ISA does not allow it. */
bool run_options_check(run_options *run, const char *name);

/* Keeps the program on its CPU: that CPU, or -1 if it is to be free. False if the system does not allow it. */
bool run_options_pin(const run_options *run, int *cpu, io_error *error);

#endif
