/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_BENCH_TRADEOFF_MAIN_H
#define CELLWALK_BENCH_TRADEOFF_MAIN_H

#include "tradeoff.h"

/* All measurements, as JSON lines appended to the array. */
bool tradeoff_run(const tradeoff_options *options, json_t *lines, io_error *error);

/* The page made from the lines; the same lines give the same text. NULL if out of memory. The caller frees it. */
char *tradeoff_markdown(const json_t *lines);

int tradeoff_main(char **arguments, int count);

#endif
