/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_ACCURACY_RUN_H
#define CELLWALK_BENCH_ACCURACY_RUN_H

#include "accuracy/tradeoff.h"

/* All measurements, as JSON lines appended to the array. */
bool tradeoff_run(const tradeoff_options *options, json_t *lines, io_error *error);

/* Prints the contenders, fastest first, from their lines of kind "summary". */
void tradeoff_print(const json_t *lines);

int tradeoff_main(char **arguments, int count);

#endif
