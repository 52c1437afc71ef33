/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that sleep between queries. A query hands out pieces by one atomic counter, so that a thread which meets
 * cheap rays simply takes more pieces. */

#include "cellwalk.h"

#include "cpus.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <unistd.h>

/* What one caller wants done. It lives in the caller's frame, which is left when all pieces are. */
typedef struct job {
    cw_work_fn *work;
    void *context;
    size_t n, grain, pieces;
    atomic_size_t next; /* piece */
} job;

struct cw_pool {
    pthread_mutex_t lock;
    pthread_cond_t start, done;
    unsigned threads; /* the caller included */
    unsigned created; /* helpers running: threads - 1 once the pool is whole */
    unsigned busy;    /* helpers that have not finished the present job */
    unsigned long number;
    job *present; /* NULL: no caller has the helpers */
    bool quit;
    cw_tasks tasks; /* run is NULL where the pool has helpers of its own */
    pthread_t helper[];
};

static void take_pieces(job *j) {
    for (;;) {
        const size_t piece = atomic_fetch_add_explicit(&j->next, 1, memory_order_relaxed);
        if (piece >= j->pieces) return;
        const size_t begin = piece * j->grain, left = j->n - begin;
        j->work(j->context, begin, begin + (left < j->grain ? left : j->grain));
    }
}

static void *help(void *argument) {
    cw_pool *p = argument;
    unsigned long seen = 0;
    pthread_mutex_lock(&p->lock);
    for (;;) {
        while (!p->quit && p->number == seen) pthread_cond_wait(&p->start, &p->lock);
        if (p->quit) break;
        seen = p->number;
        job *j = p->present;
        pthread_mutex_unlock(&p->lock);
        take_pieces(j);
        pthread_mutex_lock(&p->lock);
        if (--p->busy == 0) pthread_cond_signal(&p->done);
    }
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

cw_status cw_pool_create(unsigned threads, cw_pool **pool) {
    if (pool == NULL) return CW_ERROR_ARGUMENT;
    *pool = NULL;
    if (threads > CW_THREADS_MAX) return CW_ERROR_POOL_SIZE;
    if (threads == 0) threads = cpus_usable();
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

cw_status cw_pool_create_on(const cw_tasks *tasks, cw_pool **pool) {
    if (pool == NULL) return CW_ERROR_ARGUMENT;
    *pool = NULL;
    if (tasks == NULL || tasks->run == NULL) return CW_ERROR_ARGUMENT;
    if (tasks->threads == 0) return CW_ERROR_OPTION;
    if (tasks->threads > CW_THREADS_MAX) return CW_ERROR_POOL_SIZE;
    cw_pool *p = calloc(1, sizeof *p);
    if (p == NULL) return CW_ERROR_MEMORY;
    p->threads = tasks->threads;
    p->tasks = *tasks;
    *pool = p;
    return CW_OK;
}

void cw_pool_destroy(cw_pool *p) {
    if (p == NULL) return;
    if (p->tasks.run != NULL) {
        free(p);
        return;
    }
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

unsigned cw_pool_threads(const cw_pool *pool) { return pool ? pool->threads : 1; }

/* Gives the job to the helpers; false if they have one. */
static bool engage(cw_pool *p, job *j) {
    pthread_mutex_lock(&p->lock);
    const bool idle = p->present == NULL;
    if (idle) {
        p->present = j;
        p->busy = p->threads - 1;
        p->number++;
        pthread_cond_broadcast(&p->start);
    }
    pthread_mutex_unlock(&p->lock);
    return idle;
}

static void take_pieces_as_task(void *argument, unsigned number) {
    (void)number;
    take_pieces(argument);
}

/* Whoever finds the helpers engaged works alone instead of waiting: nothing stands still meanwhile, and work that itself
 * asks the pool it runs on does not wait for its own end. */
void cw_pool_run(cw_pool *p, size_t n, size_t grain, cw_work_fn *work, void *context) {
    if (n == 0) return;
    if (grain == 0) grain = 1;
    job j = {.work = work, .context = context, .n = n, .grain = grain, .pieces = n / grain + (n % grain != 0)};
    if (p != NULL && p->tasks.run != NULL && p->threads > 1 && j.pieces > 1) {
        const unsigned count = j.pieces < p->threads ? (unsigned)j.pieces : p->threads;
        p->tasks.run(p->tasks.context, take_pieces_as_task, &j, count);
        return;
    }
    if (p == NULL || p->threads == 1 || j.pieces == 1 || !engage(p, &j)) {
        work(context, 0, n);
        return;
    }
    take_pieces(&j);
    pthread_mutex_lock(&p->lock);
    while (p->busy > 0) pthread_cond_wait(&p->done, &p->lock);
    p->present = NULL;
    pthread_mutex_unlock(&p->lock);
}
