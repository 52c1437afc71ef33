/* SPDX-License-Identifier: Apache-2.0 */
/* One ray made ready for a walk, by the rules of src/scalar/strict.h, operation by operation. Lanes are axes: x, y,
 * height, and a fourth, unused. So one operation does for two or three, where a ray in all lanes
 * (vector_rays.h) takes one for each.
 *
 * Invariant: the numbers are those of strict_ray_init, bit by bit, but for the walk's range, which strict_slab
 * has not cut: nodes end a walk as early. Rays that have something special, as vstart.plain says, are left to it.
 * Rejected: to leave all to it, or to vector_rays.h. */
#ifndef CELLWALK_SIMD_ONE_RAY_H
#define CELLWALK_SIMD_ONE_RAY_H

#include "../src/scalar/strict.h"
#include "children.h"
#include "field.h"
#include "vocabulary.h"

/* See strict_ray. The height of center and of inverse is unused. */
typedef struct one_ray {
    quarter org, dir, center, inverse;
    float t0, t1, from;
    unsigned up;  /* bit 0: the ray goes up in x; bit 1: in y */
    bool special; /* made ready by strict_ray_init */
} one_ray;

/* Not inlined, so that other rays do not pay for its registers. The walk's range is not cut, as for them. */
static __attribute__((noinline)) bool init_special(one_ray *r, const cw_field *f, const cw_ray *ray) {
    strict_ray s;
    if (!strict_ray_init(&s, f, ray, CW_LEAF_WATERTIGHT)) return false;
    *r = (one_ray){
        .org = {s.x.org, s.y.org, s.oz},
        .dir = {s.x.dir, s.y.dir, s.dz},
        .center = {s.x.center, s.y.center},
        .inverse = {s.x.inverse, s.y.inverse},
        .t0 = s.t0,
        .t1 = s.t1,
        .from = s.t0,
        .up = (s.x.step > 0) + 2u * (s.y.step > 0),
        .special = true,
    };
    return true;
}

/* False if the ray cannot hit. */
CW_INLINE bool init_one_ray(one_ray *r, const cw_field *f, const cw_ray *ray) {
    typedef int32_t bits __attribute__((vector_size(16)));
    const float *const numbers = (const float *)ray;
    const quarter o = load_quarter(numbers), d = load_quarter(numbers + 4); /* with tmin and tmax as fourth */
    const bits sign = (bits)(quarter){-0.0f, -0.0f, -0.0f, -0.0f};
    const quarter off = (quarter)((bits)(o - load_quarter(f->middle)) & ~sign), length = (quarter)((bits)d & ~sign);
    const bits plain = (off < load_quarter(f->reach)) & (length > 0x1p-128f) & (length <= 0x1p126f);
    if ((quarter_signs((quarter)plain) & 7) != 7) return init_special(r, f, ray);

    const bits high = (bits)load_quarter(f->last), up = d > 0;
    const quarter enter = (quarter)(high & ~up) - o, leave = (quarter)(high & up) - o;
    const quarter inverse = 1.0f / d, a = enter * inverse, b = leave * inverse;
    const float first = max_second(ray->tmin, -RAY_T_LIMIT), last = min_second(ray->tmax, RAY_T_LIMIT);
    const float t0 = max_second(max_second(a[0], a[1]), first), t1 = min_second(min_second(b[0], b[1]), last);
    const float dz = d[2], z0 = t0 * dz, z1 = t1 * dz;
    if (!(ray->tmin <= ray->tmax && t0 <= t1)) return false;
    if (!(max_second(z0, z1) >= f->low - o[2] && min_second(z0, z1) <= f->high - o[2])) return false;
    r->org = r->center = o;
    r->dir = d;
    r->inverse = inverse;
    r->t0 = r->from = t0;
    r->t1 = t1;
    r->up = ~quarter_signs(d) & 3;
    r->special = false;
    return true;
}

/* The ray as refine_hit reads it; its other members are 0, unless it is special. */
CW_INLINE ray_start start_of_one(const one_ray *r, const cw_field *f, const cw_ray *ray) {
    ray_start s = {.dir = {ray->dir[0], ray->dir[1], ray->dir[2]},
                   .base = {ray->org[0], ray->org[1], ray->org[2]},
                   .first = max_second(ray->tmin, -RAY_T_LIMIT),
                   .last = min_second(ray->tmax, RAY_T_LIMIT)};
    if (__builtin_expect(r->special, 0)) ray_init(&s, f, ray);
    return s;
}

/* Where a ray begins: its cell, or an earlier one that it crosses, and its height above a sample of that cell. */
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
    if ((quarter_signs((quarter)inside) & 3) != 3) return false;
    at->i = (int32_t)place[0];
    at->j = (int32_t)place[1];
    at->height = o[2] + way[2] - f->z[(size_t)at->j * f->stride + (size_t)at->i];
    return true;
}

#endif
