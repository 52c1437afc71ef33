/* SPDX-License-Identifier: Apache-2.0 */
/* How functions of the kernels are inlined, and how many registers a vector has. */
#ifndef CELLWALK_SIMD_INLINE_H
#define CELLWALK_SIMD_INLINE_H

/* Registers of a vector: 1, or 2 if the file that includes the vocabulary has defined it so. */
#ifndef REGISTERS
#define REGISTERS 1
#endif

/* For bodies that take constant arguments (leaf test, kind of query) or a ray by pointer: unless it is inlined, a compiler
 * keeps the choice at run time and writes the ray's twenty vectors to the stack for the call. */
#define CW_INLINE static inline __attribute__((always_inline))

/* For bodies of which one copy serves all callers, whatever constants they pass. */
#ifdef __clang__
#define CW_ONE_COPY __attribute__((noinline))
#else
#define CW_ONE_COPY __attribute__((noipa))
#endif

#endif
