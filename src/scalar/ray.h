/* SPDX-License-Identifier: Apache-2.0 */
/* The checks and limits of rays that include/cellwalk.h promises, and the origin from which the library traces a
 * ray.
 *
 * A ray that starts far from the field is *moved*: its origin goes along it to just before the field's box, and the
 * ray is traced from there. t is counted from the new origin and shifted back at the end. Otherwise each product t ·
 * dir would be as large as the distance, and its rounding error as large as cells.
 *
 * The move is nearly exact. shift is a float, so shift · dir is exact in double. It nearly cancels the origin, so
 * their sum is exact too (Sterbenz 1974) or off by 2^-53 of the field's size. So the entry into the box need not be
 * known better than to a float. One step brings the origin nearer by a factor of 2^20. A second one is needed from some
 * hundred thousand field lengths away.
 *
 * The one loss is that the new origin is rounded to float. */
#ifndef CELLWALK_SCALAR_RAY_H
#define CELLWALK_SCALAR_RAY_H

#include "field.h"

#include <float.h>
#include <math.h>

/* minps and maxps: the second operand where either is NaN. */
static inline float min_second(float a, float b) { return a < b ? a : b; }
static inline float max_second(float a, float b) { return a > b ? a : b; }
static inline double min_second_d(double a, double b) { return a < b ? a : b; }
static inline double max_second_d(double a, double b) { return a > b ? a : b; }

/* t is clamped to plus or minus this: half the largest float, so that the length of a t-range is a float too. */
#define RAY_T_LIMIT (FLT_MAX / 2)

/* Each step brings the origin nearer by 2^20: from the largest float to a cell in seven. */
enum { RAY_MOVES = 8 };

/* A direction component whose reciprocal overflows counts as zero. */
static inline float ray_direction(float d) { return fabsf(d) > 0x1p-128f ? d : 0; }

/* False if d is so large that its reciprocal is denormal, or infinite, or NaN. */
static inline bool ray_direction_counts(float d) { return fabsf(d) <= 0x1p126f; }

/* A ray as the library traces it. */
typedef struct ray_start {
    float org[3], dir[3];
    float tmin, tmax;  /* finite, counted from org; rounded if the ray was moved */
    float first, last; /* the caller's tmin and tmax, finite */
    double base[3];    /* org before it was rounded to float */
    double shift;      /* t of the caller's ray at org */
} ray_start;

static inline bool ray_is_far(const cw_field *f, const float org[3]) {
    return fabsf(org[0] - f->middle[0]) > f->reach[0] || fabsf(org[1] - f->middle[1]) > f->reach[1] ||
           fabsf(org[2] - f->middle[2]) > f->reach[2];
}

/* Entry into the field's box and exit are computed in float: three operations, so they are off by 3 u of themselves,
 * u = 2^-24, and by 2^-150 if they are denormal. A ray misses the box if its entry comes after its exit by this part
 * of them, 8 u, and of FLT_MIN. By the same part its new origin is before the entry, so that its t in the box is
 * positive in spite of rounding. */
#define RAY_BOX_ROOM 0x1p-21f

/* A ray that enters the box later, or leaves it earlier than minus this, is not in it within RAY_T_LIMIT. One that
 * enters it earlier than minus this is moved into the box, to a place before its range of t. */
#define RAY_FARTHEST (1.5f * RAY_T_LIMIT)

/* Moves the origin towards the field's box; false if the ray misses the box. */
static inline bool ray_move(ray_start *r, const cw_field *f) {
    const float low[3] = {0, 0, f->low}, high[3] = {(float)(f->nx - 1), (float)(f->ny - 1), f->high};
    double first = (double)r->first, last = (double)r->last;
    for (int k = 0; k < RAY_MOVES && ray_is_far(f, r->org); k++) {
        float in = -INFINITY, out = INFINITY;
        for (int c = 0; c < 3; c++) {
            const float to_low = (float)((double)low[c] - r->base[c]), to_high = (float)((double)high[c] - r->base[c]);
            const float inverse = 1 / r->dir[c], a = to_low * inverse, b = to_high * inverse;
            const bool stands = r->dir[c] == 0;
            if (stands && (to_low > 0 || to_high < 0)) return false;
            in = max_second(stands ? -INFINITY : min_second(a, b), in);
            out = min_second(stands ? INFINITY : max_second(a, b), out);
        }
        if (in - out > (max_second(fabsf(in), fabsf(out)) + FLT_MIN) * RAY_BOX_ROOM) return false;
        if (in > RAY_FARTHEST || out < -RAY_FARTHEST) return false;
        in = max_second(in, -RAY_FARTHEST);
        const float step = in - (fabsf(in) + FLT_MIN) * RAY_BOX_ROOM;
        r->shift += (double)step;
        first -= (double)step; /* not less shift, whose sum is rounded from the third step on */
        last -= (double)step;
        for (int c = 0; c < 3; c++) {
            r->base[c] += (double)step * (double)r->dir[c];
            r->org[c] = (float)r->base[c];
        }
    }
    r->tmin = max_second((float)first, -RAY_T_LIMIT);
    r->tmax = min_second((float)last, RAY_T_LIMIT);
    return true;
}

/* False if the ray would miss any field, or starts far away and misses this one's box. */
static inline bool ray_init(ray_start *r, const cw_field *f, const cw_ray *ray) {
    const float *o = ray->org, *d = ray->dir;
    const float poison = (o[0] * 0 + o[1] * 0) + o[2] * 0;
    if (!(poison == 0 && ray->tmin <= ray->tmax)) return false;
    if (!(ray_direction_counts(d[0]) && ray_direction_counts(d[1]) && ray_direction_counts(d[2]))) return false;
    *r = (ray_start){
        .org = {o[0], o[1], o[2]},
        .dir = {ray_direction(d[0]), ray_direction(d[1]), ray_direction(d[2])},
        .first = max_second(ray->tmin, -RAY_T_LIMIT),
        .last = min_second(ray->tmax, RAY_T_LIMIT),
        .base = {o[0], o[1], o[2]},
    };
    r->tmin = r->first;
    r->tmax = r->last;
    if (r->dir[0] == 0 && r->dir[1] == 0 && r->dir[2] == 0) return false;
    if (!ray_is_far(f, r->org)) return true;
    ray_start moved = *r; /* a copy, so that near rays stay in registers */
    if (!ray_move(&moved, f)) return false;
    *r = moved;
    return true;
}

/* t of the caller's ray at t of the traced ray. The ends of a moved ray's range are rounded, so t is clamped to the
 * caller's range. A t within it does not change, not even -0. */
static inline float ray_t(const ray_start *r, double t) {
    return min_second(r->last, max_second(r->first, (float)(r->shift + t)));
}

static inline cw_hit miss(void) { return (cw_hit){.t = INFINITY, .i = -1, .j = -1}; }

#endif
