/* SPDX-License-Identifier: Apache-2.0 */
/* Rays to field space with AVX2: a vector holds x, y, z of a point and beside it the end of the ray's interval, which is
 * just how both kinds of rays lie in memory. The sums are those of the scalar form in the same order, without fused
 * operations, so that the bits agree. */

#include "to_field.h"

#include <immintrin.h>

static inline __m256d combine(const __m256d column[3], const double v[3]) {
    const __m256d x = _mm256_mul_pd(column[0], _mm256_broadcast_sd(v));
    const __m256d y = _mm256_mul_pd(column[1], _mm256_broadcast_sd(v + 1));
    const __m256d z = _mm256_mul_pd(column[2], _mm256_broadcast_sd(v + 2));
    return _mm256_add_pd(_mm256_add_pd(x, y), z);
}

void cw_to_field_avx2(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out) {
    __m256d column[4];
    for (int c = 0; c < 4; c++) column[c] = _mm256_setr_pd(m[0][c], m[1][c], m[2][c], 0);
    for (size_t k = 0; k < n; k++) {
        const __m256d org = _mm256_add_pd(combine(column, in[k].org), column[3]), dir = combine(column, in[k].dir);
        const __m256d tmin = _mm256_broadcast_sd(&in[k].tmin), tmax = _mm256_broadcast_sd(&in[k].tmax);
        _mm_storeu_ps(out[k].org, _mm256_cvtpd_ps(_mm256_blend_pd(org, tmin, 8)));
        _mm_storeu_ps(out[k].dir, _mm256_cvtpd_ps(_mm256_blend_pd(dir, tmax, 8)));
    }
}
