/* SPDX-License-Identifier: Apache-2.0 */
/* Threads that sleep between queries. A query hands out pieces by one atomic counter, so that a thread with cheap
 * rays takes more pieces. The caller never waits for a thread that has not begun: on a busy machine, or for a small
 * query, it does all of the work. */

#include "cpus.h"
#include "error.h"
#include "fpenv.h"
#include "process.h"
#include "run.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>

/* The work of one caller. It is in the caller's stack frame, which stays until all pieces are done. */
typedef struct pool_job {
    cw_work_fn *work;
    void *context;
    size_t n, least, most; /* items; of a piece */
    size_t parts;          /* a piece is the rest divided by this */
    atomic_size_t next;    /* item */
} pool_job;

struct cw_pool {
    pthread_mutex_t lock;
    pthread_cond_t start, done;
    unsigned threads;    /* the caller included */
    unsigned created;    /* helpers running: threads - 1 once the pool is whole */
    atomic_uint busy;    /* helpers that are at the present job */
    atomic_ulong number; /* of the job */
    pool_job *present;   /* NULL: there is nothing to join */
    bool engaged;        /* a caller has the helpers */
    unsigned process;    /* that has the helpers; in a child of it the lock stays as another thread left it */
    atomic_bool quit;
    cw_tasks tasks; /* run is NULL if the pool has helper threads */
    pthread_t helper[];
};

/* Polls of a waiting thread before it sleeps, about 20 microseconds in all, which is the time of waking one. Between
 * polls it yields the CPU. */
enum { LOOKS = 50 };

/* Large pieces first, since each has a beginning and an end at which lanes of a kernel are empty; small ones at
 * last, so that all threads end together. */
static size_t piece(const pool_job *j, size_t left) {
    size_t count = left / j->parts / j->least * j->least;
    if (count > j->most) count = j->most;
    if (count < j->least) count = j->least;
    return count < left ? count : left;
}

/* A helper has the floating-point environment of the thread that made it, so each job sets the default one. */
static void take_pieces(pool_job *j) {
    FPENV_HERE;
    size_t begin = atomic_load_explicit(&j->next, memory_order_relaxed);
    while (begin < j->n) {
        const size_t end = begin + piece(j, j->n - begin);
        if (!atomic_compare_exchange_weak_explicit(&j->next, &begin, end, memory_order_relaxed, memory_order_relaxed))
            continue;
        j->work(j->context, begin, end);
        begin = atomic_load_explicit(&j->next, memory_order_relaxed);
    }
}

static void *help(void *argument) {
    cw_pool *p = argument;
    unsigned long seen = 0;
    for (;;) {
        for (int k = 0; k < LOOKS && atomic_load(&p->number) == seen && !atomic_load(&p->quit); k++) sched_yield();
        pthread_mutex_lock(&p->lock);
        while (!p->quit && p->number == seen) pthread_cond_wait(&p->start, &p->lock);
        const bool quit = p->quit;
        pool_job *j = p->present;
        seen = p->number;
        if (j != NULL) p->busy++;
        pthread_mutex_unlock(&p->lock);
        if (quit) return NULL;
        if (j == NULL) continue; /* too late */
        take_pieces(j);
        pthread_mutex_lock(&p->lock);
        if (--p->busy == 0) pthread_cond_signal(&p->done);
        pthread_mutex_unlock(&p->lock);
    }
}

static cw_status check_threads(unsigned threads, unsigned least) {
    if (threads >= least && threads <= CW_THREADS_MAX) return CW_OK;
    return cw_fail(CW_ERROR_ARGUMENT, "threads: %u; it is from %u to %d", threads, least, CW_THREADS_MAX);
}

/* musl gives a thread 128 KiB of stack, most of which a query uses. cellwalk.h promises 1 MiB for the caller's work. */
static bool start(cw_pool *p) {
    enum { STACK_LEAST = 1 << 20 };
    pthread_attr_t how;
    size_t stack = 0;
    if (pthread_attr_init(&how) != 0) return false;
    bool good = pthread_attr_getstacksize(&how, &stack) == 0;
    if (good && stack < STACK_LEAST) good = pthread_attr_setstacksize(&how, STACK_LEAST) == 0;
    good = good && pthread_create(&p->helper[p->created], &how, help, p) == 0;
    pthread_attr_destroy(&how);
    return good;
}

cw_status cw_pool_create(uint32_t threads, cw_pool **pool) {
    if (pool == NULL) return cw_fail(CW_ERROR_ARGUMENT, "pool: NULL");
    *pool = NULL;
    const cw_status status = check_threads(threads, 0);
    if (status != CW_OK) return status;
    if (threads == 0) threads = cpus_usable();
    cw_pool *p = cw_process_follow_forks() ? calloc(1, sizeof *p + (threads - 1) * sizeof p->helper[0]) : NULL;
    if (p == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->start, NULL);
    pthread_cond_init(&p->done, NULL);
    p->threads = threads;
    p->process = cw_process();
    while (p->created < threads - 1) {
        if (!start(p)) {
            const unsigned started = p->created;
            cw_pool_destroy(p);
            return cw_fail(CW_ERROR_MEMORY, "threads: the system refused number %u of %u", started + 1, threads);
        }
        p->created++;
    }
    *pool = p;
    return CW_OK;
}

cw_status cw_pool_create_on(const cw_tasks *tasks, cw_pool **pool) {
    if (pool == NULL) return cw_fail(CW_ERROR_ARGUMENT, "pool: NULL");
    *pool = NULL;
    if (tasks == NULL || tasks->run == NULL) return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", tasks ? "run" : "tasks");
    cw_status status = check_threads(tasks->threads, 1);
    if (status == CW_OK) status = cw_check_reserved(tasks->reserved, 4, tasks->zero, "cw_tasks");
    if (status != CW_OK) return status;
    cw_pool *p = calloc(1, sizeof *p);
    if (p == NULL) return cw_fail_plainly(CW_ERROR_MEMORY);
    p->threads = tasks->threads;
    p->tasks = *tasks;
    *pool = p;
    return CW_OK;
}

void cw_pool_destroy(cw_pool *p) {
    if (p == NULL) return;
    if (p->tasks.run != NULL || p->process != cw_process()) {
        free(p);
        return;
    }
    pthread_mutex_lock(&p->lock);
    p->quit = true;
    pthread_cond_broadcast(&p->start);
    pthread_mutex_unlock(&p->lock);
    const int cancel = cancel_disable();
    for (unsigned k = 0; k < p->created; k++) pthread_join(p->helper[k], NULL);
    cancel_restore(cancel);
    pthread_cond_destroy(&p->done);
    pthread_cond_destroy(&p->start);
    pthread_mutex_destroy(&p->lock);
    free(p);
}

uint32_t cw_pool_threads(const cw_pool *pool) { return pool ? pool->threads : 1; }

/* Gives the job to the helpers; false if they have one. */
static bool engage(cw_pool *p, pool_job *j) {
    pthread_mutex_lock(&p->lock);
    const bool idle = !p->engaged;
    if (idle) {
        p->engaged = true;
        p->present = j;
        p->number++;
        pthread_cond_broadcast(&p->start);
    }
    pthread_mutex_unlock(&p->lock);
    return idle;
}

/* Nothing is left to be taken: who has not begun is too late, and who has is waited for. */
static void disengage(cw_pool *p) {
    pthread_mutex_lock(&p->lock);
    p->present = NULL;
    pthread_mutex_unlock(&p->lock);
    for (int k = 0; k < LOOKS && atomic_load(&p->busy) > 0; k++) sched_yield();
    pthread_mutex_lock(&p->lock);
    while (p->busy > 0) pthread_cond_wait(&p->done, &p->lock);
    p->engaged = false;
    pthread_mutex_unlock(&p->lock);
}

static void take_pieces_as_task(void *argument, uint32_t number) {
    (void)number;
    take_pieces(argument);
}

/* If the helpers are busy, the caller works alone instead of waiting. So no thread is idle, and work that uses the
 * pool on which it runs does not wait for its own end. */
void cw_pool_share(cw_pool *p, size_t n, size_t least, size_t most, cw_work_fn *work, void *context) {
    if (n == 0) return;
    if (least == 0) least = 1;
    const unsigned threads = cw_pool_threads(p);
    const size_t pieces = n / least + (n % least != 0); /* at most */
    pool_job j = {.work = work, .context = context, .n = n, .least = least, .most = most > least ? most : least};
    j.parts = (size_t)2 * threads;
    if (threads == 1 || pieces == 1) {
        work(context, 0, n);
        return;
    }
    const int cancel = cancel_disable();
    if (p->tasks.run != NULL) {
        p->tasks.run(p->tasks.context, take_pieces_as_task, &j, pieces < threads ? (unsigned)pieces : threads);
    } else if (p->process == cw_process() && engage(p, &j)) {
        take_pieces(&j);
        disengage(p);
    } else {
        work(context, 0, n);
    }
    cancel_restore(cancel);
}

void cw_pool_run(cw_pool *pool, size_t n, size_t grain, cw_work_fn *work, void *context) {
    cw_pool_share(pool, n, grain, grain, work, context);
}
