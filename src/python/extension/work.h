/* SPDX-License-Identifier: Apache-2.0 */
/* How a call from Python runs: without the GIL, on a pool, under a watch that looks for Ctrl-C and tells a progress callable. */
#ifndef CELLWALK_PYTHON_WORK_H
#define CELLWALK_PYTHON_WORK_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <cellwalk_expert.h>
#include <pthread.h>
#include <stdatomic.h>

typedef struct work {
    cw_run run; /* pool, kernel and watch are set */
    PyObject *progress;
    PyThreadState *state;
    pthread_t caller;
    double next;         /* when the watch looks again, by the clock */
    double begin, share; /* the part of all work that is being done, for work_watch */
    atomic_bool stopped; /* an exception is set */
} work;

/* make_pool(threads) -> a capsule, whose threads end with it */
PyObject *make_pool(PyObject *self, PyObject *arguments);

/* Makes w ready and releases the GIL. pool is None or a capsule that stays, progress None or a callable, kernel NULL or a name. False
 * with an exception set. */
bool work_begin(work *w, PyObject *pool, const char *kernel, PyObject *progress);

/* Takes the GIL back. False, with an exception that names the call, unless status is CW_OK and nothing stopped the
 * work. */
bool work_end(work *w, cw_status status, const char *call);

/* A cw_watch_fn: context is the work. From threads other than the caller's it only says whether
 * the work is stopped, since Python handles signals on its own threads. */
bool work_watch(void *context, double done);

/* For work in parts: from here on the watch is told shares of [begin, begin + share]. False if the work is stopped. */
bool work_part(work *w, double begin, double share);

#endif
