/* SPDX-License-Identifier: Apache-2.0 */
/* How steep the terrain rises before each sample as seen from one place, between bounds: found for all samples
 * together, in a sweep outward, so that a line of sight has to be followed only where the bounds leave the answer
 * open. */
#ifndef CELLWALK_TERRAIN_SWEEP_H
#define CELLWALK_TERRAIN_SWEEP_H

#include "sight.h"

/* Results on the way to a sample. */
typedef struct sweep_way {
    double low;         /* something on it rises by at least this, as height over the eye per share of the way */
    sight_parts unsure; /* where something may still hide the target */
    /* If the target is infinite, so that all are visited: whether the steepest rise on the way is known but for what is
     * unsure. It is then rise, off by less than error. */
    bool known;
    double rise, error;
} sweep_way;

/* Called once for every sample of the field with a height, from several threads; but not for the one right under the
 * eye, those beyond the greatest distance, those of spans, and those above which something must hide a target. */
typedef void sweep_visit(void *context, size_t i, size_t j, const sweep_way *way);

/* Samples near one another about which the sweep leaves nothing open: those of the bits `which`, the last of which is
 * number count - 1. Sample k is (i + k, j), or (i, j + k) if they go down a column, and its height is z[k]. Without
 * rise targets are seen; else the steepest rise on the way is rise[k], off by less than error[k]. */
typedef struct sweep_span {
    size_t i, j, count;
    uint64_t which;
    bool down;
    const float *z;
    const double *rise, *error;
} sweep_span;
enum { SWEEP_SPAN_MOST = 64 };

/* Called in place of sweep_visit. The bits of samples that are to be visited after all. */
typedef uint64_t sweep_visit_span(void *context, const sweep_span *span);

/* The sweep comes in parts, any of which may be done alone. */
enum { SWEEP_PARTS = 64 };

/* The two directions that a part goes between, in field coordinates; both are in it, or the part beside has them. */
void cw_sweep_directions(unsigned part, double directions[2][2]);

/* Samples farther away than most cells, on the longer axis, are left out. target may be infinite: then all are
 * visited. False if memory is short. */
bool cw_sweep_part(const sight *s, unsigned part, double most, double target, sweep_visit *visit,
                   sweep_visit_span *visit_span, void *context);

#endif
