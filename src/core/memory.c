/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

#include <stdbool.h>
#include <stdlib.h>
#include <sys/mman.h>

enum { CACHE_LINE = 64, HUGE_PAGE = 1 << 21 };

void *cw_memory_allocate(size_t bytes) {
    void *memory;
    const bool large = bytes >= HUGE_PAGE;
    if (posix_memalign(&memory, large ? HUGE_PAGE : CACHE_LINE, bytes ? bytes : 1) != 0) return NULL;
#ifdef MADV_HUGEPAGE
    /* A wish, on which nothing depends; the last, partly used huge page is left to small ones. */
    if (large) (void)madvise(memory, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
#endif
    return memory;
}

void cw_memory_free(void *memory) { free(memory); }
