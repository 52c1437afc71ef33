/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

#include "error.h"
#include "large.h"
#include "process.h"

#include <string.h>

static void *own_allocate(void *context, size_t bytes, size_t alignment) {
    (void)context, (void)alignment;
    return large_allocate(bytes);
}

static void own_release(void *context, void *memory) {
    (void)context;
    large_release(memory);
}

static const cw_allocator own = {.allocate = own_allocate, .release = own_release};
static cw_allocator present = {.allocate = own_allocate, .release = own_release};

cw_status cw_allocator_set(const cw_allocator *allocator) {
    if (allocator && (allocator->allocate == NULL || allocator->release == NULL))
        return cw_fail(CW_ERROR_ARGUMENT, "%s: NULL", allocator->allocate ? "release" : "allocate");
    present = allocator ? *allocator : own;
    return CW_OK;
}

void *cw_memory_allocate(size_t bytes) {
    enum { CACHE_LINE = 64, HUGE_PAGE = 1 << 21 };
    const int cancel = cancel_disable();
    void *memory = present.allocate(present.context, bytes ? bytes : 1, bytes >= HUGE_PAGE ? HUGE_PAGE : CACHE_LINE);
    cancel_restore(cancel);
    return memory;
}

void *cw_memory_clear(size_t bytes) {
    void *memory = cw_memory_allocate(bytes);
    if (memory) memset(memory, 0, bytes);
    return memory;
}

void cw_memory_free(void *memory) {
    if (memory == NULL) return;
    const int cancel = cancel_disable();
    present.release(present.context, memory);
    cancel_restore(cancel);
}
