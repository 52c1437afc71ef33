/* SPDX-License-Identifier: Apache-2.0 */
/* Aimed rays of which the exact oracle's bounds say, without tracing anything, that they pass: so a miss is a leak. As cheap to
 * make as to trace. */
#ifndef CELLWALK_BENCH_STABILITY_PROVEN_H
#define CELLWALK_BENCH_STABILITY_PROVEN_H

#include "oracle.h"
#include "workload/aimed.h"

typedef struct proven_ray {
    cw_ray ray;
    bool passes; /* a miss is a leak; else nothing is known about misses */
} proven_ray;

/* o has the field's samples. */
proven_ray proven_ray_make(aim kind, const aimed_field *f, oracle *o, random_state *r);

#endif
