/* SPDX-License-Identifier: Apache-2.0 */
/* The vector kernels of this library, each compiled for the instruction sets of simd/isas.cmake. */
#ifndef CELLWALK_TERRAIN_CODES_H
#define CELLWALK_TERRAIN_CODES_H

#include "heading.h"
#include "visible_job.h"

typedef struct terrain_code {
    cw_isa isa;
    cw_heading_fn *heading;
    const visible_code *visible;
} terrain_code;

/* Settles how and finds the code for it. Of its kernel only the instruction set is used. */
cw_status cw_terrain_settle(cw_run *how, const terrain_code **code);

#endif
