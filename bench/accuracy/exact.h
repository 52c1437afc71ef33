/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray exactly meets a triangle, so that even the strict answer has a measured error.
 *
 * t is a quotient of two sums of products of floats. A product of two floats is exact in double (48 bits of 53), and the
 * sums are made without error (expansions, Shewchuk 1997), so only their rounding to double and the division are not
 * exact: t is off by less than 2^-50 of itself, which is 2^-26 of a float's last place. */
#ifndef CELLWALK_BENCH_ACCURACY_EXACT_H
#define CELLWALK_BENCH_ACCURACY_EXACT_H

#include "cellwalk.h"

/* The true surface: sample (i, j) is z[j * nx + i]; no holes. The samples must stay. */
typedef struct true_surface {
    const float *z;
    size_t nx, ny;
    double highest, steepest; /* of all samples and of their differences along edges, in size */
} true_surface;

true_surface true_surface_of(const float *z, size_t nx, size_t ny);

typedef struct exact_hit {
    double t, u, v; /* u and v as in cw_hit */
    int32_t i, j;
    uint32_t triangle;
} exact_hit;

/* Sum of count numbers, rounded about once: its relative error is less than 2^-52. count <= EXACT_SUM_MAX. */
enum { EXACT_SUM_MAX = 16 };
double exact_sum(const double *numbers, int count);

/* Where the ray meets the plane of a triangle; u and v tell whether inside. False if it runs parallel to it. */
bool exact_meet(const true_surface *on, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle, exact_hit *hit);

/* Errors of a t: in units of the float's last place at the exact t; as the distance along the ray between the two places,
 * in cells. */
double exact_error_ulp(double t, double exact);
double exact_error_cells(const cw_ray *ray, double t, double exact);

#endif
