/* SPDX-License-Identifier: Apache-2.0 */
#include "run.h"

#include "clock.h"
#include "field.h"
#include "fpenv.h"
#include "kernels.h"
#include "process.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

/* ---- checks ------------------------------------------------------------------------------------------------------ */

cw_status cw_check_reserved(const uint64_t *reserved, size_t count, uint32_t zero, const char *what) {
    uint64_t any = zero;
    for (size_t k = 0; k < count; k++) any |= reserved[k];
    if (any == 0) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "%s: a reserved member is not 0; library %s has no use for it", what, CW_VERSION);
}

cw_status cw_check_allocator(const cw_allocator *a) {
    if (a == NULL) return CW_OK;
    if (a->allocate == NULL || a->release == NULL)
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", a->allocate ? "release" : "allocate");
    return cw_check_reserved(a->reserved, 4, 0, "cw_allocator");
}

cw_status cw_check_rectangle(const cw_field *f, const cw_rectangle *at) {
    if (at->i <= f->nx && at->nx <= f->nx - at->i && at->j <= f->ny && at->ny <= f->ny - at->j) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "rectangle: %zu x %zu samples from (%zu, %zu) on; the field has %zu x %zu",
                   at->nx, at->ny, at->i, at->j, f->nx, f->ny);
}

void cw_fill(void *caller, size_t size, const void *all, size_t all_size) {
    memset(caller, 0, size);
    memcpy(caller, all, size < all_size ? size : all_size);
}

cw_status cw_run_begin(const cw_run *run, cw_run *how) {
    *how = run ? *run : (cw_run){0};
    if ((uint32_t)how->expert.leaf >= CW_LEAF_COUNT)
        return cw_fail(CW_ERROR_ARGUMENT, "expert: leaf %u is not a leaf test", (uint32_t)how->expert.leaf);
    if ((uint32_t)how->expert.isa >= CW_ISA_COUNT)
        return cw_fail(CW_ERROR_ARGUMENT, "expert: isa %d is no instruction set", how->expert.isa);
    return cw_check_reserved(how->reserved, 6, 0, "cw_run");
}

/* The instruction set that run keeps within. */
static cw_isa isa_of(const cw_run *run) { return cw_isa_common(cw_isa_best(), run ? run->expert.isa : CW_ISA_ANY); }

cw_status cw_run_settle(cw_run *how) {
    cw_expert *e = &how->expert;
    e->isa = isa_of(how);
    if (e->kernel == NULL) {
        e->kernel = cw_kernel_default(e->isa);
    } else {
        if (!cw_kernel_exists(e->kernel)) return cw_fail(CW_ERROR_KERNEL, "kernel: there is no kernel of that name");
        if (!cw_isa_includes(e->isa, e->kernel->isa))
            return cw_fail(CW_ERROR_KERNEL,
                           "kernel: %s needs %s; this machine, or the limit on instruction sets, has %s",
                           e->kernel->name, cw_isa_name(e->kernel->isa), cw_isa_name(e->isa));
    }
    if (e->leaf == CW_LEAF_DEFAULT) e->leaf = cw_kernel_default_leaf(e->kernel);
    if (e->kernel->code->trace[e->leaf] == NULL)
        return cw_fail(CW_ERROR_KERNEL, "leaf: %s does not have the leaf test %s", e->kernel->name,
                       cw_leaf_name(e->leaf));
    return CW_OK;
}

const cw_kernel *cw_run_kernel(const cw_field *field, const cw_run *run) {
    (void)field;
    return run && run->expert.kernel ? run->expert.kernel : cw_kernel_default(isa_of(run));
}

cw_status cw_run_built(const cw_field *field, const cw_run *how) {
    if (how->expert.kernel->build && field->guest.structure == NULL)
        return cw_fail(CW_ERROR_NOT_BUILT, "kernel: %s needs cw_field_build on this field first",
                       how->expert.kernel->name);
    return CW_OK;
}

cw_status cw_run_check(const cw_field *field, const cw_run *run) {
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status == CW_OK) status = cw_run_settle(&how);
    return status == CW_OK && field ? cw_run_built(field, &how) : status;
}

/* ---- work under a watch ------------------------------------------------------------------------------------------ */

/* Some rays take 10 000 times as long as others, and a watch is called between pieces only. So pieces of rays begin
 * small, and grow or shrink with the time that the last one took. A piece that has grown on fast rays and then comes to
 * slow ones still runs to its end. Rejected: small pieces always, since kernels work best on many rays. */
enum { FIRST_PIECE = 64 };
static const double short_piece = 0.005, long_piece = 0.05; /* seconds */

typedef struct watched {
    const cw_run *how;
    cw_work_fn *work;
    void *context;
    size_t n, most;
    bool even;           /* all pieces are of most items */
    atomic_size_t piece; /* items, 1 to most */
    atomic_bool stopped;
    pthread_mutex_t lock; /* of done, and of the watch */
    size_t done;
} watched;

static void report(watched *w, size_t count) {
    const int cancel = cancel_disable();
    pthread_mutex_lock(&w->lock);
    w->done += count;
    if (!atomic_load(&w->stopped) && !w->how->watch(w->how->watch_context, (double)w->done / (double)w->n))
        atomic_store(&w->stopped, true);
    pthread_mutex_unlock(&w->lock);
    cancel_restore(cancel);
}

/* One thread gets all items in one call. */
static void work_in_pieces(void *context, size_t begin, size_t end) {
    watched *w = context;
    while (begin < end && !atomic_load(&w->stopped)) {
        const size_t piece = atomic_load(&w->piece), count = end - begin < piece ? end - begin : piece;
        const double start = w->even ? 0 : clock_seconds();
        w->work(w->context, begin, begin + count);
        const double seconds = w->even ? 0 : clock_seconds() - start;
        size_t seen = piece; /* if another thread has changed it since, its word counts */
        if (seconds > long_piece)
            atomic_store(&w->piece, piece > 8 ? piece / 8 : 1);
        else if (count == piece && seconds < short_piece)
            atomic_compare_exchange_strong(&w->piece, &seen, 2 * piece < w->most ? 2 * piece : w->most);
        report(w, count);
        begin += count;
    }
}

cw_status cw_run_work(const cw_run *how, size_t n, size_t least, size_t most, cw_work_fn *work, void *context) {
    if (how->watch == NULL) {
        cw_pool_share(how->pool, n, least, most, work, context);
        return CW_OK;
    }
    FPENV_HERE;
    watched w = {
        .how = how, .work = work, .context = context, .n = n, .most = most > 0 ? most : 1, .even = least >= most};
    atomic_init(&w.piece, w.even || w.most < FIRST_PIECE ? w.most : FIRST_PIECE);
    if (pthread_mutex_init(&w.lock, NULL) != 0) return cw_fail_plainly(CW_ERROR_MEMORY);
    cw_pool_share(how->pool, n, least, most, work_in_pieces, &w);
    pthread_mutex_destroy(&w.lock);
    return atomic_load(&w.stopped) ? cw_fail_plainly(CW_ERROR_CANCELLED) : CW_OK;
}

static void work_on_batch(void *context, size_t begin, size_t end) {
    FPENV_HERE;
    ((cw_batch *)context)->work(context, begin, end);
}

cw_status cw_run_batch(const cw_batch *batch, const cw_run *run, size_t n) {
    enum { GRAIN = 1024 };
    cw_batch b = *batch;
    if (b.field == NULL) return cw_fail(CW_ERROR_ARGUMENT, "field: NULL");
    if (n > 0 && (b.in == NULL || b.out == NULL))
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL for %zu %s", b.in ? b.out_name : b.in_name, n, b.items);
    cw_run how;
    cw_status status = cw_run_begin(run, &how);
    if (status == CW_OK) status = cw_run_settle(&how);
    if (status != CW_OK) return status;
    b.kernel = how.expert.kernel;
    const door_pass in = door_enter(&b.field->door);
    if (in.entry == NULL) return cw_fail_plainly(CW_ERROR_BUSY);
    status = cw_run_work(&how, n, GRAIN, GRAIN, work_on_batch, &b);
    door_leave(in);
    return status;
}

static bool report_part(void *context, double done) {
    const run_part *part = context;
    return part->whole->watch(part->whole->watch_context, part->begin + (part->end - part->begin) * done);
}

cw_run cw_run_part_of(run_part *part) {
    cw_run how = *part->whole;
    if (how.watch != NULL) {
        how.watch = report_part;
        how.watch_context = part;
    }
    return how;
}
