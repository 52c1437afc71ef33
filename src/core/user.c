/* SPDX-License-Identifier: Apache-2.0 */
/* Queries in user space: rays are moved to field space in blocks that lie on the stack and in the first cache. */

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "run.h"

#include <stdatomic.h>

static void rays_in(const cw_field *field, const cw_user_ray *in, size_t n, cw_ray *out) {
    cw_run_kernel(field, NULL)->to_field(field->to_field, in, n, out);
}

static void move_rays(void *context, size_t begin, size_t end) {
    const cw_batch *b = context;
    rays_in(b->field, (const cw_user_ray *)b->in + begin, end - begin, (cw_ray *)b->out + begin);
}

cw_status cw_rays_to_field(const cw_field *field, const cw_run *run, const cw_user_ray *in, size_t n, cw_ray *out) {
    return cw_run_batch(&(cw_batch){field, move_rays, "rays", "in", in, "out", out}, run, n);
}

/* As many as keep the kernels' batches full. */
enum { BLOCK = 512, MOST = 8 * BLOCK };

typedef struct job {
    const cw_field *field;
    const cw_user_ray *rays;
    cw_run how; /* of a block: without pool and watch */
    cw_hit *hits;
    uint8_t *occluded;
    atomic_int status; /* of a block that failed, as when the limit on instruction sets was lowered meanwhile */
} job;

static void trace_blocks(void *context, size_t begin, size_t end) {
    job *q = context;
    cw_ray block[BLOCK];
    for (size_t count; begin < end; begin += count) {
        count = end - begin < BLOCK ? end - begin : BLOCK;
        const fpenv caller = fpenv_enter();
        rays_in(q->field, q->rays + begin, count, block);
        fpenv_leave(caller);
        cw_status status;
        do
            status = q->hits ? cw_closest(q->field, &q->how, block, count, q->hits + begin)
                             : cw_occluded(q->field, &q->how, block, count, q->occluded + begin);
        while (status == CW_ERROR_BUSY); /* by an update that gives up at once, since this query is in */
        if (status != CW_OK) atomic_store(&q->status, (int)status);
    }
}

static cw_status trace(job *q, const cw_run *run, const void *out, const char *out_name, size_t n) {
    cw_run whole = run ? *run : (cw_run){0};
    if (n < 2 * BLOCK) whole.pool = NULL; /* done before a thread that sleeps has woken up */
    if (n > 0 && q->rays == NULL) return cw_fail(CW_ERROR_ARGUMENT, "rays: NULL for %zu rays", n);
    if (n > 0 && out == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL for %zu rays", out_name, n);
    cw_status status = cw_closest(q->field, &whole, NULL, 0, NULL);
    if (status != CW_OK || n == 0) return status;
    q->how = whole;
    q->how.pool = NULL;
    q->how.watch = NULL;
    const door_pass in = door_enter(&q->field->door); /* for all blocks together: no update comes between */
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    status = cw_run_work(&whole, n, BLOCK, MOST, trace_blocks, q);
    door_leave(in);
    if (status != CW_OK) return status;
    status = (cw_status)atomic_load(&q->status);
    return status == CW_OK ? CW_OK : cw_fail_plainly(status); /* the sentence may be another thread's */
}

cw_status cw_closest_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n, cw_hit *hits) {
    job q = {.field = field, .rays = rays, .hits = hits};
    return trace(&q, run, hits, "hits", n);
}

cw_status cw_occluded_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                           uint8_t *occluded) {
    job q = {.field = field, .rays = rays, .occluded = occluded};
    return trace(&q, run, occluded, "occluded", n);
}
