/* SPDX-License-Identifier: Apache-2.0 */
/* Work that somebody watches: told how far it is, and asked whether it should go on. */
#ifndef CELLWALK_CORE_WATCH_H
#define CELLWALK_CORE_WATCH_H

#include "cellwalk.h"

/* cw_pool_share on the query's pool; in pieces of most items also on one thread if the query has a watch. CW_ERROR_CANCELLED if
 * that said to stop. */
cw_status cw_watch_run(const cw_query *query, size_t n, size_t least, size_t most, cw_work_fn *work, void *context);

/* Part of a longer piece of work under one watch: it is told shares from begin to end. */
typedef struct watch_part {
    const cw_query *whole;
    double begin, end;
} watch_part;

/* The whole's query for that part, which stays where it is as long as the query is used. */
cw_query cw_watch_part_of(watch_part *part);

/* What later versions may mean by it is the default. */
static inline bool cw_all_zero(const uint64_t reserved[4]) {
    return (reserved[0] | reserved[1] | reserved[2] | reserved[3]) == 0;
}

#endif
