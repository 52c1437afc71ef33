/* SPDX-License-Identifier: Apache-2.0 */
/* Public queries: check, choose the kernel, split over threads, keep the floating-point environment. */

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "watch.h"

#include <float.h>

/* Rays a thread takes at a time: some 100 microseconds of work, so that handing out costs nothing; towards the end fewer, so
 * that the last piece does not keep the others waiting, also where there are 10 000 rays in all. */
enum { LEAST = 256, MOST = 4096 };
/* Fewer rays than this are found before a thread that sleeps has got up. */
enum { SHARED = 1024 };

typedef struct job {
    const cw_field *field;
    const cw_ray *rays;
    cw_query query;
    const cw_kernel_code *code;
    cw_hit *hits;      /* of a closest-hit query */
    uint8_t *occluded; /* of an any-hit query */
} job;

static void run_closest(void *context, size_t begin, size_t end) {
    const job *q = context;
    const fpenv caller = fpenv_enter();
    q->code->closest[q->query.leaf](q->field, q->rays + begin, end - begin, &q->query, q->hits + begin);
    fpenv_leave(caller);
}

static void run_any(void *context, size_t begin, size_t end) {
    const job *q = context;
    const fpenv caller = fpenv_enter();
    q->code->any[q->query.leaf](q->field, q->rays + begin, end - begin, &q->query, q->occluded + begin);
    fpenv_leave(caller);
}

/* All of them are allowed errors: finite, not negative. */
static bool is_tolerance(const cw_query *query) {
    return query->tolerance >= 0 && query->tolerance <= FLT_MAX && query->cone >= 0 && query->cone <= FLT_MAX;
}

/* Checks a query and settles it: kernel, leaf test and code that run. out is where the answers go. */
static cw_status settle(job *q, const cw_field *field, const cw_query *query, const cw_ray *rays, const void *out,
                        size_t n) {
    if (field == NULL || (n > 0 && (rays == NULL || out == NULL))) return CW_ERROR_ARGUMENT;
    *q = (job){.field = field, .rays = rays, .query = query ? *query : cw_query_default()};
    cw_query *s = &q->query;
    const cw_kernel *given = s->kernel, *kernel = s->kernel = cw_query_kernel(field, s);
    if (!cw_kernel_exists(kernel)) return CW_ERROR_KERNEL;
    if ((unsigned)s->leaf >= CW_LEAF_COUNT || (unsigned)s->coherence > CW_COHERENCE_HIGH) return CW_ERROR_OPTION;
    if (!is_tolerance(s) || !cw_all_zero(s->reserved)) return CW_ERROR_OPTION;
    if (s->leaf == CW_LEAF_DEFAULT) s->leaf = cw_kernel_default_leaf(kernel);
    /* What was chosen here is available, even if the limit has just become lower. */
    if (given && kernel->isa > cw_isa_best()) return CW_ERROR_UNAVAILABLE;
    if (kernel->strict->closest[s->leaf] == NULL) return CW_ERROR_UNSUPPORTED;
    if ((kernel->needs & CW_NEEDS_GRID3D) && field->grid3d == NULL) return CW_ERROR_NOT_BUILT;
    if ((kernel->needs & CW_NEEDS_PYRAMID) && field->pyramid == NULL) return CW_ERROR_NOT_BUILT;
    const bool tolerant = (s->tolerance > 0 || s->cone > 0) && kernel->tolerant && s->leaf == CW_LEAF_WATERTIGHT;
    q->code = tolerant ? kernel->tolerant : kernel->strict;
    /* Less by more than what the kernels' sums and products of it round. */
    s->tolerance *= 1 - 0x1p-20f;
    s->cone *= 1 - 0x1p-20f;
    return CW_OK;
}

static cw_status run(job *q, size_t n, cw_work_fn *work) {
    if (n < SHARED) q->query.pool = NULL;
    const door_pass in = door_enter(&q->field->door);
    if (in.entry == NULL) return CW_ERROR_BUSY;
    const cw_status status = cw_watch_run(&q->query, n, LEAST, MOST, work, q);
    door_leave(in);
    return status;
}

cw_query cw_query_default(void) { return (cw_query){.leaf = CW_LEAF_DEFAULT}; }

cw_status cw_closest(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, cw_hit *hits) {
    job q;
    const cw_status status = settle(&q, field, query, rays, hits, n);
    if (status != CW_OK) return status;
    q.hits = hits;
    return run(&q, n, run_closest);
}

cw_status cw_any(const cw_field *field, const cw_query *query, const cw_ray *rays, size_t n, uint8_t *occluded) {
    job q;
    const cw_status status = settle(&q, field, query, rays, occluded, n);
    if (status != CW_OK) return status;
    q.occluded = occluded;
    return run(&q, n, run_any);
}
