/* SPDX-License-Identifier: Apache-2.0 */
/* CPU detection. CPUID says what the CPU has; XGETBV says whether the operating system saves the wider registers, which
 * CPUID alone does not (a kernel booted with noxsave, or a hypervisor that hides AVX-512 state). */

#include "kernels.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>

static uint64_t enabled_state(void) {
    uint32_t low, high;
    __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
    return (uint64_t)high << 32 | low;
}

static cw_isa detect(void) {
    enum { LEAF1_SSE42 = 1 << 20, LEAF1_OSXSAVE = 1 << 27, LEAF1_AVX = 1 << 28 };
    enum { LEAF7_AVX2 = 1 << 5, LEAF7_BMI1 = 1 << 3, LEAF7_BMI2 = 1 << 8 };
    const uint32_t leaf7_avx512 = 1u << 16 | 1u << 17 | 1u << 30 | 1u << 31; /* F, DQ, BW, VL */
    const uint64_t ymm_state = 0x6, zmm_state = 0xe6;

    uint32_t a, b, c, d;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & LEAF1_SSE42)) return CW_ISA_SCALAR;
    const uint64_t state = c & LEAF1_OSXSAVE ? enabled_state() : 0;
    if (!(c & LEAF1_AVX) || (state & ymm_state) != ymm_state) return CW_ISA_SSE42;
    if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return CW_ISA_SSE42;
    if (!(b & LEAF7_AVX2) || !(b & LEAF7_BMI1) || !(b & LEAF7_BMI2)) return CW_ISA_SSE42;
    if ((b & leaf7_avx512) != leaf7_avx512 || (state & zmm_state) != zmm_state) return CW_ISA_AVX2;
    return CW_ISA_AVX512;
}
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

/* The widest set of the machine that the user allows; -1: not known yet. Detection and the environment give the same answer every
 * time, so two threads that race here both write it. */
static atomic_int most = -1;
static atomic_int limit = CW_ISA_ANY;

cw_isa cw_isa_best(void) {
    int m = atomic_load_explicit(&most, memory_order_relaxed);
    if (m < 0) {
        cw_isa machine = detect();
#if defined(CELLWALK_EMULATES_AVX512) /* a test's build, whose kernels for AVX-512 need AVX2 alone */
        if (machine == CW_ISA_AVX2) machine = CW_ISA_AVX512;
#endif
        m = (int)cw_isa_common(machine, allowed());
        atomic_store_explicit(&most, m, memory_order_relaxed);
    }
    return cw_isa_common((cw_isa)m, (cw_isa)atomic_load_explicit(&limit, memory_order_relaxed));
}

void cw_isa_limit(cw_isa isa) { atomic_store(&limit, (int)isa); }
