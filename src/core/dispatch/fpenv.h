/* SPDX-License-Identifier: Apache-2.0 */
/* The IEEE default environment during a query: round to nearest, denormals kept, exceptions masked. Under flush-to-zero
 * or other rounding, callers would get other bits, and leaks. On x86-64 only MXCSR is set, on aarch64 FPCR: glibc's
 * FE_DFL_ENV keeps bits of later architectures. Elsewhere it is used. Exception flags that a query raises stay raised.
 * Rejected: taking them back, as Granite Rapids (Intel) waits to read what was written until all before is done: 1.6
 * times as long for a ray a call; fesetenv(FE_DFL_ENV), which also reloads the unused x87 state: ten times as long. */
#ifndef CELLWALK_CORE_FPENV_H
#define CELLWALK_CORE_FPENV_H

#include <stdbool.h>

#if defined(__SSE__)
typedef unsigned fpenv;
enum { FPENV_DEFAULT = 0x1f80, FPENV_FLAGS = 0x3f }; /* MXCSR after reset; its exception flags, which change nothing */
static inline bool fpenv_is_default(fpenv e) { return (e & ~(unsigned)FPENV_FLAGS) == FPENV_DEFAULT; }
static inline fpenv fpenv_enter(void) {
    const fpenv caller = __builtin_ia32_stmxcsr();
    if (!fpenv_is_default(caller)) __builtin_ia32_ldmxcsr(FPENV_DEFAULT);
    return caller;
}
static inline void fpenv_leave(fpenv caller) {
    if (!fpenv_is_default(caller)) __builtin_ia32_ldmxcsr(caller | (__builtin_ia32_stmxcsr() & FPENV_FLAGS));
}
#elif defined(__aarch64__)
#include <stdint.h>
typedef uint64_t fpenv;
enum { FPENV_FLAGS = 0 }; /* these are elsewhere */
static inline fpenv fpenv_enter(void) {
    fpenv caller;
    __asm__ volatile("mrs %0, fpcr" : "=r"(caller)::"memory");
    if (caller != 0) __asm__ volatile("msr fpcr, %0" ::"r"((uint64_t)0) : "memory");
    return caller;
}
static inline void fpenv_leave(fpenv caller) {
    if (caller != 0) __asm__ volatile("msr fpcr, %0" ::"r"(caller) : "memory");
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
static inline void fpenv_leave(fpenv caller) {
    fexcept_t raised;
    const int which = fetestexcept(FE_ALL_EXCEPT);
    fegetexceptflag(&raised, which);
    fesetenv(&caller);
    fesetexceptflag(&raised, which); /* without a trap */
}
#endif

/* Sets the default environment until the end of the block in which this stands. */
static inline void fpenv_restore(const fpenv *caller) { fpenv_leave(*caller); }
#define FPENV_HERE const fpenv fpenv_caller __attribute__((cleanup(fpenv_restore), unused)) = fpenv_enter()

#endif
