/* SPDX-License-Identifier: Apache-2.0 */
/* Affine maps as three rows of four doubles. */
#ifndef CELLWALK_BASE_AFFINE_H
#define CELLWALK_BASE_AFFINE_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

static inline void affine_vector(const double m[3][4], const double v[3], double out[3]) {
    for (int r = 0; r < 3; r++) out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
}

static inline void affine_point(const double m[3][4], const double p[3], double out[3]) {
    affine_vector(m, p, out);
    for (int r = 0; r < 3; r++) out[r] += m[r][3];
}

/* Transposed linear part: normals go from user space to field space by the map's transpose, hence from field space to
 * user space by the transpose of the inverse. */
static inline void affine_covector(const double inverse[3][4], const double n[3], double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = inverse[0][c] * n[0] + inverse[1][c] * n[1] + inverse[2][c] * n[2];
}

/* Scales m by the power of two that makes the largest entry of its linear part about 1. That changes no bit of a
 * direction, but of entries of 10^200 the squares would overflow. */
static inline void affine_scale(double m[3][4]) {
    double most = 0;
    int exponent;
    for (int k = 0; k < 9; k++) most = fmax(most, fabs(m[k / 3][k % 3]));
    frexp(most, &exponent);
    for (int k = 0; k < 12; k++) m[k / 4][k % 4] = ldexp(m[k / 4][k % 4], -exponent);
}

/* p by the inverse of a map, as affine_invert gives it: first off comes the translation, which is exact or nearly so
 * for all near it, then the linear part. A field thousands of kilometres from the origin loses nothing. */
static inline void affine_point_back(const double inverse[3][4], const double p[3], double out[3]) {
    const double from[3] = {p[0] - inverse[0][3], p[1] - inverse[1][3], p[2] - inverse[2][3]};
    affine_vector(inverse, from, out);
}

/* The inverse of the linear part, with m's own translation beside it. False if one is not finite or m is singular: with
 * rows scaled to unit size, so that neither kilometres nor nanometres count as singular, the determinant is at most what
 * rounding makes of its terms: 8 roundings by 2^-53 each, of three entries, two products, a difference and two sums. */
static inline bool affine_invert(const double m[3][4], double out[3][4]) {
    double scale[3], a[3][3];
    for (int r = 0; r < 3; r++) {
        scale[r] = fmax(fmax(fabs(m[r][0]), fabs(m[r][1])), fabs(m[r][2]));
        for (int c = 0; c < 4; c++)
            if (!isfinite(m[r][c])) return false;
        if (!(scale[r] > 0)) return false;
        for (int c = 0; c < 3; c++) a[r][c] = m[r][c] / scale[r];
    }
    double cofactor[3][3]; /* cofactor[c][r] of a[r][c] */
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            cofactor[c][r] = a[r1][c1] * a[r2][c2] - a[r1][c2] * a[r2][c1];
        }
    const double det = a[0][0] * cofactor[0][0] + a[0][1] * cofactor[1][0] + a[0][2] * cofactor[2][0];
    double size = 0;
    for (int c = 0; c < 3; c++)
        size +=
            fabs(a[0][c]) * (fabs(a[1][(c + 1) % 3] * a[2][(c + 2) % 3]) + fabs(a[1][(c + 2) % 3] * a[2][(c + 1) % 3]));
    if (!(fabs(det) > 4 * DBL_EPSILON * size)) return false;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            out[r][c] = cofactor[r][c] / det / scale[c];
            if (!isfinite(out[r][c])) return false;
        }
        out[r][3] = m[r][3];
    }
    return true;
}

#endif
