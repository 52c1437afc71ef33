/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, twice 4 lanes wide, for SSE4.2; with CELLWALK_COUNT those that count. */

#include "vec_half.h"

#include "vec_sse42.h"

#include "vec_twice.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_sse42_twice
#else
#define PARTS_RUN parts_run_sse42_twice
#endif

#include "parts.inc.c"
