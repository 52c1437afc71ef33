/* SPDX-License-Identifier: Apache-2.0 */
#include "work.h"

#include "clock.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Seconds between two looks for signals. */
static const double look_after = 0.05;

/* Pools live as long as the process: to end one, its threads would have to be joined, which a child that was forked
 * cannot do. A child makes new pools. Guarded by the GIL. */
typedef struct kept_pool {
    unsigned threads;
    pid_t process;
    cw_pool *pool;
    struct kept_pool *next;
} kept_pool;

static kept_pool *pools;

static cw_status find_pool(unsigned threads, cw_pool **pool) {
    const pid_t process = getpid();
    *pool = NULL;
    if (threads == 1) return CW_OK;
    for (const kept_pool *p = pools; p != NULL; p = p->next)
        if (p->threads == threads && p->process == process) {
            *pool = p->pool;
            return CW_OK;
        }
    kept_pool *kept = malloc(sizeof *kept);
    if (kept == NULL) return CW_ERROR_MEMORY;
    *kept = (kept_pool){.threads = threads, .process = process, .next = pools};
    const cw_status status = cw_pool_create(threads, &kept->pool);
    if (status != CW_OK) {
        free(kept);
        return status;
    }
    pools = kept;
    *pool = kept->pool;
    return CW_OK;
}

void work_raise(cw_status status, const char *call) {
    PyObject *kind = status == CW_ERROR_MEMORY ? PyExc_MemoryError
                     : status == CW_ERROR_BUSY ? PyExc_RuntimeError
                                               : PyExc_ValueError;
    const char *detail = cw_last_error();
    PyErr_Format(kind, "%s: %s", call, detail[0] ? detail : cw_status_message(status));
}

bool work_begin(work *w, unsigned threads, const char *kernel, PyObject *progress) {
    memset(w, 0, sizeof *w);
    const cw_status status = find_pool(threads, &w->run.pool);
    if (status != CW_OK) {
        work_raise(status, "threads");
        return false;
    }
    if (kernel != NULL) {
        w->run.kernel = cw_kernel_find(kernel);
        if (!cw_kernel_exists(w->run.kernel)) {
            PyErr_Format(PyExc_ValueError, "kernel: '%s' is none of cellwalk.kernels()", kernel);
            return false;
        }
    }
    w->run.watch = work_watch;
    w->run.watch_context = w;
    w->progress = progress == Py_None ? NULL : progress;
    w->caller = pthread_self();
    w->share = 1;
    w->next = clock_seconds() + look_after;
    w->state = PyEval_SaveThread();
    return true;
}

static bool watch(work *w, bool tell, double share) {
    if (atomic_load_explicit(&w->stopped, memory_order_relaxed)) return false;
    if (!pthread_equal(pthread_self(), w->caller)) return true;
    const double now = clock_seconds();
    if (now < w->next) return true;
    PyEval_RestoreThread(w->state);
    bool good = PyErr_CheckSignals() == 0;
    if (good && tell && w->progress != NULL) {
        PyObject *answer = PyObject_CallFunction(w->progress, "d", share);
        good = answer != NULL;
        Py_XDECREF(answer);
    }
    if (!good) atomic_store(&w->stopped, true);
    w->next = clock_seconds() + look_after;
    w->state = PyEval_SaveThread();
    return good;
}

bool work_watch(void *context, double done) {
    work *w = context;
    return watch(w, true, w->begin + w->share * done);
}

bool work_look(void *context, double done) {
    (void)done;
    return watch(context, false, 0);
}

bool work_part(work *w, double begin, double share) {
    w->begin = begin;
    w->share = share;
    return work_watch(w, 0);
}

bool work_end(work *w, cw_status status, const char *call) {
    PyEval_RestoreThread(w->state);
    if (atomic_load(&w->stopped)) return false;
    if (status != CW_OK) {
        work_raise(status, call);
        return false;
    }
    if (w->progress == NULL) return true;
    PyObject *answer = PyObject_CallFunction(w->progress, "d", 1.0);
    Py_XDECREF(answer);
    return answer != NULL;
}
