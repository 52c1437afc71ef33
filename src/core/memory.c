/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

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

const cw_allocator cw_memory_own = {.allocate = own_allocate, .release = own_release};

void *cw_memory_allocate(const cw_allocator *from, size_t bytes) {
    const int cancel = cancel_disable();
    void *memory = from->allocate(from->context, bytes ? bytes : 1, bytes >= LARGE_PAGE ? LARGE_PAGE : LARGE_LINE);
    cancel_restore(cancel);
    return memory;
}

void *cw_memory_clear(const cw_allocator *from, size_t bytes) {
    void *memory = cw_memory_allocate(from, bytes);
    if (memory) memset(memory, 0, bytes);
    return memory;
}

void cw_memory_free(const cw_allocator *from, void *memory) {
    if (memory == NULL) return;
    const int cancel = cancel_disable();
    from->release(from->context, memory);
    cancel_restore(cancel);
}
