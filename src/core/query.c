/* SPDX-License-Identifier: Apache-2.0 */
/* Public queries: check, choose the kernel, split over threads, keep the floating-point environment. */

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "run.h"

/* Rays a thread takes at a time: some 100 microseconds of work, so that handing out costs nothing; towards the end fewer, so
 * that the last piece does not keep the others waiting, also where there are 10 000 rays in all. */
enum { LEAST = 256, MOST = 4096 };
/* Fewer rays than this are found before a thread that sleeps has woken up. */
enum { SHARED = 1024 };

typedef struct job {
    const cw_field *field;
    const cw_ray *rays;
    cw_run how;
    cw_hit *hits;      /* of cw_closest */
    uint8_t *occluded; /* of cw_occluded */
} job;

static void run_closest(void *context, size_t begin, size_t end) {
    const job *q = context;
    const fpenv caller = fpenv_enter();
    q->how.expert.kernel->code->closest[q->how.expert.leaf](q->field, q->rays + begin, end - begin, q->hits + begin);
    fpenv_leave(caller);
}

static void run_any(void *context, size_t begin, size_t end) {
    const job *q = context;
    const fpenv caller = fpenv_enter();
    q->how.expert.kernel->code->any[q->how.expert.leaf](q->field, q->rays + begin, end - begin, q->occluded + begin);
    fpenv_leave(caller);
}

/* An update may drop a structure, so its presence is checked behind the door. */
static cw_status query(job *q, const cw_run *run, const void *out, const char *out_name, size_t n, cw_work_fn *work) {
    if (q->field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    if (n > 0 && q->rays == NULL) return cw_fail(CW_ERROR_ARGUMENT, "rays: NULL for %zu rays", n);
    if (n > 0 && out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL for %zu rays", out_name, n);
    cw_status status = cw_run_begin(run, &q->how);
    if (status == CW_OK) status = cw_run_settle(&q->how);
    if (status != CW_OK) return status;
    if (n < SHARED) q->how.pool = NULL;
    const door_pass in = door_enter(&q->field->door);
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    status = cw_run_built(q->field, &q->how);
    if (status == CW_OK) status = cw_run_work(&q->how, n, LEAST, MOST, work, q);
    door_leave(in);
    return status;
}

cw_status cw_closest(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, cw_hit *hits) {
    job q = {.field = field, .rays = rays, .hits = hits};
    return query(&q, run, hits, "hits", n, run_closest);
}

cw_status cw_occluded(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, uint8_t *occluded) {
    job q = {.field = field, .rays = rays, .occluded = occluded};
    return query(&q, run, occluded, "occluded", n, run_any);
}
