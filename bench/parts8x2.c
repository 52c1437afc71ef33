/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, twice 8 lanes wide, for AVX2; with CELLWALK_COUNT those that count. */

#include "vec_half.h"

#include "vec_avx2.h"

#include "vec_twice.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_avx2_twice
#else
#define PARTS_RUN parts_run_avx2_twice
#endif

#include "parts.inc.c"
