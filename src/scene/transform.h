/* SPDX-License-Identifier: Apache-2.0 */
/* Affine maps, and vectors of three doubles. */
#ifndef CELLWALK_SCENE_TRANSFORM_H
#define CELLWALK_SCENE_TRANSFORM_H

#include "affine.h"

/* Three rows of four: point -> m[.][0..2] · point + m[.][3]. */
typedef struct transform {
    double m[3][4];
} transform;

static inline double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross(const double a[3], const double b[3], double out[3]) {
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

/* A power of two is taken out first, which changes no bit: of 10^160 and 10^-170 the squares are infinite and 0. */
static inline void normalise(double v[3]) {
    int exponent = 0;
    frexp(fmax(fmax(fabs(v[0]), fabs(v[1])), fabs(v[2])), &exponent);
    for (int c = 0; c < 3; c++) v[c] = ldexp(v[c], -exponent);
    const double scale = 1 / sqrt(dot(v, v));
    for (int c = 0; c < 3; c++) v[c] *= scale;
}

static inline transform transform_identity(void) { return (transform){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}; }

static inline void transform_point(const transform *t, const double p[3], double out[3]) {
    const double from[3] = {p[0], p[1], p[2]}; /* p may be out */
    affine_vector(t->m, from, out);
    for (int r = 0; r < 3; r++) out[r] += t->m[r][3];
}

/* Applies b first, then a. */
static inline transform transform_multiply(const transform *a, const transform *b) {
    transform out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            out.m[r][c] =
                a->m[r][0] * b->m[0][c] + a->m[r][1] * b->m[1][c] + a->m[r][2] * b->m[2][c] + (c == 3 ? a->m[r][3] : 0);
    return out;
}

/* False, with out undefined, if a cannot be inverted. */
static inline bool transform_invert(const transform *a, transform *out) {
    if (!affine_invert(a->m, out->m)) return false;
    const transform linear = *out;
    const double shift[3] = {a->m[0][3], a->m[1][3], a->m[2][3]};
    double back[3];
    affine_vector(linear.m, shift, back);
    for (int r = 0; r < 3; r++) {
        out->m[r][3] = -back[r];
        if (!isfinite(back[r])) return false;
    }
    return true;
}

/* Whether the renderer can measure in the space that t maps to the world. It keeps squares of lengths as floats, of the
 * space's axes and of the rows of the inverse: beyond 10^38 and below 10^-38 they are infinite or 0. */
static inline bool transform_is_measurable(const transform *t) {
    transform back;
    if (!transform_invert(t, &back)) return false;
    for (int c = 0; c < 3; c++) {
        const double axis[3] = {t->m[0][c], t->m[1][c], t->m[2][c]};
        const double length = sqrt(dot(axis, axis)), inverse = sqrt(dot(back.m[c], back.m[c]));
        if (!(fmin(length, inverse) >= 1e-18 && fmax(length, inverse) <= 1e18)) return false;
    }
    return true;
}

#endif
