/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray exactly meets a triangle, so that even the strict answer has a measured error.
 *
 * t is a quotient of two sums of products of floats. A product of two floats is exact in double (48 bits of 53), and the
 * sums are made without error (expansions, Shewchuk 1997), so only their rounding to double and the division are not
 * exact: t is off by less than 2^-50 of itself, which is 2^-26 of a float's last place. */
#ifndef CELLWALK_BENCH_ACCURACY_EXACT_H
#define CELLWALK_BENCH_ACCURACY_EXACT_H

#include "cellwalk.h"

/* Samples as the reference sees them: (i, j) is z[j * nx + i]; no holes. They must stay. */
typedef struct tradeoff_ground {
    const float *z;
    size_t nx, ny;
    double highest; /* of the samples' absolute values */
} tradeoff_ground;

tradeoff_ground tradeoff_ground_of(const float *z, size_t nx, size_t ny);

typedef struct tradeoff_place {
    double t, u, v; /* u and v as in cw_hit */
    int32_t i, j;
    uint32_t triangle;
} tradeoff_place;

/* Sum of count numbers, rounded about once: its relative error is less than 2^-52. count <= TRADEOFF_SUM_MAX. */
enum { TRADEOFF_SUM_MAX = 16 };
double tradeoff_sum(const double *numbers, int count);

/* Where the ray meets the plane of a triangle; u and v tell whether inside. False if it runs parallel to it. */
bool tradeoff_meet(const tradeoff_ground *on, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle,
                   tradeoff_place *place);

/* Errors of a t: in units of the float's last place at the exact t; as the distance along the ray between the two places,
 * in cells. */
double tradeoff_t_ulp(double t, double exact);
double tradeoff_t_cells(const cw_ray *ray, double t, double exact);

#endif
