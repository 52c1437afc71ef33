/* SPDX-License-Identifier: Apache-2.0 */
#include "micro/counters.h"

#include "cellwalk.h"

#include <string.h>

#define CELLWALK_COUNT /* for the declaration of what the counting objects write to */
#include "count.h"

count_sum cw_counts[COUNT_KINDS];

static const struct {
    const char *name, *what;
} kinds[] = {
    [COUNT_RAY] = {"ray", "vectors of rays made ready; lanes: rays that may hit"},
    [COUNT_CLIMB] = {"climb", "levels of the pyramid that climbing rays looked at"},
    [COUNT_FLAT] = {"flat", "steps from cell to cell"},
    [COUNT_STREAM] = {"stream", "turns of the lane walk; lanes: those that hold a ray"},
    [COUNT_NODE] = {"node", "turns in which lanes step from node to node; lanes: those that do"},
    [COUNT_ROUND] = {"round", "turns in which lanes test the cell they are at; lanes: those that do"},
    [COUNT_RELOAD] = {"reload", "stops of the lane walk to refill lanes; lanes: those that hold a ray then"},
    [COUNT_REFILL] = {"refill", "rays put into a lane"},
    [COUNT_SHARED] = {"shared", "groups that share their walk; lanes: their rays"},
    [COUNT_SHARED_NODE] = {"shared_node", "nodes that a group opens; lanes: its rays"},
    [COUNT_SHARED_BLOCK] = {"shared_block", "blocks of 4 x 4 cells that a group comes to; lanes: rays concerned"},
    [COUNT_SHARED_CELL] = {"shared_cell", "cells that a group looks at together; lanes: its rays"},
    [COUNT_APART] = {"apart", "places where a group falls apart; lanes: rays that go on alone there"},
    [COUNT_LEAF] = {"leaf", "leaf tests; lanes: rays against a cell, two triangles each"},
    [COUNT_VOXEL] = {"voxel", "voxels of the 3D grid visited"},
    [COUNT_TRIANGLE] = {"triangle", "triangles tested in voxels"},
};
_Static_assert(sizeof kinds / sizeof kinds[0] == COUNT_KINDS, "a kind has no name");
_Static_assert((int)COUNT_KINDS <= (int)COUNTERS_MAX, "COUNTERS_MAX is too small");

size_t counters_count(void) { return COUNT_KINDS; }
const char *counters_name(size_t number) { return number < COUNT_KINDS ? kinds[number].name : NULL; }
const char *counters_what(size_t number) { return number < COUNT_KINDS ? kinds[number].what : NULL; }

const counter *counters_find(const counter *all, const char *name) {
    size_t k = 0;
    while (strcmp(kinds[k].name, name) != 0) k++;
    return &all[k];
}

void counters_reset(void) { memset(cw_counts, 0, sizeof cw_counts); }

void counters_read(counter all[COUNTERS_MAX]) {
    memset(all, 0, COUNTERS_MAX * sizeof *all);
    for (size_t k = 0; k < COUNT_KINDS; k++) all[k] = (counter){cw_counts[k].events, cw_counts[k].lanes};
}

bool counters_here(void) {
    static const float flat[4] = {0, 0, 0, 0};
    cw_field_desc desc = cw_field_desc_default();
    desc.samples = flat;
    desc.nx = desc.ny = 2;
    desc.bare = true;
    cw_field *field = NULL;
    if (cw_field_create(&desc, &field) != CW_OK) return false;
    const cw_query query = {.kernel = cw_kernel_find("cell")};
    const cw_ray ray = {.org = {0.5f, 0.25f, 1}, .dir = {0, 0, -1}, .tmax = 2};
    cw_hit hit;
    const uint64_t before = cw_counts[COUNT_FLAT].events;
    const bool counted = cw_closest(field, &query, &ray, 1, &hit) == CW_OK && cw_counts[COUNT_FLAT].events > before;
    cw_field_destroy(field);
    return counted;
}
