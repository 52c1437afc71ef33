/* SPDX-License-Identifier: Apache-2.0 */
/* Sharing work that is best done in pieces of different sizes. */
#ifndef CELLWALK_CORE_POOL_H
#define CELLWALK_CORE_POOL_H

#include "cellwalk_expert.h"

/* cw_pool_run in pieces of least to most items, the largest first. */
void cw_pool_share(cw_pool *pool, size_t n, size_t least, size_t most, cw_work_fn *work, void *context);

#endif
