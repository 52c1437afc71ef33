/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the system lets this process start threads: GDAL waits for ever for one that cannot start. */

#include "parts.h"

#include "linux.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#if CELLWALK_LINUX
#include <sys/syscall.h>
#include <unistd.h>
#endif

typedef struct trial {
    pthread_t thread;
    pthread_mutex_t *end; /* locked until all have started */
    long number;          /* of the system's task */
} trial;

static void *wait_for_end(void *argument) {
    trial *t = argument;
#if CELLWALK_LINUX
    t->number = syscall(SYS_gettid);
#endif
    void *block = malloc(1); /* glibc reserves addresses for each thread that allocates */
    pthread_mutex_lock(t->end);
    pthread_mutex_unlock(t->end);
    free(block);
    return NULL;
}

/* A thread counts against limits for a moment after it was joined, until its task is gone. */
static void wait_until_gone(const trial *t) {
    pthread_join(t->thread, NULL);
#if CELLWALK_LINUX
    while (syscall(SYS_tgkill, getpid(), t->number, 0) == 0) sched_yield();
#endif
}

/* Twice as many are tried: others of this user start threads as well, and stacks must not take the last memory. */
bool threads_can_start(unsigned wanted) {
    const unsigned count = 2 * wanted;
    pthread_mutex_t end = PTHREAD_MUTEX_INITIALIZER;
    trial *trials = calloc(count, sizeof *trials);
    unsigned started = 0;
    pthread_mutex_lock(&end);
    for (; trials != NULL && started < count; started++) {
        trials[started].end = &end;
        if (pthread_create(&trials[started].thread, NULL, wait_for_end, &trials[started]) != 0) break;
    }
    pthread_mutex_unlock(&end);
    for (unsigned k = 0; k < started; k++) wait_until_gone(&trials[k]);
    free(trials);
    return started == count;
}
