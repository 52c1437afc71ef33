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

typedef struct one_ray {
    quarter org, dir;
    quarter center, inverse; /* of crossings, mirrored so that x and y go up, which no operation rounds differently */
    float t0, t1, from, until;
    bool up_x, up_y;
    bool plain; /* as the caller's, not moved */
} one_ray;

static __attribute__((noinline)) bool make_special_ray(one_ray *r, const cw_field *f, const cw_ray *ray) {
    strict_ray s;
    if (!strict_ray_init(&s, f, ray, CW_LEAF_WATERTIGHT)) return false;
    r->org = (quarter){s.x.org, s.y.org, s.oz, 0};
    r->dir = (quarter){s.x.dir, s.y.dir, s.dz, 0};
    r->center = (quarter){(float)s.x.step * s.x.center, (float)s.y.step * s.y.center, 0, 0};
    r->inverse = (quarter){fabsf(s.x.inverse), fabsf(s.y.inverse), 0, 0};
    r->t0 = s.t0, r->t1 = s.t1, r->from = s.from, r->until = s.until;
    r->up_x = s.x.step > 0, r->up_y = s.y.step > 0;
    return true;
}

/* False if the ray cannot hit. */
CW_INLINE bool make_one_ray(one_ray *r, const cw_field *f, const cw_ray *ray) {
    typedef int32_t bits __attribute__((vector_size(16)));
    const float *const numbers = (const float *)ray;
    const quarter o = load_quarter(numbers), d = load_quarter(numbers + 4); /* with tmin and tmax as fourth */
    const bits sign = (bits)(quarter){-0.0f, -0.0f, -0.0f, -0.0f};
    const quarter off = (quarter)((bits)(o - load_quarter(f->middle)) & ~sign), length = (quarter)((bits)d & ~sign);
    const bits plain = (off < load_quarter(f->reach)) & (length > 0x1p-128f) & (length <= 0x1p126f);
    r->plain = (plain[0] & plain[1] & plain[2]) != 0;
    if (!r->plain) return make_special_ray(r, f, ray);

    const bits low = (bits)load_quarter(f->lowest), high = (bits)load_quarter(f->highest), up = d > 0;
    const quarter enter = (quarter)((low & up) | (high & ~up)) - o, leave = (quarter)((high & up) | (low & ~up)) - o;
    const quarter inverse = 1.0f / d, a = enter * inverse, b = leave * inverse;
    r->org = o;
    r->dir = d;
    r->center = (quarter)((bits)o ^ ((bits)d & sign));
    r->inverse = (quarter)((bits)inverse & ~sign);
    r->up_x = d[0] > 0;
    r->up_y = d[1] > 0;
    const float t0 = max_second(max_second(a[0], a[1]), max_second(ray->tmin, -RAY_T_LIMIT));
    const float t1 = min_second(min_second(b[0], b[1]), min_second(ray->tmax, RAY_T_LIMIT));
    const float dz = d[2], z0 = t0 * dz, z1 = t1 * dz;
    if (!(ray->tmin <= ray->tmax && t0 <= t1)) return false;
    if (!(max_second(z0, z1) >= f->low - o[2] && min_second(z0, z1) <= f->high - o[2])) return false;

    /* strict_slab */
    const float u8 = 8 * (FLT_EPSILON / 2), least = FLT_MIN * (1 + fabsf(inverse[2]));
    const float s0 = a[2] - u8 * (fabsf(a[2]) + least), s1 = b[2] + u8 * (fabsf(b[2]) + least);
    const float h0 = s0 * dz, h1 = s1 * dz;
    r->t0 = t0;
    r->t1 = t1;
    r->from = (dz > 0 ? h0 < enter[2] : h0 > enter[2]) && s0 > t0 ? s0 : t0;
    r->until = (dz > 0 ? h1 > leave[2] : h1 < leave[2]) && s1 < t1 ? s1 : t1;
    return true;
}

/* Number of the cell at t along axis c, or of an earlier one, within the field. See first_corner in lane_rays.h. */
CW_INLINE int32_t cell_at(const one_ray *r, int c, float t, size_t samples) {
    const bool up = c == 0 ? r->up_x : r->up_y;
    const float back = 0x1p-21f * (fabsf(r->org[c]) + (float)samples), last = (float)(samples - 1) - 0.5f;
    const float place = (r->org[c] - (up ? back : -back)) + t * r->dir[c];
    return (int32_t)max_second(min_second(place, last), 0);
}

/* For refine_hit. */
CW_INLINE void start_again(ray_start *s, const cw_field *f, const cw_ray *ray, bool plain) {
    if (!plain) {
        ray_init(s, f, ray);
        return;
    }
    *s = (ray_start){.dir = {ray->dir[0], ray->dir[1], ray->dir[2]},
                     .first = max_second(ray->tmin, -RAY_T_LIMIT),
                     .last = min_second(ray->tmax, RAY_T_LIMIT),
                     .base = {(double)ray->org[0], (double)ray->org[1], (double)ray->org[2]}};
}

#endif
