/* SPDX-License-Identifier: Apache-2.0 */
/* Four doubles a vector, for AVX2: the operations that to_field_avx2.c uses. */
#ifndef CELLWALK_SIMD_VEC_AVX2_DOUBLE_H
#define CELLWALK_SIMD_VEC_AVX2_DOUBLE_H

#include <immintrin.h>

typedef struct vdouble {
    __m256d v;
} vdouble;

static inline vdouble vd_setr(double a, double b, double c, double d) { return (vdouble){_mm256_setr_pd(a, b, c, d)}; }
static inline vdouble vd_broadcast(const double *a) { return (vdouble){_mm256_broadcast_sd(a)}; }
static inline vdouble vd_add(vdouble a, vdouble b) { return (vdouble){_mm256_add_pd(a.v, b.v)}; }
static inline vdouble vd_mul(vdouble a, vdouble b) { return (vdouble){_mm256_mul_pd(a.v, b.v)}; }
/* a with its last lane taken from b. */
static inline vdouble vd_replace_last(vdouble a, vdouble b) { return (vdouble){_mm256_blend_pd(a.v, b.v, 8)}; }
/* Rounded to four floats, any alignment. */
static inline void vd_store_floats(float *to, vdouble a) { _mm_storeu_ps(to, _mm256_cvtpd_ps(a.v)); }

#endif
