/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' counts (src/core/count.h). Only cellwalk-bench-counting has kernels that count; to all other programs
 * that link this, the counts stay 0. */
#ifndef CELLWALK_BENCH_MICRO_COUNTERS_H
#define CELLWALK_BENCH_MICRO_COUNTERS_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

enum { COUNTERS_MAX = 32 };

/* Events, and the lanes (or rays of a group) that took part in them, summed. */
typedef struct counter {
    uint64_t events, lanes;
} counter;

/* How many there are; their names, such as "node" and "leaf". src/core/count.h describes them. */
size_t counters_count(void);
const char *counters_name(size_t number);

void counters_reset(void);
/* The counts since then, by kernels on any thread but not on two at once. */
void counters_read(counter all[COUNTERS_MAX]);

/* {"flat": {"events": 1, "lanes": 8}} of all that have events. */
json_t *counters_json(const counter all[COUNTERS_MAX]);

/* True if the kernels of this program count: tries one. */
bool counters_here(void);

/* If the arguments have --counters and the kernels of this program do not count, runs cellwalk-bench-counting with them: its
 * exit status; else -1. */
int counters_elsewhere(int argc, char **argv);

#endif
