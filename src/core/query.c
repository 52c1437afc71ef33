/* SPDX-License-Identifier: Apache-2.0 */
/* Public queries: check, choose the kernel, split over threads, keep the floating-point environment. Rays in user space
 * are moved to field space in blocks that lie on the stack and in the first cache. */

#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "run.h"

/* Rays a thread takes at a time: some 100 microseconds of work, so that handing out costs nothing; towards the end
 * fewer, so that the last piece does not keep the others waiting, also where there are 10 000 rays in all. */
enum { LEAST = 256, MOST = 4096 };
/* Fewer rays than this are found before a thread that sleeps has woken up. */
enum { SHARED = 1024 };
/* As many as keep the kernels' batches full, and few. */
enum { BLOCK = 512 };

/* So many rays are best found one after the other. In a field of more than FEW_LARGE samples, beyond the caches, one
 * fewer: lanes wait for memory together. */
enum { FEW_ALONE = 5, FEW_LARGE = 1 << 22 };

/* Does for n <= CW_FEW_RAYS rays what a cw_trace_fn does. */
static inline void trace_few(const cw_kernel *kernel, const cw_field *field, const cw_ray *rays, size_t n, cw_hit *hits,
                             uint8_t *occluded) {
    if (n > 1) {
        cw_short_fn *const if_short = kernel->if_short[n > CW_SHORT_LANES];
        if (if_short && if_short(field, rays, n, hits, occluded)) return;
    }
    const size_t alone = FEW_ALONE - (field->nx * field->ny > FEW_LARGE);
    cw_trace_fn *const trace = n <= alone && kernel->one ? kernel->one : kernel->few->trace[CW_LEAF_WATERTIGHT];
    trace(field, rays, n, hits, occluded);
}

typedef struct query_job {
    const cw_field *field;
    const cw_ray *rays;
    const cw_user_ray *user_rays; /* instead of rays */
    cw_run how;
    bool few;          /* trace_few instead of a kernel */
    cw_hit *hits;      /* of cw_closest; else NULL */
    uint8_t *occluded; /* of cw_occluded */
} query_job;

static void trace_piece(const query_job *q, const cw_ray *rays, size_t begin, size_t n) {
    cw_hit *const hits = q->hits ? q->hits + begin : NULL;
    uint8_t *const occluded = q->hits ? NULL : q->occluded + begin;
    if (q->few) {
        trace_few(q->how.expert.kernel, q->field, rays, n, hits, occluded);
        return;
    }
    q->how.expert.kernel->code->trace[q->how.expert.leaf](q->field, rays, n, hits, occluded);
}

static void work(void *context, size_t begin, size_t end) {
    const query_job *q = context;
    FPENV_HERE;
    trace_piece(q, q->rays + begin, begin, end - begin);
}

static inline void work_in_blocks(const query_job *q, size_t begin, size_t end, cw_ray *block, size_t most) {
    FPENV_HERE;
    for (size_t count; begin < end; begin += count) {
        count = end - begin < most ? end - begin : most;
        q->how.expert.kernel->to_field(q->field->to_field, q->user_rays + begin, count, block);
        trace_piece(q, block, begin, count);
    }
}

static void work_on_few(void *context, size_t begin, size_t end) {
    cw_ray block[CW_FEW_RAYS];
    work_in_blocks(context, begin, end, block, CW_FEW_RAYS);
}

static void work_on_many(void *context, size_t begin, size_t end) {
    cw_ray block[BLOCK];
    work_in_blocks(context, begin, end, block, BLOCK);
}

/* Of any rays; few take a shorter way, which is fast only without this one in it. An update may drop a structure, so
 * its presence is checked behind the door. */
static __attribute__((noinline)) cw_status query_all(const cw_field *field, const cw_run *run, const cw_ray *rays,
                                                     const cw_user_ray *user_rays, size_t n, cw_hit *hits,
                                                     uint8_t *occluded, const char *out_name) {
    if (field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    if (n > 0 && rays == NULL && user_rays == NULL) return cw_fail(CW_ERROR_ARGUMENT, "rays: NULL for %zu rays", n);
    if (n > 0 && hits == NULL && occluded == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL for %zu rays", out_name, n);
    query_job q; /* no initialiser: it would clear how first */
    q.field = field, q.rays = rays, q.user_rays = user_rays, q.hits = hits, q.occluded = occluded;
    cw_status status = cw_run_begin(run, &q.how);
    const bool forced = q.how.expert.kernel != NULL;
    if (status == CW_OK) status = cw_run_settle(&q.how);
    if (status != CW_OK) return status;
    q.few = n <= CW_FEW_RAYS && !forced;
    if (n < SHARED) q.how.pool = NULL;
    const door_pass in = door_enter(&q.field->door);
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    cw_work_fn *const how = q.user_rays == NULL ? work : n <= CW_FEW_RAYS ? work_on_few : work_on_many;
    status = cw_run_built(q.field, &q.how);
    if (status == CW_OK) status = cw_run_work(&q.how, n, q.user_rays ? BLOCK : LEAST, MOST, how, &q);
    door_leave(in);
    return status;
}

/* The default kernel; looking for it takes some of the time of one ray. */
static inline const cw_kernel *default_kernel(void) {
    static const cw_kernel *_Atomic found[CW_ISA_COUNT]; /* that of CW_ISA_ANY stays NULL */
    const cw_kernel *kernel =
        atomic_load_explicit(&found[atomic_load_explicit(&cw_isa_in_use, memory_order_relaxed)], memory_order_relaxed);
    if (kernel == NULL) {
        const cw_isa isa = cw_isa_best();
        atomic_store_explicit(&found[isa], kernel = cw_kernel_default(isa), memory_order_relaxed);
    }
    return kernel;
}

static inline cw_status query(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, cw_hit *hits,
                              uint8_t *occluded, const char *out_name) {
    if (run != NULL || n - 1 >= CW_FEW_RAYS || field == NULL || rays == NULL || (hits == NULL && occluded == NULL))
        return query_all(field, run, rays, NULL, n, hits, occluded, out_name);
    const door_pass in = door_enter(&field->door); /* all that few rays need */
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    const fpenv caller = fpenv_enter();
    trace_few(default_kernel(), field, rays, n, hits, occluded);
    fpenv_leave(caller);
    door_leave(in);
    return CW_OK;
}

cw_status cw_closest(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, cw_hit *hits) {
    return query(field, run, rays, n, hits, NULL, "hits");
}
cw_status cw_occluded(const cw_field *field, const cw_run *run, const cw_ray *rays, size_t n, uint8_t *occluded) {
    return query(field, run, rays, n, NULL, occluded, "occluded");
}
cw_status cw_closest_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n, cw_hit *hits) {
    return query_all(field, run, NULL, rays, n, hits, NULL, "hits");
}
cw_status cw_occluded_user(const cw_field *field, const cw_run *run, const cw_user_ray *rays, size_t n,
                           uint8_t *occluded) {
    return query_all(field, run, NULL, rays, n, NULL, occluded, "occluded");
}

/* ---- rays alone -------------------------------------------------------------------------------------------------- */

static void move_rays(void *context, size_t begin, size_t end) {
    const cw_batch *b = context;
    b->kernel->to_field(b->field->to_field, (const cw_user_ray *)b->in + begin, end - begin, (cw_ray *)b->out + begin);
}

cw_status cw_rays_to_field(const cw_field *field, const cw_run *run, const cw_user_ray *in, size_t n, cw_ray *out) {
    return cw_run_batch(&(cw_batch){field, move_rays, "rays", "in", in, "out", out, NULL}, run, n);
}
