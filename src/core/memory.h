/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for samples and bounds: cache-line aligned, on huge pages where the system offers them, because rays through a
 * large field touch a new page with almost every node. */
#ifndef CELLWALK_CORE_MEMORY_H
#define CELLWALK_CORE_MEMORY_H

#include <stddef.h>

/* From the process's allocator; NULL when out of memory. */
void *cw_memory_allocate(size_t bytes);
/* The same, all zero. */
void *cw_memory_clear(size_t bytes);
/* NULL is allowed. */
void cw_memory_free(void *memory);

#endif
