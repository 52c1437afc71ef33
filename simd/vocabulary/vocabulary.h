/* SPDX-License-Identifier: Apache-2.0 */
/* The vector vocabulary that the build names for this object, and the name of the code that comes of it:
 *
 *     CELLWALK_VOCABULARY  "vec_avx2.h", the header with the vectors' types and operations
 *     CELLWALK_PAIRS       defined where two such vectors go in lockstep as one
 *     CELLWALK_SUFFIX      8, of which CW_CODE(pyramid) makes cw_pyramid8
 *
 * simd/CMakeLists.txt sets them. */
#ifndef CELLWALK_SIMD_VOCABULARY_H
#define CELLWALK_SIMD_VOCABULARY_H

/* For bodies that take constant arguments (leaf test, kind of query) or a ray by pointer: unless it is inlined, a compiler
 * keeps the choice at run time and writes the ray's twenty vectors to the stack for the call. */
#define CW_INLINE static inline __attribute__((always_inline))

/* For bodies of which one copy serves all callers, whatever constants they pass. */
#ifdef __clang__
#define CW_ONE_COPY static __attribute__((noinline))
#else
#define CW_ONE_COPY static __attribute__((noipa))
#endif

#ifdef CELLWALK_PAIRS
#include "vec_half.h"
#endif

#include CELLWALK_VOCABULARY

#ifdef CELLWALK_PAIRS
#include "vec_twice.h"
#endif

#define CW_PASTE(kind, suffix)   cw_##kind##suffix
#define CW_CODE_OF(kind, suffix) CW_PASTE(kind, suffix)
#define CW_CODE(kind)            CW_CODE_OF(kind, CELLWALK_SUFFIX)

#endif
