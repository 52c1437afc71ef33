/* SPDX-License-Identifier: Apache-2.0 */
/* How public functions of this library begin: what all of them check. */
#ifndef CELLWALK_TERRAIN_AREA_H
#define CELLWALK_TERRAIN_AREA_H

#include "sister.h"
#include "terrain.h"

/* Fails with the argument's name unless value is from least to most. */
cw_status cw_check_number(const char *name, double value, double least, double most);

/* Fails unless both pointers are there, the area is a part of the terrain, and its stride has room for a row's answers,
 * one for every so many samples. An empty area becomes all of the terrain, a stride of 0 the least, and *how *run. */
cw_status cw_area_begin(const terrain *t, const void *desc, const char *name, const cw_run *run, size_t every,
                        cw_area *area, cw_run *how);

/* As cw_field_enter. A terrain of samples alone has no updates. */
static inline bool cw_terrain_enter(const terrain *t, door_pass *in) {
    *in = (door_pass){NULL, 0, false};
    return t->field == NULL || cw_field_enter(t->field, in);
}

/* The run of items from begin to end of count; *part is its room. */
static inline cw_run cw_run_share(run_part *part, const cw_run *whole, size_t begin, size_t end, size_t count) {
    *part = (run_part){whole, (double)begin / (double)count, (double)end / (double)count};
    return cw_run_part_of(part);
}

#endif
