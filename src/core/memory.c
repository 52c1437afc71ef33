/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

#include <stdlib.h>
#include <sys/mman.h>

enum { CACHE_LINE = 64, HUGE_PAGE = 1 << 21 };

/* Whole huge pages only from the size on at which the last one's unused part is below an eighth. */
static size_t alignment(size_t bytes) { return bytes >= 8 * (size_t)HUGE_PAGE ? HUGE_PAGE : CACHE_LINE; }

void *cw_memory_allocate(size_t bytes) {
    const size_t align = alignment(bytes), rounded = (bytes + align - 1) / align * align;
    if (rounded < bytes) return NULL;
    void *memory = aligned_alloc(align, rounded ? rounded : align);
#ifdef MADV_HUGEPAGE
    if (memory && align == HUGE_PAGE) (void)madvise(memory, rounded, MADV_HUGEPAGE); /* a wish: nothing depends on it */
#endif
    return memory;
}

void cw_memory_free(void *memory) { free(memory); }
