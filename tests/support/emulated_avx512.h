/* SPDX-License-Identifier: Apache-2.0 */
/* AVX-512 for CPUs without it: SIMDe carries out its intrinsics, so that vec_avx512.h and the kernels 16 lanes wide are
 * tested on any machine. Included ahead of a stub by -include. What SIMDe lacks is written here, in GCC's vectors. */
#ifndef CELLWALK_TESTS_EMULATED_AVX512_H
#define CELLWALK_TESTS_EMULATED_AVX512_H

#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/avx512.h>

/* The same bits as vectors whose lanes have numbers. */
typedef float lanes_ps __attribute__((vector_size(64)));
typedef double lanes_pd __attribute__((vector_size(64)));
typedef int32_t lanes_i32 __attribute__((vector_size(64)));
typedef float half_ps __attribute__((vector_size(32)));

#define _mm512_cvtps_pd(a) ((__m512d) __builtin_convertvector((half_ps)(a), lanes_pd))
#define _mm512_cvtpd_ps(a) ((__m256) __builtin_convertvector((lanes_pd)(a), half_ps))

/* Not fused: rf_mul_sub's products are exact. */
#define _mm512_fmsub_round_ps(a, b, c, rounding) ((__m512)((lanes_ps)(a) * (lanes_ps)(b) - (lanes_ps)(c)))

static inline __m512 emulated_mask_gather(__m512 other, __mmask16 m, __m512i index, const float *base) {
    lanes_ps to = (lanes_ps)other;
    for (int k = 0; k < 16; k++)
        if (m >> k & 1) to[k] = base[((lanes_i32)index)[k]];
    return (__m512)to;
}
#undef _mm512_i32gather_ps
#undef _mm512_mask_i32gather_ps
#define _mm512_i32gather_ps(index, base, scale)                emulated_mask_gather(_mm512_setzero_ps(), 0xffff, index, base)
#define _mm512_mask_i32gather_ps(other, m, index, base, scale) emulated_mask_gather(other, m, index, base)

static inline __m256 emulated_extractf32x8(__m512 a, int half) {
    half_ps to;
    for (int k = 0; k < 8; k++) to[k] = ((lanes_ps)a)[8 * half + k];
    return (__m256)to;
}
#define _mm512_extractf32x8_ps emulated_extractf32x8

#endif
