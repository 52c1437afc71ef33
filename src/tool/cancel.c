/* SPDX-License-Identifier: Apache-2.0 */
#include "cancel.h"

#include "gdal_host.h"
#include "output.h"
#include "progress.h"

#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static atomic_bool cancelled;
static atomic_int caught;
_Static_assert(ATOMIC_BOOL_LOCK_FREE == 2 && ATOMIC_INT_LOCK_FREE == 2, "a signal handler may not take a lock");

const atomic_bool *cancel_flag(void) { return &cancelled; }

static void die(int number) {
    io_output_discard_all();
    signal(number, SIG_DFL);
    raise(number);
}

/* Time for the program to stop in an orderly way. With the steps that follow it ends within 0.2 s. */
static const struct itimerspec patience = {.it_value = {.tv_nsec = 150000000}};
static timer_t timer;
static bool timer_runs;

static void on_signal(int number) {
    const int error = errno;
    atomic_store(&caught, number);
    /* Without a timer there is no waiting. */
    if (atomic_exchange(&cancelled, true) || !timer_runs || timer_settime(timer, 0, &patience, NULL) != 0) die(number);
    errno = error;
}

static void on_timer(int number) {
    static const char text[] = "cellwalk: interrupted\n";
    (void)number;
    io_output_discard_all();
    const ssize_t told = write(gdal_host_messages(), text, sizeof text - 1);
    (void)told; /* no other place for a message is left */
    die(atomic_load(&caught));
}

void cancel_install(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART | SA_NODEFER; /* a raise in the handler takes effect at once */
    action.sa_handler = on_timer;
    struct sigevent event = {.sigev_notify = SIGEV_SIGNAL, .sigev_signo = SIGRTMIN};
    timer_runs = sigaction(SIGRTMIN, &action, NULL) == 0 && timer_create(CLOCK_MONOTONIC, &event, &timer) == 0;
    action.sa_handler = on_signal;
    const int asked[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t k = 0; k < sizeof asked / sizeof asked[0]; k++) {
        struct sigaction old;
        /* nohup and background jobs of simple shells start programs with these ignored: so they stay. */
        if (sigaction(asked[k], NULL, &old) == 0 && old.sa_handler != SIG_IGN) sigaction(asked[k], &action, NULL);
    }
    /* Writing fails with EFBIG or EPIPE instead. */
    signal(SIGXFSZ, SIG_IGN);
    signal(SIGPIPE, SIG_IGN);
}

bool cancel_tell(void *unused, const char *step, double share) {
    (void)unused;
    if (atomic_load(&cancelled)) return false;
    if (step) progress_show(step, share);
    return true;
}

void cancel_finish(void) {
    const int number = atomic_load(&caught);
    if (number != 0) die(number);
}
