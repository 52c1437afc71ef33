/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, 4 lanes wide, for SSE4.2; with CELLWALK_COUNT those that count. */

#include "vec_sse42.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_sse42
#else
#define PARTS_RUN parts_run_sse42
#endif

#include "parts.inc.c"
