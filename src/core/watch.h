/* SPDX-License-Identifier: Apache-2.0 */
/* Work that somebody watches: told how far it is, and asked whether it should go on. */
#ifndef CELLWALK_CORE_WATCH_H
#define CELLWALK_CORE_WATCH_H

#include "cellwalk.h"

/* cw_pool_run on the query's pool, or in pieces if the query has a watch. CW_ERROR_CANCELLED if that said to stop. */
cw_status cw_watch_run(const cw_query *query, size_t n, size_t grain, cw_work_fn *work, void *context);

/* What later versions may mean by it is the default. */
static inline bool cw_all_zero(const uint64_t reserved[4]) {
    return (reserved[0] | reserved[1] | reserved[2] | reserved[3]) == 0;
}

#endif
