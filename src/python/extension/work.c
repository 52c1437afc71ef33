/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"
#include "extension.h"

#include <string.h>

/* Seconds between two looks for signals. */
static const double look_after = 0.05;

/* The exception for a status, with the library's message of the last failure on this thread. */
static void raise_status(cw_status status, const char *name) {
    PyObject *kind = status == CW_ERROR_MEMORY ? PyExc_MemoryError
                     : status == CW_ERROR_BUSY ? PyExc_RuntimeError
                                               : PyExc_ValueError;
    const char *detail = cw_last_error();
    PyErr_Format(kind, "%s: %s", name, detail[0] ? detail : cw_status_message(status));
}

static const char pool_name[] = "cw_pool";

static void destroy_pool(PyObject *capsule) { cw_pool_destroy(PyCapsule_GetPointer(capsule, pool_name)); }

PyObject *make_pool(PyObject *self, PyObject *arguments) {
    unsigned threads;
    cw_pool *pool = NULL;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "I:make_pool", &threads)) return NULL;
    const cw_status status = cw_pool_create(threads, &pool);
    if (status != CW_OK) raise_status(status, "threads");
    PyObject *capsule = pool ? PyCapsule_New(pool, pool_name, destroy_pool) : NULL;
    if (capsule == NULL) cw_pool_destroy(pool);
    return capsule;
}

bool work_begin(work *w, PyObject *pool, const char *kernel, PyObject *progress) {
    memset(w, 0, sizeof *w);
    if (pool != Py_None && (w->run.pool = PyCapsule_GetPointer(pool, pool_name)) == NULL) return false;
    if (kernel != NULL) {
        w->run.expert.kernel = cw_kernel_find(kernel);
        if (!cw_kernel_exists(w->run.expert.kernel)) {
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

bool work_end(work *w, cw_status status, const char *name) {
    PyEval_RestoreThread(w->state);
    if (atomic_load(&w->stopped)) return false;
    if (status != CW_OK) {
        raise_status(status, name);
        return false;
    }
    if (w->progress == NULL) return true;
    PyObject *answer = PyObject_CallFunction(w->progress, "d", 1.0);
    Py_XDECREF(answer);
    return answer != NULL;
}
