/* SPDX-License-Identifier: Apache-2.0 */
#include "micro/counters.h"

#include "cellwalk.h"
#include "command.h"
#include "harness/child.h"
#include "workload/fields.h"

#include <errno.h>
#include <string.h>

#define CELLWALK_COUNT /* for the declaration of the counts */
#include "count.h"

count_sum cw_counts[COUNT_KINDS];

/* In the order of count_kind. */
static const char *const names[] = {"ray",    "climb",  "flat",   "stream",      "node",         "round",
                                    "reload", "refill", "shared", "shared_node", "shared_block", "shared_cell",
                                    "apart",  "leaf",   "voxel",  "triangle"};
_Static_assert(sizeof names / sizeof names[0] == COUNT_KINDS, "a kind has no name");
_Static_assert((int)COUNT_KINDS <= (int)COUNTERS_MAX, "COUNTERS_MAX is too small");

size_t counters_count(void) { return COUNT_KINDS; }
const char *counters_name(size_t number) { return names[number]; }

void counters_reset(void) { memset(cw_counts, 0, sizeof cw_counts); }

void counters_read(counter all[COUNTERS_MAX]) {
    for (size_t k = 0; k < COUNT_KINDS; k++) all[k] = (counter){cw_counts[k].events, cw_counts[k].lanes};
}

json_t *counters_json(const counter all[COUNTERS_MAX]) {
    json_t *counts = json_object();
    for (size_t k = 0; k < COUNT_KINDS; k++)
        if (all[k].events > 0)
            json_object_set_new(
                counts, names[k],
                json_pack("{s:I, s:I}", "events", (json_int_t)all[k].events, "lanes", (json_int_t)all[k].lanes));
    return counts;
}

bool counters_here(void) {
    float flat[4] = {0, 0, 0, 0};
    cw_field *field = NULL;
    if (workload_field_open(&(workload_field){.nx = 2, .ny = 2, .z = flat}, CW_BORROW, true, &field) != CW_OK)
        return false;
    const cw_run query = {.kernel = cw_kernel_find("cell")};
    const cw_ray ray = {.org = {0.5f, 0.25f, 1}, .dir = {0, 0, -1}, .tmax = 2};
    cw_hit hit;
    const uint64_t before = cw_counts[COUNT_FLAT].events;
    const bool counted = cw_closest(field, &query, &ray, 1, &hit) == CW_OK && cw_counts[COUNT_FLAT].events > before;
    cw_field_destroy(field);
    return counted;
}

int counters_elsewhere(int argc, char **argv) {
    bool wanted = false;
    for (int k = 1; k < argc; k++) wanted = wanted || strcmp(argv[k], "--counters") == 0;
    if (!wanted || counters_here()) return -1;
    const int status = child_run_counting(argc, argv);
    return status >= 0 && status != 127
               ? status
               : command_fail(argv[0], "--counters: cellwalk-bench-counting does not start: %s", strerror(errno));
}
