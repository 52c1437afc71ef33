/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, 8 lanes wide, for AVX2; with CELLWALK_COUNT those that count. */

#include "vec_avx2.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_avx2
#else
#define PARTS_RUN parts_run_avx2
#endif

#include "parts.inc.c"
