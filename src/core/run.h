/* SPDX-License-Identifier: Apache-2.0 */
/* How something runs: checked once, then shared over threads under a watch. */
#ifndef CELLWALK_CORE_RUN_H
#define CELLWALK_CORE_RUN_H

#include "cellwalk_expert.h"
#include "error.h"

/* Fails unless all reserved words and zero are 0. what: the struct's name for the message. */
CW_API cw_status cw_check_reserved(const uint64_t *reserved, size_t count, uint32_t zero, const char *what);

/* Fails unless it is NULL or whole. */
cw_status cw_check_allocator(const cw_allocator *allocator);

/* Fails unless the rectangle is a part of the field. */
CW_API cw_status cw_check_rectangle(const cw_field *field, const cw_rectangle *at);

/* Copies *all into a caller's struct of size bytes: members of an older struct only, and zero for members of a newer
 * one. */
void cw_fill(void *caller, size_t size, const void *all, size_t all_size);

/* *how becomes *run, or all zero for NULL. Fails if its leaf test, instruction set or a reserved member is invalid. */
CW_API cw_status cw_run_begin(const cw_run *run, cw_run *how);

/* Sets kernel, leaf test and instruction set to those that run. Fails if there is none such here. A limit on
 * instruction sets that is set later changes nothing. */
CW_API cw_status cw_run_settle(cw_run *how);

/* Fails if the field lacks the structure of the kernel, which has been settled. */
cw_status cw_run_built(const cw_field *field, const cw_run *how);

/* cw_pool_run in pieces of least to most items, the largest first, for work best done in pieces of different sizes. */
void cw_pool_share(cw_pool *pool, size_t n, size_t least, size_t most, cw_work_fn *work, void *context);

/* The same on the pool of how; if there is a watch, in pieces of at most most items also on one thread. If least is
 * less, items may take different times, and pieces are made smaller where they take long.
 * CW_ERROR_CANCELLED if the watch returned false. */
CW_API cw_status cw_run_work(const cw_run *how, size_t n, size_t least, size_t most, cw_work_fn *work, void *context);

/* Plain work on a caller's array of n items, whose results go to another one. */
typedef struct cw_batch {
    const cw_field *field;
    cw_work_fn *work; /* its context is the batch; in the IEEE default environment */
    const char *items;
    const char *in_name;
    const void *in;
    const char *out_name;
    void *out;
    const cw_kernel *kernel; /* set by cw_run_batch */
} cw_batch;

/* Checks it and works behind the field's door. */
cw_status cw_run_batch(const cw_batch *batch, const cw_run *run, size_t n);

/* Part of a longer piece of work under one watch, which is given shares from begin to end. */
typedef struct run_part {
    const cw_run *whole;
    double begin, end;
} run_part;

/* The run of that part, which must stay where it is as long as the run is used. */
CW_API cw_run cw_run_part_of(run_part *part);

#endif
