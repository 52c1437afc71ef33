/* SPDX-License-Identifier: Apache-2.0 */
/* The kernels' pieces, 1 lane wide; with CELLWALK_COUNT those that count. */

#include "vec_scalar.h"

#ifdef CELLWALK_COUNT
#define PARTS_RUN parts_count_scalar
#else
#define PARTS_RUN parts_run_scalar
#endif

#include "parts.inc.c"
