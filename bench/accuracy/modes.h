/* SPDX-License-Identifier: Apache-2.0 */
/* The modes of accuracy whose trade is measured: one row each in the table of tradeoff_modes.c. */
#ifndef CELLWALK_BENCH_ACCURACY_MODES_H
#define CELLWALK_BENCH_ACCURACY_MODES_H

#include "accuracy/judge.h"
#include "peers/contender.h"
#include "peers/embree.h"

/* A new mode is a new row. Whatever it leaves out stays as it is: the strict query on the field's own samples. */
typedef struct tradeoff_mode {
    const char *name; /* "strict"; a contender is called NAME/KERNEL, or NAME/wWIDTH with Embree */
    const char *what; /* one line for a person */
    cw_leaf leaf;
    const char *only;         /* the one kernel that has this mode; NULL: all, but those that others name here */
    const char *family;       /* or only kernels whose names begin so; NULL: all */
    tradeoff_claim tolerance; /* of the query, which is also what it may cost: in units of tradeoff_cell_height */
    tradeoff_claim (*change)(float *z, size_t count); /* changes the samples of the mode's own field, and says by how
                                                       * much at most */
    bool longer;                                      /* only with --long, or if asked for by name */
    bool embree, robust;                              /* Embree instead of a kernel */
    peer_geometry geometry;
} tradeoff_mode;

size_t tradeoff_mode_count(void);
/* NULL from the count on. */
const tradeoff_mode *tradeoff_mode_at(size_t number);

/* How much of the field's height is as long in user space as a cell's side, where a unit of field space is shortest. */
double tradeoff_cell_height(const cw_field *field);

/* A mode on one field, with all that it needs. */
typedef struct tradeoff_stage {
    const tradeoff_mode *mode;
    cw_field *field; /* the given one, or: */
    cw_field *own;   /* made from: */
    float *z;
    tradeoff_claim tolerance, claim;
    peer_embree *peer;
} tradeoff_stage;

/* base has the samples given by ground and must stay until the stage is closed, and so must they. isa is the widest that
 * Embree may use. On failure the stage needs no closing. */
bool tradeoff_stage_open(tradeoff_stage *stage, const tradeoff_mode *mode, cw_field *base, const true_surface *surface,
                         cw_isa isa, io_error *error);
void tradeoff_stage_close(tradeoff_stage *stage);

/* The mode's contender with a kernel, named as above. CW_ERROR_UNAVAILABLE or CW_ERROR_UNSUPPORTED where there is none. */
cw_status tradeoff_stage_kernel(const tradeoff_stage *stage, const cw_kernel *kernel, contender *c);

/* Rounds samples to 2^16 levels from the lowest to the highest; holes stay. The claim is half a step and the rounding of
 * the result to float. */
tradeoff_claim tradeoff_quantise(float *z, size_t count);

#endif
