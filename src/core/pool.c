/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that sleep between queries. A query hands out pieces by one atomic counter, so that a thread which meets
 * cheap rays simply takes more pieces. */

#include "cellwalk.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

struct cw_pool {
    pthread_mutex_t lock;
    pthread_cond_t start, done;
    unsigned threads; /* the caller included */
    unsigned created; /* helpers running: threads - 1 once the pool is whole */
    unsigned busy;    /* helpers that have not finished the present job */
    unsigned long job;
    bool quit;

    cw_work_fn *work;
    void *context;
    size_t n, grain;
    atomic_size_t next;

    pthread_t helper[];
};

static void take_pieces(cw_pool *p) {
    for (;;) {
        const size_t begin = atomic_fetch_add_explicit(&p->next, p->grain, memory_order_relaxed);
        if (begin >= p->n) return;
        p->work(p->context, begin, p->n - begin < p->grain ? p->n : begin + p->grain);
    }
}

static void *help(void *argument) {
    cw_pool *p = argument;
    unsigned long seen = 0;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (!p->quit && p->job == seen) pthread_cond_wait(&p->start, &p->lock);
        if (p->quit) break;
        seen = p->job;
        pthread_mutex_unlock(&p->lock);
        take_pieces(p);
        pthread_mutex_lock(&p->lock);
        if (--p->busy == 0) pthread_cond_signal(&p->done);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

static unsigned cpus(void) {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) != 0) return 1;
    return (unsigned)CPU_COUNT(&set);
}

cw_status cw_pool_create(unsigned threads, cw_pool **pool) {
    if (pool == NULL) return CW_ERROR_ARGUMENT;
    *pool = NULL;
    if (threads == 0) threads = cpus();
    cw_pool *p = calloc(1, sizeof *p + (threads - 1) * sizeof p->helper[0]);
    if (p == NULL) return CW_ERROR_MEMORY;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->start, NULL);
    pthread_cond_init(&p->done, NULL);
    p->threads = threads;
    while (p->created < threads - 1) {
        if (pthread_create(&p->helper[p->created], NULL, help, p) != 0) {
            cw_pool_destroy(p);
            return CW_ERROR_THREAD;
        }
        p->created++;
    }
    *pool = p;
    return CW_OK;
}

void cw_pool_destroy(cw_pool *p) {
    if (p == NULL) return;
    pthread_mutex_lock(&p->lock);
    p->quit = true;
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
    for (unsigned k = 0; k < p->created; k++) pthread_join(p->helper[k], NULL);
    pthread_cond_destroy(&p->done);
    pthread_cond_destroy(&p->start);
    pthread_mutex_destroy(&p->lock);
    free(p);
}

unsigned cw_pool_threads(const cw_pool *pool) { return pool->threads; }

void cw_pool_run(cw_pool *p, size_t n, size_t grain, cw_work_fn *work, void *context) {
    if (p == NULL || p->threads == 1 || n <= grain) {
        if (n > 0) work(context, 0, n);
        return;
    }
    pthread_mutex_lock(&p->lock);
    p->work = work;
    p->context = context;
    p->n = n;
    p->grain = grain;
    atomic_store_explicit(&p->next, 0, memory_order_relaxed);
    p->busy = p->threads - 1;
    p->job++;
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
    take_pieces(p);
    pthread_mutex_lock(&p->lock);
    while (p->busy > 0) pthread_cond_wait(&p->done, &p->lock);
    pthread_mutex_unlock(&p->lock);
}
