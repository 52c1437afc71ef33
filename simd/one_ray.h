/* SPDX-License-Identifier: Apache-2.0 */
/* One ray made ready for a walk, by the rules of src/scalar/strict.h, operation by operation. Lanes are axes: x, y,
 * height, and a fourth that nobody uses. So one operation does for two or three, where a ray in all lanes
 * (vector_rays.h) takes one for each.
 *
 * Invariant: the numbers are those of strict_ray_init, bit by bit, but for the walk's range, which strict_slab
 * has not cut: nodes end a walk as early. Rays that have something special, as vstart.plain says, are left to it.
 * Rejected: to leave all to it, or to vector_rays.h. */
#ifndef CELLWALK_SIMD_ONE_RAY_H
#define CELLWALK_SIMD_ONE_RAY_H

#include "../src/scalar/strict.h"
#include "field.h"
#include "vocabulary.h"

/* Not inlined, so that other rays do not pay for its registers. */
static __attribute__((noinline)) bool init_special(strict_ray *r, const cw_field *f, const cw_ray *ray) {
    return strict_ray_init(r, f, ray, CW_LEAF_WATERTIGHT);
}

/* Sets all but borders, and members of start that refine_hit does not read. False if the ray cannot hit. */
CW_INLINE bool init_one_ray(strict_ray *r, const cw_field *f, const cw_ray *ray) {
    typedef int32_t bits __attribute__((vector_size(16)));
    const float *const numbers = (const float *)ray;
    const quarter o = load_quarter(numbers), d = load_quarter(numbers + 4); /* with tmin and tmax as fourth */
    const bits sign = (bits)(quarter){-0.0f, -0.0f, -0.0f, -0.0f};
    const quarter off = (quarter)((bits)(o - load_quarter(f->middle)) & ~sign), length = (quarter)((bits)d & ~sign);
    const bits plain = (off < load_quarter(f->reach)) & (length > 0x1p-128f) & (length <= 0x1p126f);
    if ((plain[0] & plain[1] & plain[2]) == 0) return init_special(r, f, ray);

    const bits high = (bits)load_quarter(f->last), up = d > 0;
    const quarter enter = (quarter)(high & ~up) - o, leave = (quarter)(high & up) - o;
    const quarter inverse = 1.0f / d, a = enter * inverse, b = leave * inverse;
    const float first = max_second(ray->tmin, -RAY_T_LIMIT), last = min_second(ray->tmax, RAY_T_LIMIT);
    const float t0 = max_second(max_second(a[0], a[1]), first), t1 = min_second(min_second(b[0], b[1]), last);
    const float dz = d[2], z0 = t0 * dz, z1 = t1 * dz;
    if (!(ray->tmin <= ray->tmax && t0 <= t1)) return false;
    if (!(max_second(z0, z1) >= f->low - o[2] && min_second(z0, z1) <= f->high - o[2])) return false;

    r->x.org = r->x.center = o[0], r->x.dir = d[0], r->x.inverse = inverse[0], r->x.step = d[0] > 0 ? 1 : -1;
    r->y.org = r->y.center = o[1], r->y.dir = d[1], r->y.inverse = inverse[1], r->y.step = d[1] > 0 ? 1 : -1;
    r->oz = o[2];
    r->dz = dz;
    r->t0 = t0;
    r->t1 = t1;
    r->from = t0;
    r->until = t1;
    for (int c = 0; c < 3; c++) {
        r->start.dir[c] = d[c];
        r->start.base[c] = (double)o[c];
    }
    r->start.first = first;
    r->start.last = last;
    r->start.shift = 0;
    return true;
}

/* Where a ray begins: its cell or, of cells that it crosses, an earlier one, and its height above a sample of that cell. */
typedef struct one_start {
    int32_t i, j;
    float height;
} one_start;

/* False if that is not within the field. Cells are found as by first_corner in lane_rays.h. */
CW_INLINE bool starts_inside(const cw_field *f, const cw_ray *ray, one_start *at) {
    typedef int32_t bits __attribute__((vector_size(16)));
    const float *const numbers = (const float *)ray;
    const quarter o = load_quarter(numbers), d = load_quarter(numbers + 4), high = load_quarter(f->last);
    const bits sign = (bits)(quarter){-0.0f, -0.0f, -0.0f, -0.0f}, up = d > 0;
    const quarter back = 0x1p-21f * ((quarter)((bits)o & ~sign) + (high + 1)), way = ray->tmin * d;
    const quarter place = (o - (quarter)((bits)back ^ (sign & ~up))) + way;
    const bits inside = (place >= 0) & (place < high);
    if ((inside[0] & inside[1]) == 0) return false;
    at->i = (int32_t)place[0];
    at->j = (int32_t)place[1];
    at->height = o[2] + way[2] - f->z[(size_t)at->j * f->stride + (size_t)at->i];
    return true;
}

#endif
