/* SPDX-License-Identifier: Apache-2.0 */
/* One ray made ready for a walk, by the rules of src/scalar/strict.h, operation by operation. Lanes are axes: x, y,
 * height, and a fourth that nobody uses. So one operation does for three, where a ray in all lanes (vector_rays.h)
 * takes one for each.
 *
 * Invariant: the numbers are those of strict_ray_init, bit by bit. Rays that have something special, as vstart.plain
 * says, are left to it. Rejected: to leave all to it, or to vector_rays.h (papers/walks.md). */
#ifndef CELLWALK_SIMD_ONE_RAY_H
#define CELLWALK_SIMD_ONE_RAY_H

#include "../src/scalar/strict.h"
#include "field.h"
#include "vocabulary.h"

#include <float.h>

/* Not inlined, so that other rays do not pay for its registers. */
static __attribute__((noinline)) bool init_special(strict_ray *r, const cw_field *f, const cw_ray *ray) {
    return strict_ray_init(r, f, ray, CW_LEAF_WATERTIGHT);
}

/* strict_ray_init, but for borders and members of start that refine_hit does not read. False if the ray cannot hit. */
CW_INLINE bool init_one_ray(strict_ray *r, const cw_field *f, const cw_ray *ray) {
    typedef int32_t bits __attribute__((vector_size(16)));
    const float *const numbers = (const float *)ray;
    const quarter o = load_quarter(numbers), d = load_quarter(numbers + 4); /* with tmin and tmax as fourth */
    const bits sign = (bits)(quarter){-0.0f, -0.0f, -0.0f, -0.0f};
    const quarter off = (quarter)((bits)(o - load_quarter(f->middle)) & ~sign), length = (quarter)((bits)d & ~sign);
    const bits plain = (off < load_quarter(f->reach)) & (length > 0x1p-128f) & (length <= 0x1p126f);
    if ((plain[0] & plain[1] & plain[2]) == 0) return init_special(r, f, ray);

    const bits low = (bits)load_quarter(f->lowest), high = (bits)load_quarter(f->highest), up = d > 0;
    const quarter enter = (quarter)((low & up) | (high & ~up)) - o, leave = (quarter)((high & up) | (low & ~up)) - o;
    const quarter inverse = 1.0f / d, a = enter * inverse, b = leave * inverse;
    const float first = max_second(ray->tmin, -RAY_T_LIMIT), last = min_second(ray->tmax, RAY_T_LIMIT);
    const float t0 = max_second(max_second(a[0], a[1]), first), t1 = min_second(min_second(b[0], b[1]), last);
    const float dz = d[2], z0 = t0 * dz, z1 = t1 * dz;
    if (!(ray->tmin <= ray->tmax && t0 <= t1)) return false;
    if (!(max_second(z0, z1) >= f->low - o[2] && min_second(z0, z1) <= f->high - o[2])) return false;

    /* strict_slab */
    const float u8 = 8 * (FLT_EPSILON / 2), least = FLT_MIN * (1 + fabsf(inverse[2]));
    const float s0 = a[2] - u8 * (fabsf(a[2]) + least), s1 = b[2] + u8 * (fabsf(b[2]) + least);
    const float h0 = s0 * dz, h1 = s1 * dz;
    r->x.org = r->x.center = o[0], r->x.dir = d[0], r->x.inverse = inverse[0], r->x.step = d[0] > 0 ? 1 : -1;
    r->y.org = r->y.center = o[1], r->y.dir = d[1], r->y.inverse = inverse[1], r->y.step = d[1] > 0 ? 1 : -1;
    r->oz = o[2];
    r->dz = dz;
    r->t0 = t0;
    r->t1 = t1;
    r->from = (dz > 0 ? h0 < enter[2] : h0 > enter[2]) && s0 > t0 ? s0 : t0;
    r->until = (dz > 0 ? h1 > leave[2] : h1 < leave[2]) && s1 < t1 ? s1 : t1;
    for (int c = 0; c < 3; c++) {
        r->start.dir[c] = d[c];
        r->start.base[c] = (double)o[c];
    }
    r->start.first = first;
    r->start.last = last;
    r->start.shift = 0;
    return true;
}

/* Number of the cell at t along an axis, or of an earlier one, within the field. See first_corner in lane_rays.h. */
CW_INLINE int32_t cell_at(const strict_axis *a, float t, size_t samples) {
    const float back = 0x1p-21f * (fabsf(a->org) + (float)samples), last = (float)(samples - 1) - 0.5f;
    const float place = (a->org - (float)a->step * back) + t * a->dir;
    return (int32_t)max_second(min_second(place, last), 0);
}

#endif
