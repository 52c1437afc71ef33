/* SPDX-License-Identifier: Apache-2.0 */
/* CPU detection, by the compiler's library, which also looks whether the operating system saves the wider registers: a
 * kernel booted with noxsave does not, nor a hypervisor that hides AVX-512 state. */

#include "kernels.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) || defined(__i386__)
#define HAS(set) __builtin_cpu_supports(set)
static cw_isa detect(void) {
    __builtin_cpu_init();
    if (!HAS("sse4.2")) return CW_ISA_SCALAR;
    if (!HAS("avx2") || !HAS("bmi") || !HAS("bmi2")) return CW_ISA_SSE42;
    if (!HAS("avx512f") || !HAS("avx512vl") || !HAS("avx512dq") || !HAS("avx512bw")) return CW_ISA_AVX2;
    return CW_ISA_AVX512;
}
#undef HAS
#elif defined(__aarch64__)
static cw_isa detect(void) { return CW_ISA_NEON; } /* part of the architecture */
#else
static cw_isa detect(void) { return CW_ISA_SCALAR; }
#endif

/* The name of each instruction set, and the widest other one that it includes. */
static const struct {
    const char *name;
    cw_isa includes;
} sets[CW_ISA_COUNT] = {
    [CW_ISA_SCALAR] = {"scalar", CW_ISA_SCALAR}, [CW_ISA_SSE42] = {"sse4.2", CW_ISA_SCALAR},
    [CW_ISA_AVX2] = {"avx2", CW_ISA_SSE42},      [CW_ISA_AVX512] = {"avx512", CW_ISA_AVX2},
    [CW_ISA_NEON] = {"neon", CW_ISA_SCALAR},
};

static bool is_set(cw_isa isa) { return isa > CW_ISA_ANY && isa < CW_ISA_COUNT; }

const char *cw_isa_name(cw_isa isa) { return is_set(isa) ? sets[isa].name : NULL; }

bool cw_isa_includes(cw_isa whole, cw_isa part) {
    if (!is_set(whole) || !is_set(part)) return false;
    while (whole != part && whole != CW_ISA_SCALAR) whole = sets[whole].includes;
    return whole == part;
}

/* The widest set that both include. CW_ISA_ANY, or a set that only a later version knows, includes all. */
cw_isa cw_isa_common(cw_isa a, cw_isa b) {
    if (!is_set(b)) return a;
    while (!cw_isa_includes(b, a)) a = sets[a].includes;
    return a;
}

/* The user's limit. A name that is unknown here limits nothing: a later version may know it. */
static cw_isa allowed(void) {
    const char *text = getenv("CELLWALK_ISA");
    for (cw_isa k = CW_ISA_SCALAR; text && k < CW_ISA_COUNT; k++)
        if (strcmp(text, sets[k].name) == 0) return k;
    return CW_ISA_ANY;
}

/* The widest set of the machine that the user allows. Detection and the environment give the same answer every time, so
 * two threads that race here both write it. */
static cw_isa widest(void) {
    static atomic_int known = CW_ISA_ANY;
    cw_isa isa = (cw_isa)atomic_load_explicit(&known, memory_order_relaxed);
    if (isa != CW_ISA_ANY) return isa;
    isa = detect();
#if defined(CELLWALK_EMULATES_AVX512) /* a test's build, whose kernels for AVX-512 need AVX2 alone */
    if (isa == CW_ISA_AVX2) isa = CW_ISA_AVX512;
#endif
    isa = cw_isa_common(isa, allowed());
    atomic_store_explicit(&known, (int)isa, memory_order_relaxed);
    return isa;
}

atomic_int cw_isa_in_use = CW_ISA_ANY;

cw_isa cw_isa_best(void) {
    int isa = atomic_load_explicit(&cw_isa_in_use, memory_order_relaxed);
    if (isa != CW_ISA_ANY) return (cw_isa)isa;
    const cw_isa first = widest(); /* unless a limit is set meanwhile */
    return atomic_compare_exchange_strong(&cw_isa_in_use, &isa, (int)first) ? first : (cw_isa)isa;
}

void cw_isa_limit(cw_isa isa) { atomic_store(&cw_isa_in_use, (int)cw_isa_common(widest(), isa)); }
