/* SPDX-License-Identifier: Apache-2.0 */
/* The floating-point environment as a caller may have set it: the CPU's control register, read and written as
 * one number. FP_MODES is 0 where this file does not know the CPU. */
#ifndef CELLWALK_TESTS_FP_REGISTER_H
#define CELLWALK_TESTS_FP_REGISTER_H

#include <stdint.h>

#if defined(__SSE__)
#include <xmmintrin.h>

enum { FP_MODES = 16 };

static inline uint64_t fp_register(void) { return _mm_getcsr(); }
static inline void fp_register_set(uint64_t value) { _mm_setcsr((unsigned)value); }

/* Mode number in [0, FP_MODES): bit 0 flushes denormal results to zero, bit 1 takes denormal operands for zero, the rest
 * chooses the rounding. Exceptions are masked, and one is marked as raised. */
static inline uint64_t fp_register_mode(unsigned mode) {
    enum { MASKED = 0x1f80, INEXACT = 0x20, FTZ = 0x8000, DAZ = 0x40, ROUNDING = 0x2000 };
    return MASKED | INEXACT | (mode & 1 ? FTZ : 0) | (mode & 2 ? DAZ : 0) | mode / 4 * ROUNDING;
}

#elif defined(__aarch64__)

enum { FP_MODES = 16 };

/* FPCR below, FPSR above. */
static inline uint64_t fp_register(void) {
    uint64_t control, status;
    __asm__ volatile("mrs %0, fpcr\n\tmrs %1, fpsr" : "=r"(control), "=r"(status) : : "memory");
    return control | status << 32;
}
static inline void fp_register_set(uint64_t value) {
    __asm__ volatile("msr fpcr, %0\n\tmsr fpsr, %1" : : "r"(value & 0xffffffff), "r"(value >> 32) : "memory");
}

/* The same, but that bit 0 is for operands and results both, and bit 1 gives every NaN the same bits. */
static inline uint64_t fp_register_mode(unsigned mode) {
    const uint64_t flush = 1u << 24, default_nan = 1u << 25, rounding = 1u << 22, inexact = (uint64_t)0x10 << 32;
    return inexact | (mode & 1 ? flush : 0) | (mode & 2 ? default_nan : 0) | mode / 4 * rounding;
}

#else

enum { FP_MODES = 0 };
static inline uint64_t fp_register(void) { return 0; }
static inline void fp_register_set(uint64_t value) { (void)value; }
static inline uint64_t fp_register_mode(unsigned mode) { return mode; }

#endif

#endif
