/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for large arrays, in huge pages where the system gives them: it is touched in a fraction of the time. */
#ifndef CELLWALK_BASE_LARGE_H
#define CELLWALK_BASE_LARGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/mman.h>

/* Begins at a cache line; NULL when out of memory. To be freed by free(). */
static inline void *large_allocate(size_t bytes) {
    enum { CACHE_LINE = 64, HUGE_PAGE = 1 << 21 };
    void *memory;
    const bool large = bytes >= HUGE_PAGE;
    if (posix_memalign(&memory, large ? HUGE_PAGE : CACHE_LINE, bytes ? bytes : 1) != 0) return NULL;
#ifdef MADV_HUGEPAGE
    /* A wish, on which nothing depends; the last, partly used huge page is left to small ones. */
    if (large) (void)madvise(memory, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
#endif
    return memory;
}

#endif
