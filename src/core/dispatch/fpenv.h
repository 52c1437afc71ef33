/* SPDX-License-Identifier: Apache-2.0 */
/* The IEEE default environment for the time of a query: round to nearest, denormals kept, exceptions masked. A caller
 * that runs with flush-to-zero or another rounding mode would otherwise get other bits, and leaks. On x86-64 only MXCSR is
 * set; fesetenv(FE_DFL_ENV) would also reload the x87 state, at ten times the cost, and nothing here uses x87. Elsewhere it
 * does what is wanted: on aarch64 it sets FPCR, flush-to-zero included, if that is not what it should be. */
#ifndef CELLWALK_CORE_FPENV_H
#define CELLWALK_CORE_FPENV_H

#if defined(__SSE__)
typedef unsigned fpenv;
enum { FPENV_DEFAULT = 0x1f80 }; /* MXCSR after reset */
static inline fpenv fpenv_enter(void) {
    const fpenv caller = __builtin_ia32_stmxcsr();
    if (caller != FPENV_DEFAULT) __builtin_ia32_ldmxcsr(FPENV_DEFAULT);
    return caller;
}
/* Also drops the exception flags that the query raised. */
static inline void fpenv_leave(fpenv caller) { __builtin_ia32_ldmxcsr(caller); }
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

#endif
