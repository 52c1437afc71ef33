/* SPDX-License-Identifier: Apache-2.0 */
#include "memory.h"

#include "large.h"

void *cw_memory_allocate(size_t bytes) { return large_allocate(bytes); }

void cw_memory_free(void *memory) { free(memory); }
