/* SPDX-License-Identifier: Apache-2.0 */
/* Public queries: check, choose the kernel, split over threads, keep the floating-point environment. */

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "watch.h"

#include <float.h>

/* Rays a thread takes at a time: some 100 microseconds of work, so that handing out costs nothing and the last piece
 * does not keep the others waiting. */
enum { GRAIN = 4096 };

typedef struct job {
    const cw_field *field;
    const cw_ray *rays;
    cw_query query;
    cw_closest_fn *closest; /* this writes hits */
    cw_any_fn *any;         /* or this occluded */
    cw_hit *hits;
    uint8_t *occluded;
} job;

static void run(void *context, size_t begin, size_t end) {
    const job *q = context;
    const fpenv caller = fpenv_enter();
    if (q->closest)
        q->closest(q->field, q->rays + begin, end - begin, &q->query, q->hits + begin);
    else
        q->any(q->field, q->rays + begin, end - begin, &q->query, q->occluded + begin);
    fpenv_leave(caller);
}

/* All of them are allowed errors: finite, not negative. */
static bool is_tolerance(const cw_query *query) {
    return query->tolerance >= 0 && query->tolerance <= FLT_MAX && query->cone >= 0 && query->cone <= FLT_MAX;
}

/* What can be wrong with a query, whichever its kind; on success the leaf test to run. */
static cw_status check(const cw_field *field, const cw_query *query, const void *rays, const void *out, size_t n,
                       const cw_kernel **kernel, cw_leaf *leaf) {
    if (field == NULL || (n > 0 && (rays == NULL || out == NULL))) return CW_ERROR_ARGUMENT;
    *kernel = cw_query_kernel(field, query);
    *leaf = query ? query->leaf : CW_LEAF_DEFAULT;
    if (!cw_kernel_exists(*kernel)) return CW_ERROR_KERNEL;
    if ((unsigned)*leaf >= CW_LEAF_COUNT) return CW_ERROR_OPTION;
    if (query && (unsigned)query->coherence > CW_COHERENCE_HIGH) return CW_ERROR_OPTION;
    if (query && (!is_tolerance(query) || !cw_all_zero(query->reserved))) return CW_ERROR_OPTION;
    if (*leaf == CW_LEAF_DEFAULT) *leaf = (*kernel)->default_leaf;
    /* What was chosen here is available, even if the limit has just become lower. */
    if (query && query->kernel && (*kernel)->isa > cw_isa_best()) return CW_ERROR_UNAVAILABLE;
    if ((*kernel)->closest[*leaf] == NULL) return CW_ERROR_UNSUPPORTED;
    if (((*kernel)->needs & CW_NEEDS_GRID3D) && field->grid3d == NULL) return CW_ERROR_NOT_BUILT;
    if (((*kernel)->needs & CW_NEEDS_PYRAMID) && field->pyramid == NULL) return CW_ERROR_NOT_BUILT;
    return CW_OK;
}

/* The query for the kernel, NULL being the default. A tolerance is less by more than what the kernels' sums and products
 * of it round. */
static cw_query settled(const cw_query *query) {
    cw_query q = query ? *query : cw_query_default();
    q.tolerance *= 1 - 0x1p-20f;
    q.cone *= 1 - 0x1p-20f;
    return q;
}

/* True if the query asks for less than exact hits and its kernel makes use of that. */
static bool is_tolerant(const cw_query *query, const cw_kernel *kernel, cw_leaf leaf) {
    return query && (query->tolerance > 0 || query->cone > 0) && kernel->closest_near && leaf == CW_LEAF_WATERTIGHT;
}

cw_query cw_query_default(void) { return (cw_query){.leaf = CW_LEAF_DEFAULT}; }

cw_status cw_closest(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, cw_hit *hits) {
    const cw_kernel *kernel;
    cw_leaf leaf;
    const cw_status status = check(field, query, rays, hits, n, &kernel, &leaf);
    if (status != CW_OK) return status;
    const bool near = is_tolerant(query, kernel, leaf);
    job q = {.field = field,
             .rays = rays,
             .query = settled(query),
             .closest = near ? kernel->closest_near : kernel->closest[leaf],
             .hits = hits};
    return cw_watch_run(&q.query, n, GRAIN, run, &q);
}

cw_status cw_any(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, uint8_t *occluded) {
    const cw_kernel *kernel;
    cw_leaf leaf;
    const cw_status status = check(field, query, rays, occluded, n, &kernel, &leaf);
    if (status != CW_OK) return status;
    const bool near = is_tolerant(query, kernel, leaf);
    job q = {.field = field,
             .rays = rays,
             .query = settled(query),
             .any = near ? kernel->any_near : kernel->any[leaf],
             .occluded = occluded};
    return cw_watch_run(&q.query, n, GRAIN, run, &q);
}
