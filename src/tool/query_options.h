/* SPDX-License-Identifier: Apache-2.0 */
/* The options by which every subcommand that traces chooses kernel, leaf test, instruction set and threads. */
#ifndef CELLWALK_TOOL_QUERY_OPTIONS_H
#define CELLWALK_TOOL_QUERY_OPTIONS_H

#include "cellwalk_expert.h"
#include "options.h"

typedef struct query_options {
    int kernel, leaf, isa; /* numbers of names; -1: not given */
    unsigned threads;      /* 0: one per CPU */
} query_options;

/* The rows' places. */
enum { QUERY_KERNEL, QUERY_LEAF, QUERY_ISA, QUERY_THREADS, QUERY_OPTION_COUNT };

/* Sets *q to nothing given, and fills in the four rows of a subcommand's table that set it. */
void query_options_rows(query_options *q, option_spec rows[QUERY_OPTION_COUNT]);

/* Limits the instruction set as --isa says, checks CELLWALK_ISA, and turns numbers of names into a query without a pool. Its
 * kernel stays NULL if none was named: cw_run_kernel then tells which one a field gets. False, after a message, when that is impossible: end with EXIT_USAGE. To be called before any query runs. name is the
 * subcommand's. */
bool query_options_resolve(const query_options *q, const char *name, cw_run *query);

#endif
