/* SPDX-License-Identifier: Apache-2.0 */
/* Differences between Embree 3 and 4 in names and order: how a query is told the kind of its rays. CELLWALK_EMBREE is the version. */
#ifndef BENCH_PEERS_EMBREE_VERSION_H
#define BENCH_PEERS_EMBREE_VERSION_H

#if CELLWALK_EMBREE == 4
#include <embree4/rtcore.h>

typedef struct embree_query {
    struct RTCIntersectArguments closest;
    struct RTCOccludedArguments any;
} embree_query;

/* The last arguments of rtcIntersect and rtcOccluded, in their order. */
#define EMBREE_CLOSEST(query, rays) (rays), &(query)->closest
#define EMBREE_ANY(query, rays)     (rays), &(query)->any

static inline embree_query embree_query_of(bool coherent) {
    embree_query query;
    rtcInitIntersectArguments(&query.closest);
    rtcInitOccludedArguments(&query.any);
    query.closest.flags = query.any.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
    return query;
}
#else
#include <embree3/rtcore.h>

typedef struct RTCIntersectContext embree_query;

#define EMBREE_CLOSEST(query, rays) (query), (rays)
#define EMBREE_ANY(query, rays)     (query), (rays)

static inline embree_query embree_query_of(bool coherent) {
    embree_query query;
    rtcInitIntersectContext(&query);
    query.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return query;
}
#endif

#endif
