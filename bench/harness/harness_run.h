/* SPDX-License-Identifier: Apache-2.0 */
/* Common parts of the subcommands that measure: the options for instruction set, CPU and seed, and the record of all
 * that a figure depends on besides the code. It is the first line of every JSON file and of every printed table. */
#ifndef CELLWALK_BENCH_HARNESS_HARNESS_RUN_H
#define CELLWALK_BENCH_HARNESS_HARNESS_RUN_H

#include "command.h"
#include "io_error.h"
#include "options.h"

#include <jansson.h>
#include <stdint.h>

/* cmd_measure.c */
extern const command command_table, command_measure;

/* ---- options ---- */

typedef struct run_options {
    unsigned seed;
    int isa; /* a cw_isa after run_options_check; before it the number of a name, or below 0 for the best */
    bool no_pin;
} run_options;

/* The defaults, and the rows of a subcommand's table that change them. */
#define RUN_DEFAULTS ((run_options){.seed = 1, .isa = -1})
#define RUN_OPTIONS(run)                                                                                               \
    option_choice("isa", "NAME", &(run).isa, option_isa_names,                                                         \
                  "the highest instruction set that kernels and Embree use; by default the best here"),                \
        option_count("seed", "N", &(run).seed, 0, UINT_MAX, "seed of the rays and of the order of contenders (1)"),    \
        option_flag("no-pin", &(run).no_pin, "let the system move the program between CPUs")

/* Limits the library to the instruction set; false, after a message, if machine or CELLWALK_ISA does not allow it. */
bool run_options_check(run_options *run, const char *name);

/* Keeps the program on its CPU: that CPU, or -1 if it is to be free. False if the system does not allow it. */
bool run_options_pin(const run_options *run, int *cpu, io_error *error);

/* ---- record ---- */

/* Keeps for the record the arguments that the program was started with, its name not among them, as one may type
 * them after "cellwalk-bench", and how many CPUs it may use. To be called before anything takes the arguments apart
 * or pins the program to a CPU. */
void run_record_begin(char **arguments, int count);

/* A JSON object of kind "run". cpu is where the process is pinned to, or -1. */
json_t *run_record(const char *name, uint32_t seed, int cpu);

/* True if so many bytes are free without swapping, or if the system does not say. Else false, the reason in why. */
bool run_memory_has(double bytes, char why[192]);

/* One line of it for a person: "AMD EPYC, GCC 12.2.0, avx2, commit 1234567, Embree 3.13.5, one thread, load 0.42". */
void run_record_text(const json_t *record, char *text, size_t size);

#endif
