/* SPDX-License-Identifier: Apache-2.0 */
#include "door.h"

#include <sched.h>
#include <time.h>

bool cw_door_make(door *d) {
    if (pthread_mutex_init(&d->lock, NULL) != 0) return false;
    if (pthread_cond_init(&d->changed, NULL) == 0) {
        d->waiting = 0;
        d->came = d->ended = 0;
        atomic_store(&d->owner, cw_process());
        return true;
    }
    pthread_mutex_destroy(&d->lock);
    return false;
}

/* In a child, absent threads may hold the parent's lock or wait for it: destroying that would not return. */
void cw_door_destroy(door *d) {
    if (atomic_load(&d->owner) != cw_process()) return;
    pthread_cond_destroy(&d->changed);
    pthread_mutex_destroy(&d->lock);
}

/* Makes lock and counts anew in a child. False when out of memory. */
static bool adopt(door *d) {
    unsigned owner = atomic_load(&d->owner);
    while (owner != cw_process()) {
        if (owner != 0 && atomic_compare_exchange_strong(&d->owner, &owner, 0)) {
            if (cw_door_make(d)) return true;
            atomic_store(&d->owner, owner);
            return false;
        }
        sched_yield();
        owner = atomic_load(&d->owner);
    }
    return true;
}

static uint64_t shut(door_shut how) { return (uint64_t)cw_process() << 32 | (uint64_t)how; }

static bool shut_if_open(door *d, door_shut then) {
    uint64_t open = DOOR_OPEN;
    return atomic_compare_exchange_strong(&d->state, &open, shut(then));
}

static door_pass wait_outside(door *d) {
    const int cancel = cancel_disable();
    pthread_mutex_lock(&d->lock);
    d->waiting++;
    while (atomic_load(&d->state) == shut(DOOR_WAITS)) pthread_cond_wait(&d->changed, &d->lock);
    const door_pass pass = door_try(d); /* not in if an update came first that does not wait */
    if (--d->waiting == 0) pthread_cond_broadcast(&d->changed);
    pthread_mutex_unlock(&d->lock);
    cancel_restore(cancel);
    return pass;
}

door_pass cw_door_wait(door *d) {
    for (;;) {
        const uint64_t state = atomic_load(&d->state);
        if (state == shut(DOOR_WAITS)) return wait_outside(d);
        if (state != DOOR_OPEN) return (door_pass){NULL, 0, false};
        const door_pass pass = door_try(d);
        if (pass.entry != NULL) return pass;
    }
}

static bool is_quiet(const door *d) {
    const unsigned process = cw_process();
    for (size_t k = 0; k < DOOR_ENTRIES; k++) {
        const door_entry *e = &d->entry[k];
        if (atomic_load(&e->first) == process || door_others(atomic_load(&e->others), process) != 0) return false;
    }
    return true;
}

/* Looks twice, so that a query which runs meanwhile hardly ever sees an update that will not be. */
static bool close_at_once(door *d) {
    if (!is_quiet(d) || !shut_if_open(d, DOOR_REFUSES)) return false;
    if (is_quiet(d)) return true;
    atomic_store(&d->state, DOOR_OPEN);
    return false;
}

/* Rejected: queries that wake the update. Their plain store as they leave would become a fence. */
static void pause_after(unsigned looks) {
    enum { YIELDS = 50 };
    if (looks < YIELDS)
        sched_yield();
    else
        nanosleep(&(struct timespec){.tv_nsec = 50000}, NULL);
}

/* Holds the lock. The next update's turn. */
static void end_turn(door *d) {
    d->ended++;
    pthread_cond_broadcast(&d->changed);
}

static bool close_in_turn(door *d) {
    pthread_mutex_lock(&d->lock);
    const uint64_t mine = d->came++;
    bool in = false, inherited = false;
    for (unsigned looks = 0; !in && !inherited; looks++) {
        while (d->ended != mine || d->waiting > 0) pthread_cond_wait(&d->changed, &d->lock);
        in = shut_if_open(d, DOOR_WAITS);
        if (in) break;
        const uint64_t state = atomic_load(&d->state);
        inherited = state != DOOR_OPEN && state >> 32 != cw_process();
        if (inherited) break;
        pthread_mutex_unlock(&d->lock); /* an update runs that does not wait */
        pause_after(looks);
        pthread_mutex_lock(&d->lock);
    }
    if (inherited) end_turn(d);
    pthread_mutex_unlock(&d->lock);
    for (unsigned looks = 0; in && !is_quiet(d); looks++) pause_after(looks);
    return in;
}

bool cw_door_close(door *d, bool wait) {
    if (!wait) return close_at_once(d);
    const int cancel = cancel_disable();
    const bool closed = adopt(d) && close_in_turn(d);
    cancel_restore(cancel);
    return closed;
}

void cw_door_open(door *d, bool waited) {
    if (!waited) {
        atomic_store(&d->state, DOOR_OPEN);
        return;
    }
    pthread_mutex_lock(&d->lock);
    atomic_store(&d->state, DOOR_OPEN);
    end_turn(d);
    pthread_mutex_unlock(&d->lock);
}
