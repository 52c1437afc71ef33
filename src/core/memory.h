/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for samples and bounds: cache-line aligned, on huge pages where the system offers them, because rays through a
 * large field touch a new page with almost every node. */
#ifndef CELLWALK_CORE_MEMORY_H
#define CELLWALK_CORE_MEMORY_H

#include "cellwalk.h"

/* The allocator of a field whose description has none. */
extern const cw_allocator cw_memory_own;

/* NULL when out of memory. */
CW_API void *cw_memory_allocate(const cw_allocator *from, size_t bytes);
/* The same, all zero. */
CW_API void *cw_memory_clear(const cw_allocator *from, size_t bytes);
/* NULL is allowed. */
CW_API void cw_memory_free(const cw_allocator *from, void *memory);

#endif
