/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps queries and updates of a field apart: an update fails while queries run, and a query fails while an update
 * runs.
 *
 * A query enters and leaves. One counter for all threads would move from core to core with every query. So there are
 * several, each on a separate cache line, and the address of a thread's stack selects one. A thread is mostly alone
 * at its counter, and then leaves by a plain store: one locked instruction a query in all. */
#ifndef CELLWALK_CORE_DOOR_H
#define CELLWALK_CORE_DOOR_H

#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DOOR_ENTRIES = 16, CACHE_LINE = 64 };

typedef struct door_entry {
    alignas(CACHE_LINE) atomic_bool first; /* a query is in that found nobody there */
    atomic_uint others;                    /* and so many that did */
} door_entry;

typedef struct door {
    door_entry entry[DOOR_ENTRIES];
    alignas(CACHE_LINE) atomic_bool updating;
} door;

/* The state that a query passes back when it leaves. */
typedef struct door_pass {
    door_entry *entry; /* NULL: it is not in */
    bool first;
} door_pass;

static inline void door_leave(door_pass pass) {
    if (pass.first)
        atomic_store_explicit(&pass.entry->first, false, memory_order_release);
    else
        atomic_fetch_sub(&pass.entry->others, 1);
}

/* Not in while an update runs. */
static inline door_pass door_enter(const door *d) {
    char here; /* on this thread's stack; stacks lie 64 kB apart at least */
    const uint64_t place = (uint64_t)((uintptr_t)&here >> 16) * 0x9E3779B97F4A7C15;
    bool nobody = false;
    door_pass pass = {.entry = (door_entry *)&d->entry[place >> 60]}; /* of a field that is const to its queries */
    pass.first = atomic_compare_exchange_strong(&pass.entry->first, &nobody, true);
    if (!pass.first) atomic_fetch_add(&pass.entry->others, 1);
    if (!atomic_load(&d->updating)) return pass;
    door_leave(pass);
    return (door_pass){NULL, false};
}

static inline bool door_is_quiet(const door *d) {
    for (size_t k = 0; k < DOOR_ENTRIES; k++)
        if (atomic_load(&d->entry[k].first) || atomic_load(&d->entry[k].others) != 0) return false;
    return true;
}

/* False if a query or another update runs. Looks twice, so that a query which runs meanwhile hardly ever sees an
 * update that will not be. */
static inline bool door_close(door *d) {
    if (!door_is_quiet(d) || atomic_exchange(&d->updating, true)) return false;
    if (door_is_quiet(d)) return true;
    atomic_store(&d->updating, false);
    return false;
}

static inline void door_open(door *d) { atomic_store(&d->updating, false); }

#endif
