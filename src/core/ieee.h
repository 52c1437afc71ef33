/* SPDX-License-Identifier: Apache-2.0 */
/* Refuses to be compiled without IEEE arithmetic, or for 32 bits. src/flags.cmake takes back a parent project's flags;
 * this is for other builds. Every result depends on NaN, signed zeros, infinities and the order of operations. */
#ifndef CELLWALK_CORE_IEEE_H
#define CELLWALK_CORE_IEEE_H

#include <float.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) ||                               \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#error "Cellwalk needs IEEE arithmetic: compile it without -ffast-math, -Ofast and the flags that these imply"
#endif
#if SIZE_MAX < UINT64_MAX
#error "Cellwalk is for 64-bit targets: sizes are checked in 64 bits"
#endif
#if FLT_EVAL_METHOD != 0
#error                                                                                                                 \
    "Cellwalk needs float operations rounded to float: 32-bit x86 has them with -msse2 -mfpmath=sse alone, and is not supported"
#endif
_Static_assert(sizeof 1.0 == sizeof(double), "-fsingle-precision-constant changes results");

#endif
