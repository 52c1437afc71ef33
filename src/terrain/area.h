/* SPDX-License-Identifier: Apache-2.0 */
/* How public functions of this library begin: what all of them check. */
#ifndef CELLWALK_TERRAIN_AREA_H
#define CELLWALK_TERRAIN_AREA_H

#include "sister.h"
#include "terrain.h"

/* Fails with the argument's name unless value is from least to most. */
cw_status cw_check_number(const char *name, double value, double least, double most);
/* So far under the ground a place may be, in metres: its height may come from decimals, and floats are known to half a millimetre at
 * 8000 m. */
#define CW_LEAST_DEPTH 1e-3
/* Heights of eyes and targets, in the samples' numbers. Samples are within it too, and products of exact decisions do not overflow. */
#define CW_EYE_HEIGHT_MOST 0x1p120

/* Fails unless both pointers are there, and the area is a part of the terrain. All of it if it is empty. *how becomes *run. */
cw_status cw_area_begin(const terrain *t, const void *desc, const char *name, const cw_run *run, cw_area *area,
                        cw_run *how);

/* As cw_field_enter. A terrain of samples alone has no updates. */
static inline bool cw_terrain_enter(const terrain *t, door_pass *in) {
    *in = (door_pass){NULL, 0, false};
    return t->field == NULL || cw_field_enter(t->field, in);
}

/* Sets a stride of 0; fails with one that is too small. */
cw_status cw_area_stride(cw_area *area);

/* The run of number k of count equal parts; *part is its room. */
static inline cw_run cw_run_share(run_part *part, const cw_run *whole, size_t k, size_t count) {
    *part = (run_part){whole, (double)k / (double)count, (double)(k + 1) / (double)count};
    return cw_run_part_of(part);
}

#endif
