/* SPDX-License-Identifier: Apache-2.0 */
/* Rays from user space to field space with AVX2. A vector holds x, y, z of a point and one end of the ray's range,
 * which is the layout of both kinds of rays in memory. The sums are those of the scalar form in the same order,
 * without fused operations, so that the bits agree. */

#include "to_field.h"

#include "vec_avx2_double.h"

static inline vdouble combine(const vdouble column[3], const double v[3]) {
    const vdouble x = vd_mul(column[0], vd_broadcast(v)), y = vd_mul(column[1], vd_broadcast(v + 1));
    return vd_add(vd_add(x, y), vd_mul(column[2], vd_broadcast(v + 2)));
}

void cw_to_field_avx2(const double m[3][4], const cw_user_ray *in, size_t n, cw_ray *out) {
    vdouble column[3];
    for (int c = 0; c < 3; c++) column[c] = vd_setr(m[0][c], m[1][c], m[2][c], 0);
    for (size_t k = 0; k < n; k++) {
        const double *o = in[k].org, from[3] = {o[0] - m[0][3], o[1] - m[1][3], o[2] - m[2][3]};
        const vdouble org = combine(column, from), dir = combine(column, in[k].dir);
        vd_store_floats((float *)&out[k], vd_replace_last(org, vd_broadcast(&in[k].tmin)));
        vd_store_floats((float *)&out[k] + 4, vd_replace_last(dir, vd_broadcast(&in[k].tmax)));
    }
}
