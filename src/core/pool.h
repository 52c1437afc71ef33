/* SPDX-License-Identifier: Apache-2.0 */
#ifndef CELLWALK_CORE_POOL_H
#define CELLWALK_CORE_POOL_H

#include "cellwalk.h"

/* One piece of work: items [begin, end). */
typedef void cw_work_fn(void *context, size_t begin, size_t end);

/* Runs work over [0, n) in pieces of grain items on all threads of the pool (NULL: the caller alone); returns when all
 * is done. Allocates nothing. */
void cw_pool_run(cw_pool *pool, size_t n, size_t grain, cw_work_fn *work, void *context);

#endif
