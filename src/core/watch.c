/* SPDX-License-Identifier: Apache-2.0 */
#include "watch.h"

#include "pool.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct watched {
    const cw_query *query;
    cw_work_fn *work;
    void *context;
    size_t n, most;
    atomic_bool stopped;
    pthread_mutex_t lock; /* of done, and of the watch */
    size_t done;
} watched;

static void tell(watched *w, size_t count) {
    pthread_mutex_lock(&w->lock);
    w->done += count;
    if (!atomic_load(&w->stopped) && !w->query->watch(w->query->watch_context, (double)w->done / (double)w->n))
        atomic_store(&w->stopped, true);
    pthread_mutex_unlock(&w->lock);
}

/* A thread alone gets all at once. */
static void work_in_pieces(void *context, size_t begin, size_t end) {
    watched *w = context;
    while (begin < end && !atomic_load(&w->stopped)) {
        const size_t count = end - begin < w->most ? end - begin : w->most;
        w->work(w->context, begin, begin + count);
        tell(w, count);
        begin += count;
    }
}

cw_status cw_watch_run(const cw_query *query, size_t n, size_t least, size_t most, cw_work_fn *work, void *context) {
    if (query->watch == NULL) {
        cw_pool_share(query->pool, n, least, most, work, context);
        return CW_OK;
    }
    watched w = {.query = query, .work = work, .context = context, .n = n, .most = most > 0 ? most : 1};
    if (pthread_mutex_init(&w.lock, NULL) != 0) return CW_ERROR_MEMORY;
    cw_pool_share(query->pool, n, least, most, work_in_pieces, &w);
    pthread_mutex_destroy(&w.lock);
    return atomic_load(&w.stopped) ? CW_ERROR_CANCELLED : CW_OK;
}

static bool tell_part(void *context, double done) {
    const watch_part *part = context;
    return part->whole->watch(part->whole->watch_context, part->begin + (part->end - part->begin) * done);
}

cw_query cw_watch_part_of(watch_part *part) {
    cw_query query = *part->whole;
    if (query.watch != NULL) {
        query.watch = tell_part;
        query.watch_context = part;
    }
    return query;
}
