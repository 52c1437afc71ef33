/* SPDX-License-Identifier: Apache-2.0 */
/* Keeps queries and updates of a field apart. An update fails while queries run, a query while such an update runs. An
 * update may instead wait: it shuts the door, queries inside run to their end, and later ones wait for the update.
 *
 * Nobody starves. Updates that wait are served in the order in which they came, and none shuts the door before all
 * queries that waited for the last one are in.
 *
 * A query enters and leaves. One counter for all threads would move from core to core with every query. So there are
 * several, each on a separate cache line, and the address of a thread's stack selects one. A thread is mostly alone
 * at its counter, and then leaves by a plain store: one locked instruction a query in all. A process of one thread uses
 * the first counter, and no locked instruction.
 *
 * Counts hold the process that they were made in. A child made by fork has none of its parent's other threads, and what
 * they left in the counters counts for nothing there. A parent's update never ends there, so the field stays shut. */
#ifndef CELLWALK_CORE_DOOR_H
#define CELLWALK_CORE_DOOR_H

#include "process.h"

#include <stdalign.h>
#include <stddef.h>
#include <stdint.h>

enum { DOOR_ENTRIES = 16, CACHE_LINE = 64 };

typedef struct door_entry {
    alignas(CACHE_LINE) atomic_uint first; /* the process of a query that found nobody there; 0: none is in */
    atomic_uint_least64_t others;          /* how many found somebody, and above 32 bits their process */
} door_entry;

typedef struct door {
    door_entry entry[DOOR_ENTRIES];
    /* DOOR_OPEN, or for which process an update has shut it (above 32 bits) and a door_shut */
    alignas(CACHE_LINE) atomic_uint_least64_t state;
    atomic_uint owner;    /* the process that the rest belongs to; 0: is being made */
    pthread_mutex_t lock; /* of the members below */
    pthread_cond_t changed;
    size_t waiting;       /* queries that wait for an update */
    uint64_t came, ended; /* updates that wait: how many came, and how many of them have ended */
} door;

typedef enum door_shut { DOOR_OPEN, DOOR_REFUSES, DOOR_WAITS } door_shut;

/* The state that a query passes back when it leaves. */
typedef struct door_pass {
    door_entry *entry; /* NULL: it is not in */
    unsigned process;
    bool first;
} door_pass;

static inline uint64_t door_others(uint64_t others, unsigned process) {
    return others >> 32 == process ? others & UINT32_MAX : 0;
}

/* A child does not count what its parent counted, so it takes nothing off either. */
static inline void door_leave(door_pass pass) {
    if (pass.process != cw_process()) return;
    if (pass.first)
        atomic_store_explicit(&pass.entry->first, 0, memory_order_release);
    else
        atomic_fetch_sub(&pass.entry->others, 1);
}

/* Not in while an update runs. */
static inline door_pass door_try(const door *d) {
    char here; /* on this thread's stack; stacks lie 64 kB apart at least */
    const bool one_thread = process_has_one_thread();
    const uint64_t place = one_thread ? 0 : (uint64_t)((uintptr_t)&here >> 16) * 0x9E3779B97F4A7C15;
    door_pass pass = {.entry = (door_entry *)&d->entry[place >> 60], /* of a field that is const to its queries */
                      .process = cw_process()};
    unsigned found = atomic_load_explicit(&pass.entry->first, memory_order_relaxed);
    if (one_thread && found != pass.process) {
        /* A signal handler may come between: it leaves the entry as it finds it. */
        atomic_store_explicit(&pass.entry->first, pass.process, memory_order_relaxed);
        pass.first = true;
    } else {
        pass.first = found != pass.process && atomic_compare_exchange_strong(&pass.entry->first, &found, pass.process);
    }
    if (!pass.first) {
        uint64_t others = atomic_load(&pass.entry->others), more;
        do more = ((uint64_t)pass.process << 32 | door_others(others, pass.process)) + 1;
        while (!atomic_compare_exchange_weak(&pass.entry->others, &others, more));
    }
    if (atomic_load(&d->state) == DOOR_OPEN) return pass;
    door_leave(pass);
    return (door_pass){NULL, 0, false};
}

/* For a query that found it shut. */
door_pass cw_door_wait(door *d);

/* Waits for an update that waits; not in while another one runs. */
static inline door_pass door_enter(const door *d) {
    const door_pass pass = door_try(d);
    return pass.entry != NULL ? pass : cw_door_wait((door *)d);
}

/* False when out of memory. */
bool cw_door_make(door *d);
void cw_door_destroy(door *d);

/* Shuts it for an update. Without wait, false if a query or update runs; else only in a child: shut by its parent, or
 * out of memory. */
bool cw_door_close(door *d, bool wait);
void cw_door_open(door *d, bool waited);

#endif
