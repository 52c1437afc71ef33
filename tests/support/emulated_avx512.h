/* SPDX-License-Identifier: Apache-2.0 */
/* AVX-512 for CPUs without it: SIMDe carries out its intrinsics, so that vec_avx512.h and the kernels 16 lanes wide are
 * tested on any machine. Included ahead of a stub by the compiler's -include. What SIMDe lacks is written out here. */
#ifndef CELLWALK_TESTS_EMULATED_AVX512_H
#define CELLWALK_TESTS_EMULATED_AVX512_H

#define SIMDE_ENABLE_NATIVE_ALIASES
#include <simde/x86/avx512.h>

static inline __m512 emulated_cvtepi32_ps(__m512i a) {
    int32_t from[16];
    float to[16];
    _mm512_storeu_si512(from, a);
    for (int k = 0; k < 16; k++) to[k] = (float)from[k];
    return _mm512_loadu_ps(to);
}
#define _mm512_cvtepi32_ps emulated_cvtepi32_ps

/* For numbers outside int32 the instruction returns INT32_MIN. */
static inline __m512i emulated_cvttps_epi32(__m512 a) {
    float from[16];
    int32_t to[16];
    _mm512_storeu_ps(from, a);
    for (int k = 0; k < 16; k++) to[k] = from[k] >= -0x1p31f && from[k] < 0x1p31f ? (int32_t)from[k] : INT32_MIN;
    return _mm512_loadu_si512(to);
}
#define _mm512_cvttps_epi32 emulated_cvttps_epi32

/* SIMDe's keep the sign of -0 and of NaN. */
static inline __m512 emulated_abs_ps(__m512 a) {
    return _mm512_castsi512_ps(_mm512_and_si512(_mm512_castps_si512(a), _mm512_set1_epi32(INT32_MAX)));
}
static inline __m512d emulated_abs_pd(__m512d a) {
    return _mm512_castsi512_pd(_mm512_and_si512(_mm512_castpd_si512(a), _mm512_set1_epi64(INT64_MAX)));
}
#undef _mm512_abs_ps
#undef _mm512_abs_pd
#define _mm512_abs_ps emulated_abs_ps
#define _mm512_abs_pd emulated_abs_pd

static inline __m512 emulated_mask_gather(__m512 other, __mmask16 m, __m512i index, const float *base) {
    int32_t at[16];
    float to[16];
    _mm512_storeu_si512(at, index);
    _mm512_storeu_ps(to, other);
    for (int k = 0; k < 16; k++)
        if (m >> k & 1) to[k] = base[at[k]];
    return _mm512_loadu_ps(to);
}
#undef _mm512_i32gather_ps
#undef _mm512_mask_i32gather_ps
#define _mm512_i32gather_ps(index, base, scale)                emulated_mask_gather(_mm512_setzero_ps(), 0xffff, index, base)
#define _mm512_mask_i32gather_ps(other, m, index, base, scale) emulated_mask_gather(other, m, index, base)

static inline __m512d emulated_cvtps_pd(__m256 a) {
    float from[8];
    double to[8];
    _mm256_storeu_ps(from, a);
    for (int k = 0; k < 8; k++) to[k] = (double)from[k];
    return _mm512_loadu_pd(to);
}
#define _mm512_cvtps_pd emulated_cvtps_pd

static inline __m256 emulated_cvtpd_ps(__m512d a) {
    double from[8];
    float to[8];
    _mm512_storeu_pd(from, a);
    for (int k = 0; k < 8; k++) to[k] = (float)from[k];
    return _mm256_loadu_ps(to);
}
#define _mm512_cvtpd_ps emulated_cvtpd_ps

static inline __m256 emulated_extractf32x8(__m512 a, int half) {
    float from[16];
    _mm512_storeu_ps(from, a);
    return _mm256_loadu_ps(from + 8 * half);
}
#define _mm512_extractf32x8_ps emulated_extractf32x8

static inline __m512d emulated_i32gather_pd(__m256i index, const void *base) {
    int32_t at[8];
    double to[8];
    _mm256_storeu_si256((__m256i *)(void *)at, index);
    for (int k = 0; k < 8; k++) __builtin_memcpy(&to[k], (const char *)base + 4 * (ptrdiff_t)at[k], sizeof to[k]);
    return _mm512_loadu_pd(to);
}
#undef _mm512_i32gather_pd
#define _mm512_i32gather_pd(index, base, scale) emulated_i32gather_pd(index, base)

/* Quarters: two of a, then two of b. */
static inline __m512 emulated_shuffle_f32x4(__m512 a, __m512 b, int which) {
    float from[2][16], to[16];
    _mm512_storeu_ps(from[0], a);
    _mm512_storeu_ps(from[1], b);
    for (int k = 0; k < 16; k++) to[k] = from[k / 8][4 * (which >> (k / 4 * 2) & 3) + k % 4];
    return _mm512_loadu_ps(to);
}
#define _mm512_shuffle_f32x4 emulated_shuffle_f32x4

static inline __m512d emulated_shuffle_pd(__m512d a, __m512d b, int which) {
    double from[2][8], to[8];
    _mm512_storeu_pd(from[0], a);
    _mm512_storeu_pd(from[1], b);
    for (int k = 0; k < 8; k++) to[k] = from[k % 2][k / 2 * 2 + (which >> k & 1)];
    return _mm512_loadu_pd(to);
}
#define _mm512_shuffle_pd emulated_shuffle_pd

#endif
