/* SPDX-License-Identifier: Apache-2.0 */
/* The strict rules in scalar C: what a ray is to a cell. All kernels, scalar or not, follow these rules operation by
 * operation, so that they agree in every bit; papers/numerics.md derives what the rules guarantee.
 *
 *  1. A border at field coordinate b is crossed at t(b) = (b - org) · (1 / dir), each operation rounded once. t is
 *     monotone in b because rounding is monotone, so the order of crossings along an axis is never wrong.
 *  2. The walk is the staircase that the crossings define: at the border crossed first (x where both are crossed at
 *     once) it goes on to the next cell. Hence a cell is on the walk if and only if it is entered in x no later than
 *     left in y, and entered in y earlier than left in x: a property of ray and cell alone, which any walk can check.
 *  3. The gate: only a cell on the walk, with t-interval [t0, t1] not empty, and in which the ray's heights at t0 and t1
 *     enclose a height between the cell's lowest and highest sample, is tested at all. Heights org + t · dir are
 *     monotone in t as well, so the same comparison on a block of cells can skip the block and never changes a hit.
 *  4. The slab: a walk may begin and end where the ray is strictly beyond the field's lowest and highest sample; the gate
 *     fails there anyway. The t-range itself is cut off a little farther out. No hit is lost; and the heights at the two
 *     ends of a cell's interval, from which the leaf test interpolates, stay of the size of the origin and the field even
 *     if a vertical ray has no ends at all. */
#ifndef CELLWALK_SCALAR_STRICT_H
#define CELLWALK_SCALAR_STRICT_H

#include "field.h"
#include "ray.h"

#include <float.h>
#include <math.h>

/* minps and maxps: the second operand where either is NaN. */
static inline float min_second(float a, float b) { return a < b ? a : b; }
static inline float max_second(float a, float b) { return a > b ? a : b; }

typedef struct strict_axis {
    float org, dir;    /* as given, except that a direction that counts as zero is zero */
    float center;      /* what crossings are measured from: org, or the middle of org's cell if dir is zero */
    float inverse;     /* 1 / dir, +infinity if dir is zero */
    float first, last; /* the field's borders in walk order */
    int step;          /* +1 or -1 */
} strict_axis;

typedef struct strict_ray {
    strict_axis x, y;
    float oz, dz;
    float tmin, tmax;  /* finite */
    float t0, t1;      /* inside the field */
    float begin, end;  /* inside the slab's surroundings too: a cell's interval lies in it */
    float from, until; /* inside the slab: what a walk has to visit */
} strict_ray;

/* A cell on the walk, with its four border crossings. */
typedef struct strict_cell {
    size_t i, j;
    float x_in, x_out, y_in, y_out;
    float t0, t1;
    float h00, h10, h01, h11;
} strict_cell;

static inline float strict_crossing(const strict_axis *a, float border) { return (border - a->center) * a->inverse; }

static inline float strict_height(const strict_ray *r, float t) { return r->oz + t * r->dz; }

/* True if the ray stays clear of every height in [low, high] on [t0, t1]. */
static inline bool strict_clear(const strict_ray *r, float t0, float t1, float low, float high) {
    const float z0 = strict_height(r, t0), z1 = strict_height(r, t1);
    return !(max_second(z0, z1) >= low && min_second(z0, z1) <= high);
}

static inline bool strict_axis_init(strict_axis *a, float org, float dir, size_t samples) {
    const float end = (float)(samples - 1);
    const float inverse = 1.0f / dir;
    a->org = org;
    if (fabsf(inverse) <= FLT_MAX) {
        const bool up = dir >= 0;
        *a = (strict_axis){org, dir, org, inverse, up ? 0 : end, up ? end : 0, up ? 1 : -1};
        return true;
    }
    const float cell = min_second(floorf(org), end - 1);
    *a = (strict_axis){org, 0, cell + 0.5f, INFINITY, 0, end, 1};
    return org >= 0 && org <= end;
}

/* [from, until] cuts [t0, t1] off where it leaves the heights between the field's lowest and highest sample, in which a
 * hole counts for nothing. The computed bound is off by 3u relative, u = 2^-24, and the heights there by at most
 * u (|org| + 2 |z|) (1 + 4u): 4u and 8u make it likely that the height is strictly beyond, FLT_MIN even where numbers are
 * denormal. Whether it is decides, so that nothing cuts off a hit; with dir = 0 it is not.
 *
 * [begin, end] goes on by the size of the origin and the field, so that a leaf test which starts there starts well off the
 * surface: a start within rounding of it would lose touches that are exact. */
static inline void strict_slab(strict_ray *r, const cw_field *f) {
    const float u = FLT_EPSILON / 2, inverse = 1.0f / r->dz, across = fabsf(inverse);
    const bool up = r->dz > 0;
    const float enter = up ? f->low : f->high, leave = up ? f->high : f->low;
    const float a = (enter - r->oz) * inverse, b = (leave - r->oz) * inverse;
    const float oz = fabsf(r->oz) + FLT_MIN;
    const float reach_a = (oz + fabsf(enter)) * across, reach_b = (oz + fabsf(leave)) * across;
    const float s0 = a - ((8 * u) * reach_a + (4 * u) * (fabsf(a) + FLT_MIN));
    const float s1 = b + ((8 * u) * reach_b + (4 * u) * (fabsf(b) + FLT_MIN));
    const float z0 = strict_height(r, s0), z1 = strict_height(r, s1);
    r->from = (up ? z0 < enter : z0 > enter) && s0 > r->t0 ? s0 : r->t0;
    r->until = (up ? z1 > leave : z1 < leave) && s1 < r->t1 ? s1 : r->t1;
    const float span = (f->high - f->low) * across;
    r->begin = max_second(r->from - (reach_a + span), r->t0);
    r->end = min_second(r->until + (reach_b + span), r->t1);
}

/* False if the ray cannot hit: not a ray, or clear of the field's box. */
static inline bool strict_ray_init(strict_ray *r, const cw_field *f, const cw_ray *ray) {
    const float *o = ray->org, *d = ray->dir;
    const float poison = (o[0] * 0 + o[1] * 0) + o[2] * 0;
    if (!(poison == 0 && ray->tmin <= ray->tmax)) return false;
    if (!(ray_direction_counts(d[0]) && ray_direction_counts(d[1]) && ray_direction_counts(d[2]))) return false;
    const bool x = strict_axis_init(&r->x, o[0], d[0], f->nx), y = strict_axis_init(&r->y, o[1], d[1], f->ny);
    r->oz = o[2];
    r->dz = ray_direction(d[2]);
    if (!x || !y || (r->x.dir == 0 && r->y.dir == 0 && r->dz == 0)) return false;
    r->tmin = max_second(ray->tmin, -ray_t_limit());
    r->tmax = min_second(ray->tmax, ray_t_limit());
    r->t0 = max_second(max_second(strict_crossing(&r->x, r->x.first), strict_crossing(&r->y, r->y.first)), r->tmin);
    r->t1 = min_second(min_second(strict_crossing(&r->x, r->x.last), strict_crossing(&r->y, r->y.last)), r->tmax);
    if (!(r->t0 <= r->t1) || strict_clear(r, r->t0, r->t1, f->low, f->high)) return false;
    strict_slab(r, f);
    return true;
}

/* Fills c with cell (i, j) and says whether it passes the gate. */
static inline bool strict_gate(strict_cell *c, const strict_ray *r, const cw_field *f, size_t i, size_t j) {
    const float x_low = (float)i, x_high = (float)(i + 1), y_low = (float)j, y_high = (float)(j + 1);
    c->i = i;
    c->j = j;
    c->x_in = strict_crossing(&r->x, r->x.step > 0 ? x_low : x_high);
    c->x_out = strict_crossing(&r->x, r->x.step > 0 ? x_high : x_low);
    c->y_in = strict_crossing(&r->y, r->y.step > 0 ? y_low : y_high);
    c->y_out = strict_crossing(&r->y, r->y.step > 0 ? y_high : y_low);
    if (!(c->x_in <= c->y_out && c->y_in < c->x_out)) return false;
    c->t0 = max_second(max_second(c->x_in, c->y_in), r->begin);
    c->t1 = min_second(min_second(c->x_out, c->y_out), r->end);
    if (!(c->t0 <= c->t1)) return false;
    const float *row = f->z + j * f->stride + i;
    c->h00 = row[0];
    c->h10 = row[1];
    c->h01 = row[f->stride];
    c->h11 = row[f->stride + 1];
    float low = INFINITY, high = -INFINITY; /* holes drop out: a NaN never compares below or above */
    low = min_second(c->h11, min_second(c->h01, min_second(c->h10, min_second(c->h00, low))));
    high = max_second(c->h11, max_second(c->h01, max_second(c->h10, max_second(c->h00, high))));
    return !strict_clear(r, c->t0, c->t1, low, high);
}

#endif
