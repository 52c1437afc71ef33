/* SPDX-License-Identifier: Apache-2.0 */
/* Every function of both libraries that works for long or calls back, as a table, for tests of what holds for all. */
#ifndef CELLWALK_TESTS_CALLS_H
#define CELLWALK_TESTS_CALLS_H

#include "fields.h"

typedef struct every_call {
    const char *name;
    size_t stack; /* bytes of it that the headers promise */
    /* On the field that calls_begin has made. CW_OK if all went as it should. */
    cw_status (*make)(const cw_run *run);
    bool unwatched; /* no watch is called, or terrain/test_areas.py looks at it */
    bool allocates; /* memory or threads; others must not */
} every_call;

extern const every_call every_calls[];
extern const size_t every_calls_count;

/* What the headers say of the stack: calls of few rays, others, and those of cellwalk_terrain.h. */
enum { STACK_FOR_FEW = 16 << 10, STACK_FOR_ALL = 128 << 10, STACK_FOR_TERRAIN = 48 << 10 };

/* Makes a field of up to 256 × 256 samples, which stay, with a terrain. allocator may be NULL. */
cw_field *calls_begin(const test_field *f, const cw_allocator *allocator);
void calls_end(void);

/* A sum of all answers of calls since the last one. */
uint64_t calls_sum(void);

#endif
