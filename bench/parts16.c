/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, 16 lanes wide, for AVX-512; with CELLWALK_COUNT those that count. */

#include "vec_avx512.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_avx512
#else
#define PARTS_RUN parts_run_avx512
#endif

#include "parts.inc.c"
