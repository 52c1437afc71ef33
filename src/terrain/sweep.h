/* SPDX-License-Identifier: Apache-2.0 */
/* How steep the terrain rises before each sample as seen from one place, between bounds: found for all samples together, in a
 * sweep outward, so that a line of sight has to be followed only where the bounds leave the answer open. */
#ifndef CELLWALK_TERRAIN_SWEEP_H
#define CELLWALK_TERRAIN_SWEEP_H

#include "sight.h"

/* What is known of the way to a sample. */
typedef struct sweep_bounds {
    double low; /* something on the way rises by at least this, as height over the eye per share of the way */
    sight_bound high;
    const struct part *part; /* for sweep_close */
    double row, direction;
} sweep_bounds;

/* Fills in high.close for something of that height over the eye on the sample. */
void sweep_close(sweep_bounds *bounds, double height);

/* Called for every sample of the field that is no hole, once, unless something is known to hide what stands target above it;
 * from several threads. */
typedef void sweep_visit(void *context, size_t i, size_t j, double height_over_eye, sweep_bounds *bounds);

/* Called now and then, from the thread that does the part. False ends it. */
typedef bool sweep_tick(void *context);

/* The sweep comes in parts, any of which may be done alone. */
enum { SWEEP_PARTS = 64 };

/* Samples farther away than most cells, on the longer axis, are left out. target may be infinite. False if memory is short. */
bool sweep_part(const sight *s, unsigned part, double most, double target, sweep_visit *visit, sweep_tick *tick,
                void *context);

#endif
