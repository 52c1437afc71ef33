/* SPDX-License-Identifier: Apache-2.0 */
/* The checks and limits of rays that include/cellwalk.h promises, and the origin from which the library traces a
 * ray.
 *
 * A ray that starts far from the field is *moved*: its origin goes along it to just before the field's box, and the
 * ray is traced from there. t is counted from the new origin and shifted back at the end. Otherwise each product t ·
 * dir would be as large as the distance, and its rounding error as large as cells.
 *
 * The move is nearly exact. shift is a float, so shift · dir is exact in double. It nearly cancels the origin, so
 * their sum is exact too (Sterbenz 1974) or off by 2^-53 of the field's size. One step brings the origin nearer by a
 * factor of 2^22, since shift has 24 bits. A second one is needed from some million field lengths away.
 *
 * The one loss is that the new origin is rounded to float. If a slightly shorter step of few bits needs no rounding,
 * it is taken instead. So rays of few bits touch exactly the same vertices and edges as from their own origins. */
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

/* Each step brings the origin nearer by 2^22: from the largest float to the smallest field in seven. */
enum { RAY_MOVES = 8 };

/* A direction component whose reciprocal overflows counts as zero. */
static inline float ray_direction(float d) { return fabsf(1.0f / d) <= FLT_MAX ? d : 0; }

/* False if d is so large that its reciprocal is denormal, or infinite, or NaN. */
static inline bool ray_direction_counts(float d) { return fabsf(1.0f / d) >= FLT_MIN; }

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

/* Part of the ray's length in the box by which a step of few bits may be shorter than another. */
#define RAY_STEP_ROOM 0x1p-5

/* A step to just before in, rounded to a multiple of a power of 2 of at most room; it may not be exact. */
static inline double ray_even_step(double in, double room) {
    const double even = room * 0x1p52; /* its last place is that power */
    return ((in - room) + even) - even;
}

/* Distance of a number from the nearest float. */
static inline double ray_not_float(double a) { return fabs((double)(float)a - a); }

/* True if each component has at most 12 significant bits. With more, products with a step are hardly ever floats. */
static inline bool ray_has_few_bits(const float d[3]) {
    bool few = true;
    for (int c = 0; c < 3; c++) {
        const float up = d[c] * 0x1.001p12f;
        few = few && up - (up - d[c]) == d[c];
    }
    return few;
}

/* True if the step is a float, and the new origin too. */
static inline bool ray_step_is_exact(const ray_start *r, double step) {
    double lost = ray_not_float(step);
    for (int c = 0; c < 3; c++) {
        const double way = step * (double)r->dir[c], base = r->base[c] + way;
        lost += (fabs((base - r->base[c]) - way) + fabs((base - way) - r->base[c])) + ray_not_float(base);
    }
    return lost == 0;
}

/* Moves the origin towards the field's box; false if the ray misses the box. */
static inline bool ray_move(ray_start *r, const cw_field *f) {
    const double low[3] = {0, 0, f->low}, high[3] = {(double)(f->nx - 1), (double)(f->ny - 1), f->high};
    for (int k = 0; k < RAY_MOVES && ray_is_far(f, r->org); k++) {
        double in = -INFINITY, out = INFINITY;
        for (int c = 0; c < 3; c++) {
            const double d = r->dir[c], a = (low[c] - r->base[c]) / d, b = (high[c] - r->base[c]) / d;
            if (d == 0 && (r->base[c] < low[c] || r->base[c] > high[c])) return false;
            in = max_second_d(d == 0 ? -INFINITY : min_second_d(a, b), in);
            out = min_second_d(d == 0 ? INFINITY : max_second_d(a, b), out);
        }
        /* Quotients are off by at most 2^-52 of themselves. If in exceeds out by more, the ray misses the box. */
        if (in - out > 0x1p-50 * max_second_d(fabs(in), fabs(out))) return false;
        if (fabs(in) > (double)RAY_T_LIMIT) return false;
        /* A little early, so that the ray has positive t in the box in spite of rounding. */
        double step = (double)(float)(in - fabs(in) * 0x1p-22);
        if (ray_has_few_bits(r->dir)) {
            const double even = ray_even_step(in, RAY_STEP_ROOM * (out - in));
            if (ray_step_is_exact(r, even)) step = even;
        }
        r->shift += step;
        for (int c = 0; c < 3; c++) {
            r->base[c] += step * (double)r->dir[c];
            r->org[c] = (float)r->base[c];
        }
    }
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
    r->tmin = max_second((float)((double)r->tmin - r->shift), -RAY_T_LIMIT);
    r->tmax = min_second((float)((double)r->tmax - r->shift), RAY_T_LIMIT);
    return true;
}

/* t of the caller's ray at t of the traced ray. The ends of a moved ray's range are rounded, so t is clamped to the
 * caller's range. A t within it does not change, not even -0. */
static inline float ray_t(const ray_start *r, double t) {
    return min_second(r->last, max_second(r->first, (float)(r->shift + t)));
}

static inline cw_hit miss(void) { return (cw_hit){.t = INFINITY, .i = -1, .j = -1}; }

#endif
