/* SPDX-License-Identifier: Apache-2.0 */
/* Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", 1997, with the two edges of a cell's triangle
 * written out: their x and y are 0 or 1. The order of operations is part of the contract: packet kernels repeat it. */
#ifndef CELLWALK_SCALAR_MOLLER_TRUMBORE_H
#define CELLWALK_SCALAR_MOLLER_TRUMBORE_H

#include "cellwalk.h"

/* Limits of a hit: its t, and its height relative to the ray's origin. */
typedef struct mt_range {
    float tmin, tmax, low, high;
} mt_range;

/* Ray against one triangle of a cell, relative to the cell's sample (i, j): o = org - (i, j, h00), edges e1 = (1,
 * e1y, e1z) and e2 = (e2x, 1, e2z), where e1y and e2x are 0 or 1 (constants to the compiler). Products with 0 are
 * left out, as they would change the sign of a zero or turn an overflow into NaN. True if hit->t, u, v are a hit in
 * the range. NaN in a vertex, or a ray in the triangle's plane (determinant 0), makes a comparison fail. */
static inline bool mt_triangle(const float o[3], const float d[3], bool e1y, float e1z, bool e2x, float e2z,
                               const mt_range *range, cw_hit *hit) {
    const float px = d[1] * e2z - d[2], py = (e2x ? d[2] : 0) - d[0] * e2z, pz = e2x ? d[0] - d[1] : d[0];
    const float det = (e1y ? px + py : px) + pz * e1z;
    const float inverse = 1.0f / det;
    const float u = ((o[0] * px + o[1] * py) + o[2] * pz) * inverse;
    const float qx = e1y ? o[1] * e1z - o[2] : o[1] * e1z, qy = o[2] - o[0] * e1z, qz = (e1y ? o[0] : 0) - o[1];
    const float v = ((d[0] * qx + d[1] * qy) + d[2] * qz) * inverse;
    const float t = ((e2x ? qx + qy : qy) + e2z * qz) * inverse;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t >= range->tmin && t <= range->tmax)) return false;
    if (!(t * d[2] >= range->low && t * d[2] <= range->high)) return false;
    hit->t = t;
    hit->u = u;
    hit->v = v;
    return true;
}

/* The nearer hit of the cell's two triangles; A if both are equally near. */
static inline bool mt_cell(const float org[3], const float dir[3], const mt_range *range, size_t i, size_t j, float h00,
                           float h10, float h01, float h11, cw_hit *hit) {
    const float o[3] = {org[0] - (float)i, org[1] - (float)j, org[2] - h00};
    cw_hit b = {.triangle = CW_TRIANGLE_B};
    hit->triangle = CW_TRIANGLE_A;
    const bool hit_a = mt_triangle(o, dir, false, h10 - h00, true, h11 - h00, range, hit);
    const bool hit_b = mt_triangle(o, dir, true, h11 - h00, false, h01 - h00, range, &b);
    if (hit_b && !(hit_a && hit->t <= b.t)) *hit = b;
    hit->i = (int32_t)i;
    hit->j = (int32_t)j;
    return hit_a || hit_b;
}

#endif
