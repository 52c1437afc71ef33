/* SPDX-License-Identifier: Apache-2.0 */

/* What terrain people ask of a height field. A library beside libcellwalk, libcellwalk_terrain; words, errors, threads and rules of
 * growth are those of cellwalk.h. */

#ifndef CELLWALK_TERRAIN_H
#define CELLWALK_TERRAIN_H

#include "cellwalk.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- coarser fields ---------------------------------------------------------------------------------------------- */

/* How the height at each place of a coarser field follows from the samples around it. */
enum {
    /* The mean of the samples less than factor away along x and along y, weighted by a tent: for views and most
     * products. A hole where holes have more than half of the weight. */
    CW_FILTER_MEAN = 0,
    /* The highest sample at most factor away: the coarser surface is nowhere below the full one, so no obstacle is
     * missed. A hole where all of these samples are holes: no triangle is lost. */
    CW_FILTER_HIGHEST = 1,
    /* The lowest one: nowhere above the full surface, so no obstacle is invented. A hole where one of these samples
     * is a hole: no triangle is made. */
    CW_FILTER_LOWEST = 2
};

/* How far a coarser surface lies from the full one: heights in field space, over the full field's triangles where
 * both have a surface. */
typedef struct cw_difference {
    double above, below; /* no point lies farther above or below the full surface; 0: none lies there at all */
    double rms;          /* root mean square over the area */
    /* Triangles of the full field where only the full one has a surface, and where only the coarser one has. */
    uint64_t lost, made;
} cw_difference;

/* Makes a field of every factor-th place, factor from 2 to CW_SIDE_MAX: sample (i, j) stands at (factor i, factor j)
 * of the full field. It has ceil((nx - 1) / factor) + 1 samples a row, and rows alike. Where factor does not divide
 * nx - 1, the last samples stand less than factor cells beyond the full field's border, and samples within the field
 * determine them. Both maps lead to the same user space, so t of a user-space ray means the same on both.
 *
 * The caller owns the coarser field, which has a copy of its samples and the structure that run's kernel walks on.
 * The first size bytes of a cw_difference go to difference, which may be NULL. The field has the same bits for any pool. On failure *coarser is NULL: CW_ERROR_ARGUMENT,
 * _KERNEL, _MEMORY, _CANCELLED, or _BUSY during an update of the full field. */
CW_API cw_status cw_field_coarser(const cw_field *field, const cw_run *run, size_t factor, int32_t filter,
                                  cw_field **coarser, cw_difference *difference, size_t size);

#ifdef __cplusplus
}
#endif

#endif
