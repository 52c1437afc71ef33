/* SPDX-License-Identifier: Apache-2.0 */
/* Where a ray exactly meets a triangle, so that even the strict answer has a measured error.
 *
 * t is a quotient of two sums of products of floats. A product of two floats is exact in double (48 bits of 53), and the
 * sums are made without error (expansions, Shewchuk 1997), so only their rounding to double and the division are not
 * exact: t is off by less than 2^-50 of itself, which is 2^-26 of a float's last place. */
#include "accuracy/judge.h"

#include <float.h>
#include <math.h>

true_surface true_surface_of(const float *z, size_t nx, size_t ny) {
    true_surface s = {.z = z, .nx = nx, .ny = ny, .low = (double)z[0], .high = (double)z[0]};
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) {
            const double here = (double)z[j * nx + i];
            s.low = fmin(s.low, here);
            s.high = fmax(s.high, here);
            for (size_t edge = 1; edge < 4; edge++) /* along x, along y, the diagonal */
                if (i + edge % 2 < nx && j + edge / 2 < ny)
                    s.steepest = fmax(s.steepest, fabs((double)z[(j + edge / 2) * nx + i + edge % 2] - here));
        }
    return s;
}

/* a + b = sum + error, exactly (Knuth). */
static double two_sum(double a, double b, double *error) {
    const double sum = a + b, part = sum - a;
    *error = (a - (sum - part)) + (b - part);
    return sum;
}

double exact_sum(const double *numbers, int count) {
    double expansion[EXACT_SUM_MAX]; /* components from small to large that do not overlap */
    int size = 0;
    for (int k = 0; k < count; k++) {
        double carry = numbers[k];
        int kept = 0;
        for (int c = 0; c < size; c++) {
            double error;
            carry = two_sum(carry, expansion[c], &error);
            if (error != 0) expansion[kept++] = error;
        }
        expansion[kept++] = carry;
        size = kept;
    }
    double sum = 0;
    for (int c = 0; c < size; c++) sum += expansion[c];
    return sum;
}

/* A direction that the library counts as zero. */
static double direction(float d) { return fabsf(1.0f / d) <= FLT_MAX ? (double)d : 0; }

bool exact_meet(const true_surface *on, const cw_ray *ray, int32_t i, int32_t j, uint32_t triangle, exact_hit *hit) {
    const bool a = triangle == CW_TRIANGLE_A;
    const float *z = on->z + (size_t)j * on->nx + (size_t)i;
    const double h = (double)z[0], far = (double)z[on->nx + 1], corner = (double)(a ? z[1] : z[on->nx]);
    /* Slope along x: x_to - x_from; along y: y_to - y_from. */
    const double x_from = a ? h : corner, x_to = a ? corner : far, y_from = a ? corner : h, y_to = a ? far : corner;
    const double ox = (double)ray->org[0], oy = (double)ray->org[1], oz = (double)ray->org[2];
    const double dx = direction(ray->dir[0]), dy = direction(ray->dir[1]), dz = direction(ray->dir[2]);
    const double above[] = {oz,          -h,         -x_to * ox,  x_from * ox, x_to * i,
                            -x_from * i, -y_to * oy, y_from * oy, y_to * j,    -y_from * j};
    const double falling[] = {x_to * dx, -x_from * dx, y_to * dy, -y_from * dy, -dz};
    const double rate = exact_sum(falling, 5);
    if (rate == 0) return false;
    const double t = exact_sum(above, 10) / rate, x = (ox - i) + t * dx, y = (oy - j) + t * dy;
    *hit = (exact_hit){t, a ? x - y : x, a ? y : y - x, i, j, a ? CW_TRIANGLE_A : CW_TRIANGLE_B};
    return true;
}

double exact_error_ulp(double t, double exact) {
    int exponent;
    frexp(exact, &exponent); /* |exact| in [2^(exponent - 1), 2^exponent) */
    if (exact == 0 || exponent < FLT_MIN_EXP) exponent = FLT_MIN_EXP;
    return fabs(t - exact) / ldexp(1, exponent - FLT_MANT_DIG);
}

double exact_error_cells(const cw_ray *ray, double t, double exact) {
    double squares = 0;
    for (int k = 0; k < 3; k++) squares += (double)ray->dir[k] * (double)ray->dir[k];
    return fabs(t - exact) * sqrt(squares);
}
