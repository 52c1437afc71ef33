/* SPDX-License-Identifier: Apache-2.0 */
/* How far a coarser field lies from the field that it was made of. */
#ifndef CELLWALK_TERRAIN_DIFFERENCE_H
#define CELLWALK_TERRAIN_DIFFERENCE_H

#include "cellwalk_expert.h"
#include "cellwalk_terrain.h"
#include "samples.h"

/* Samples of the full field that a thread takes at a time, more or less. */
enum { COARSER_GRAIN = 1 << 18 };

/* coarser has the full field's every factor-th place. On the run's pool and under its watch. */
cw_status cw_difference_measure(const samples *full, const samples *coarser, size_t factor, const cw_run *run,
                                cw_difference *difference);

#endif
