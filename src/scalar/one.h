/* SPDX-License-Identifier: Apache-2.0 */
/* The walk of one ray: what one.c makes ready for simd/one_kernel.c, and what that finds. */
#ifndef CELLWALK_SCALAR_ONE_H
#define CELLWALK_SCALAR_ONE_H

#include "strict.h"

/* Rays that open more nodes run beside a surface, which the close walk of the pyramid kernels is made for. */
enum { ONE_OPENS = 48 };

typedef struct one_find {
    int32_t i, j; /* the cell */
    float t0, t1; /* see strict_find */
    bool b;
} one_find;

#endif
