/* SPDX-License-Identifier: Apache-2.0 */
/* Exact arithmetic of the oracle: crossings compared and heights signed in whole numbers. A ray's x, y and direction are
 * multiples of one power of two, its heights and the samples of another; t is a ratio. */
#ifndef CELLWALK_TESTS_EXACT_H
#define CELLWALK_TESTS_EXACT_H

#include "cellwalk.h"

#include <gmp.h>

/* What a crossing is with: x = number, y = number, x - y = number, or t = constant. */
typedef enum crossing_kind { CROSSING_X, CROSSING_Y, CROSSING_DIAGONAL, CROSSING_CONSTANT } crossing_kind;

/* A t of interest. */
typedef struct crossing {
    crossing_kind kind;
    int32_t number;
    float constant;
    double t, error; /* |t - exact t| <= error */
} crossing;

typedef struct exact {
    bool ready; /* the present ray is loaded */
    const cw_ray *ray;
    int field_exponent; /* all samples are multiples of 2^field_exponent */
    long plane_scale, height_scale;
    mpz_t ox, oy, dx, dy, oz, dz;
    mpz_t num_a, den_a, num_b, den_b, h, ha, hb, x, y, z, sum;
} exact;

void exact_init(exact *e, const float *samples, size_t n);
void exact_clear(exact *e);

/* The ray of the calls that follow; it stays where it is meanwhile. Components that count as zero are zero. */
void exact_ray(exact *e, const cw_ray *ray);

/* Sign of a - b. */
int exact_order(exact *e, const crossing *a, const crossing *b);

/* t itself, off by less than 2^-50 relative. */
double exact_value(exact *e, const crossing *at);

/* The plane through a triangle: height h at (i, j), rises a along x and b along y, as differences of samples. */
typedef struct exact_plane {
    int32_t i, j;
    float h, a1, a0, b1, b0; /* rise along x: a1 - a0; along y: b1 - b0 */
} exact_plane;

/* Sign of ray height minus plane height at a crossing. */
int exact_side(exact *e, const crossing *at, const exact_plane *p);

/* t at which the ray meets the plane, off by less than 2^-50 relative; the two are not parallel. */
double exact_meet(exact *e, const exact_plane *p);

/* Is x - y of the origin whole; *floor of it. */
bool exact_diagonal(exact *e, int32_t *floor);

#endif
