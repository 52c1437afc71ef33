/* SPDX-License-Identifier: Apache-2.0 */
/* Tells queries and updates of a field apart: whoever comes second is turned away, whatever it finds of the other.
 *
 * A query counts itself in and out. One count for all threads would travel from core to core with every query; so there are
 * several, each on a cache line of its own, and a thread takes the one that its stack points to. */
#ifndef CELLWALK_CORE_DOOR_H
#define CELLWALK_CORE_DOOR_H

#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { DOOR_COUNTS = 16, DOOR_LINE = 64 };

typedef struct door_count {
    alignas(DOOR_LINE) atomic_uint queries;
} door_count;

typedef struct door {
    door_count count[DOOR_COUNTS];
    alignas(DOOR_LINE) atomic_bool updating;
} door;

/* NULL while an update runs. What it returns goes to door_leave. */
static inline door_count *door_enter(const door *g) {
    char here; /* on this thread's stack; stacks lie 64 kB apart at least */
    const uint64_t place = (uint64_t)((uintptr_t)&here >> 16) * 0x9E3779B97F4A7C15;
    door_count *count = (door_count *)&g->count[place >> 60]; /* of a field that is const to its queries */
    atomic_fetch_add(&count->queries, 1);
    if (!atomic_load(&g->updating)) return count;
    atomic_fetch_sub(&count->queries, 1);
    return NULL;
}

static inline void door_leave(door_count *count) { atomic_fetch_sub(&count->queries, 1); }

static inline bool door_is_quiet(const door *g) {
    for (size_t k = 0; k < DOOR_COUNTS; k++)
        if (atomic_load(&g->count[k].queries) != 0) return false;
    return true;
}

/* False if a query or another update runs. Looks twice, so that a query which runs meanwhile hardly ever sees an update that
 * will not be. */
static inline bool door_close(door *g) {
    if (!door_is_quiet(g) || atomic_exchange(&g->updating, true)) return false;
    if (door_is_quiet(g)) return true;
    atomic_store(&g->updating, false);
    return false;
}

static inline void door_open(door *g) { atomic_store(&g->updating, false); }

#endif
