/* SPDX-License-Identifier: Apache-2.0 */
/* What a figure depends on besides the code: machine, load, compiler, flags, commit, seed. First line of every JSON file,
 * last line of every printed table. */
#ifndef CELLWALK_BENCH_HARNESS_RUN_RECORD_H
#define CELLWALK_BENCH_HARNESS_RUN_RECORD_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Keeps for the record the arguments that the program was started with, its name not among them, as one may type them
 * after "cellwalk-bench", and how many CPUs it may use. To be called before anything takes the arguments apart or pins the
 * program to a CPU. */
void run_record_begin(char **arguments, int count);

/* A JSON object of kind "run"; NULL if out of memory. cpu is where the process is pinned to, or -1. */
json_t *run_record(const char *command, uint32_t seed, int cpu);

/* True if so many bytes may be had without swapping, or the system does not tell; else prints that what is left out on field. */
bool run_memory_has(double bytes, const char *what, const char *field);

/* One line of it for a person: "AMD EPYC, GCC 12.2.0, avx2, commit 1234567, Embree 3.13.5, one thread, load 0.42". */
void run_record_text(const json_t *record, char *text, size_t size);

#endif
