/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for large arrays, in huge pages where the system gives them: it is touched in a fraction of the time. */
#ifndef CELLWALK_BASE_LARGE_H
#define CELLWALK_BASE_LARGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#ifdef _WIN32
#include <malloc.h>
#else
#include <sys/mman.h>
#endif

enum { LARGE_LINE = 64, LARGE_PAGE = 1 << 21 }; /* bytes of a cache line and of a huge page */

/* Begins at a cache line, a large array at a huge page; NULL when out of memory. To be freed by large_release, which is
 * free() everywhere but on Windows. */
static inline void *large_allocate(size_t bytes) {
    const bool large = bytes >= LARGE_PAGE;
    const size_t alignment = large ? LARGE_PAGE : LARGE_LINE;
#ifdef _WIN32
    return _aligned_malloc(bytes ? bytes : 1, alignment);
#else
    void *memory;
    if (posix_memalign(&memory, alignment, bytes ? bytes : 1) != 0) return NULL;
#ifdef MADV_HUGEPAGE
    /* A wish, on which nothing depends; the last, partly used huge page is left to small ones. */
    if (large) (void)madvise(memory, bytes / LARGE_PAGE * LARGE_PAGE, MADV_HUGEPAGE);
#endif
    return memory;
#endif
}

static inline void large_release(void *memory) {
#ifdef _WIN32
    _aligned_free(memory);
#else
    free(memory);
#endif
}

#endif
