/* SPDX-License-Identifier: Apache-2.0 */
/* What other code of the process does to its threads: fork, and cancellation. */
#ifndef CELLWALK_CORE_PROCESS_H
#define CELLWALK_CORE_PROCESS_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

/* Differs between a process and the children that fork makes of it, which have none of its other threads. Rejected:
 * getpid, a system call for each ray that is asked alone, and numbers that come again. */
extern atomic_uint cw_process_number;
static inline unsigned cw_process(void) { return atomic_load_explicit(&cw_process_number, memory_order_relaxed); }

/* False where the C library does not tell. */
static inline bool process_has_one_thread(void) {
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 32)
    extern char __libc_single_threaded; /* of <sys/single_threaded.h>; amalgamate.py cannot include under a condition */
    return __libc_single_threaded != 0;
#else
    return false;
#endif
}

/* Called before the number is kept anywhere. False when out of memory. */
bool cw_process_follow_forks(void);

/* Between these the thread is not cancelled, and what it holds is not lost with it: locks, a job on its stack, its
 * place among a field's users. Only cancellation points need it: waits, and callbacks, which may contain some. */
static inline int cancel_disable(void) {
    int before;
    pthread_setcancelstate(PTHREAD_CANCEL_DISABLE, &before);
    return before;
}
static inline void cancel_restore(int before) { pthread_setcancelstate(before, &before); }

#endif
