/* SPDX-License-Identifier: Apache-2.0 */
/* Rays from user space to field space. A vector holds x, y, z of a point and one end of the ray's range, the layout of
 * both kinds of rays in memory; compilers split it for narrower registers. The sums are those of affine.h, in the same
 * order. Rejected: loops over x, y and z, which GCC 12 does not vectorise and which take twice as long with AVX2. */
#include "kernels.h"
#include "vocabulary.h"

#include <string.h>

typedef double doubles __attribute__((vector_size(4 * sizeof(double))));
typedef float floats __attribute__((vector_size(4 * sizeof(float))));

static inline floats combine(const doubles column[3], const double v[3], double last) {
    const doubles sum = column[0] * v[0] + column[1] * v[1] + column[2] * v[2], end = {last, last, last, last};
    return __builtin_convertvector(__builtin_shufflevector(sum, end, 0, 1, 2, 7), floats);
}

void CW_CODE(to_field)(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out) {
    const doubles column[3] = {
        {m[0][0], m[1][0], m[2][0], 0}, {m[0][1], m[1][1], m[2][1], 0}, {m[0][2], m[1][2], m[2][2], 0}};
    for (size_t k = 0; k < n; k++) {
        const double *o = in[k].org, from[3] = {o[0] - m[0][3], o[1] - m[1][3], o[2] - m[2][3]};
        const floats org = combine(column, from, in[k].tmin), dir = combine(column, in[k].dir, in[k].tmax);
        memcpy(&out[k], &org, sizeof org);
        memcpy((char *)&out[k] + sizeof org, &dir, sizeof dir);
    }
}
