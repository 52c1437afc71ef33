/* SPDX-License-Identifier: Apache-2.0 */
/* The IEEE default environment for the time of a query: round to nearest, denormals kept, exceptions masked. Under
 * flush-to-zero or another rounding mode, a caller would get other bits, and leaks. On x86-64 only MXCSR is set.
 * Rejected: fesetenv(FE_DFL_ENV), which also reloads the x87 state, unused here, and takes ten times as long. On
 * aarch64 FPCR is set to 0: glibc's FE_DFL_ENV does not change the bits of later architectures. Elsewhere FE_DFL_ENV
 * is used. */
#ifndef CELLWALK_CORE_FPENV_H
#define CELLWALK_CORE_FPENV_H

#if defined(__SSE__)
typedef unsigned fpenv;
enum { FPENV_DEFAULT = 0x1f80, FPENV_FLAGS = 0x3f }; /* MXCSR after reset; its exception flags, which change nothing */
static inline fpenv fpenv_enter(void) {
    const fpenv caller = __builtin_ia32_stmxcsr();
    if ((caller & ~(unsigned)FPENV_FLAGS) != FPENV_DEFAULT) __builtin_ia32_ldmxcsr(FPENV_DEFAULT);
    return caller;
}
/* Also drops the exception flags that the query raised. */
static inline void fpenv_leave(fpenv caller) { __builtin_ia32_ldmxcsr(caller); }
#elif defined(__aarch64__)
#include <stdint.h>
typedef struct fpenv {
    uint64_t fpcr, fpsr; /* control; exception flags */
} fpenv;
static inline fpenv fpenv_enter(void) {
    fpenv caller;
    __asm__ volatile("mrs %0, fpcr" : "=r"(caller.fpcr)::"memory");
    __asm__ volatile("mrs %0, fpsr" : "=r"(caller.fpsr)::"memory");
    if (caller.fpcr != 0) __asm__ volatile("msr fpcr, %0" ::"r"((uint64_t)0) : "memory");
    return caller;
}
/* Also drops the exception flags that the query raised. */
static inline void fpenv_leave(fpenv caller) {
    __asm__ volatile("msr fpsr, %0" ::"r"(caller.fpsr) : "memory");
    if (caller.fpcr != 0) __asm__ volatile("msr fpcr, %0" ::"r"(caller.fpcr) : "memory");
}
#else
#include <fenv.h>
typedef fenv_t fpenv;
static inline fpenv fpenv_enter(void) {
    fpenv caller;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    return caller;
}
static inline void fpenv_leave(fpenv caller) { fesetenv(&caller); }
#endif

/* Sets the default environment until the end of the block in which this stands. */
static inline void fpenv_restore(const fpenv *caller) { fpenv_leave(*caller); }
#define FPENV_HERE const fpenv fpenv_caller __attribute__((cleanup(fpenv_restore), unused)) = fpenv_enter()

#endif
