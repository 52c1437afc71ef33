/* SPDX-License-Identifier: Apache-2.0 */
/* One way to answer ray queries, a kernel's or another program's. The benchmark times contenders against each other. */
#ifndef CELLWALK_BENCH_PEERS_CONTENDER_H
#define CELLWALK_BENCH_PEERS_CONTENDER_H

#include "cellwalk_expert.h"

enum { CONTENDER_NAME = 64 };

typedef struct contender contender;
struct contender {
    char name[CONTENDER_NAME]; /* "packet8/watertight", "embree:w8" */
    unsigned width, threads;
    void (*closest)(const contender *self, const cw_ray *rays, size_t n, cw_hit *hits);
    void (*any)(const contender *self, const cw_ray *rays, size_t n, uint8_t *occluded);
    /* A kernel of the library on a field; or another program's structures. */
    const cw_field *field;
    cw_run query;
    size_t call; /* rays a call of the kernel; 0: all in one */
    const void *peer;
    bool coherent; /* rays are announced as that */
};

/* CW_OK only if the kernel has this leaf test and may run here; its structures are built. */
cw_status contender_from_kernel(contender *c, cw_field *field, const cw_kernel *kernel, cw_leaf leaf);

/* Where answers go: hits for the closest ones, occluded for any. */
typedef struct contender_answers {
    cw_hit *hits;
    uint8_t *occluded;
} contender_answers;

/* All rays once: any: find any hits instead of closest ones. */
typedef struct contender_pass {
    const contender *of;
    const cw_ray *rays;
    size_t n;
    bool any;
    contender_answers out;
} contender_pass;

/* pass is a contender_pass, untyped so that this can be a job. */
void contender_run(void *pass);

#endif
