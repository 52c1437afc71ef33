/* SPDX-License-Identifier: Apache-2.0 */
#include "work.h"

#include "cellwalk_expert.h"
#include "clock.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Seconds between two looks for signals. */
static const double look_after = 0.05;

/* Threads cost too much to start for each call. So the pools used last stay, and others go once nothing runs on them. A
 * child that was forked makes its own. Guarded by the GIL. */
enum { KEPT_MOST = 2 };

struct kept_pool {
    unsigned threads, users;
    pid_t process;
    cw_pool *pool;
    struct kept_pool *next;
};

static struct kept_pool *pools; /* the one used last first */

static void drop_pools(void) {
    const pid_t process = getpid();
    unsigned kept = 0;
    for (struct kept_pool **at = &pools; *at != NULL;) {
        struct kept_pool *p = *at;
        kept += p->process == process;
        if (p->users > 0 || (p->process == process && kept <= KEPT_MOST)) {
            at = &p->next;
        } else {
            *at = p->next;
            cw_pool_destroy(p->pool);
            free(p);
        }
    }
}

static cw_status take_pool(work *w, unsigned threads) {
    const pid_t process = getpid();
    struct kept_pool **at = &pools;
    if (threads == 1) return CW_OK;
    while (*at != NULL && ((*at)->threads != threads || (*at)->process != process)) at = &(*at)->next;
    struct kept_pool *p = *at;
    if (p != NULL) {
        *at = p->next;
    } else {
        p = malloc(sizeof *p);
        if (p == NULL) return CW_ERROR_MEMORY;
        *p = (struct kept_pool){.threads = threads, .process = process};
        const cw_status status = cw_pool_create(threads, &p->pool);
        if (status != CW_OK) {
            free(p);
            return status;
        }
    }
    p->next = pools;
    p->users++;
    pools = w->kept = p;
    w->run.pool = p->pool;
    return CW_OK;
}

static void leave_pool(work *w) {
    if (w->kept == NULL) return;
    w->kept->users--;
    w->kept = NULL;
    drop_pools();
}

/* The exception for a status, with the library's message of the last failure on this thread. */
static void raise_status(cw_status status, const char *call) {
    PyObject *kind = status == CW_ERROR_MEMORY ? PyExc_MemoryError
                     : status == CW_ERROR_BUSY ? PyExc_RuntimeError
                                               : PyExc_ValueError;
    const char *detail = cw_last_error();
    PyErr_Format(kind, "%s: %s", call, detail[0] ? detail : cw_status_message(status));
}

bool work_begin(work *w, unsigned threads, const char *kernel, PyObject *progress) {
    memset(w, 0, sizeof *w);
    const cw_status status = take_pool(w, threads);
    if (status != CW_OK) {
        raise_status(status, "threads");
        return false;
    }
    if (kernel != NULL) {
        w->run.expert.kernel = cw_kernel_find(kernel);
        if (!cw_kernel_exists(w->run.expert.kernel)) {
            PyErr_Format(PyExc_ValueError, "kernel: '%s' is none of cellwalk.kernels()", kernel);
            leave_pool(w);
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

static bool watch(work *w, double share) {
    if (atomic_load_explicit(&w->stopped, memory_order_relaxed)) return false;
    if (!pthread_equal(pthread_self(), w->caller)) return true;
    const double now = clock_seconds();
    if (now < w->next) return true;
    PyEval_RestoreThread(w->state);
    bool good = PyErr_CheckSignals() == 0;
    if (good && w->progress != NULL) {
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
    return watch(w, w->begin + w->share * done);
}

bool work_part(work *w, double begin, double share) {
    w->begin = begin;
    w->share = share;
    return work_watch(w, 0);
}

bool work_end(work *w, cw_status status, const char *call) {
    PyEval_RestoreThread(w->state);
    leave_pool(w);
    if (atomic_load(&w->stopped)) return false;
    if (status != CW_OK) {
        raise_status(status, call);
        return false;
    }
    if (w->progress == NULL) return true;
    PyObject *answer = PyObject_CallFunction(w->progress, "d", 1.0);
    Py_XDECREF(answer);
    return answer != NULL;
}
