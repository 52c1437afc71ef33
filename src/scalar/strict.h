/* SPDX-License-Identifier: Apache-2.0 */
/* The strict rules, in scalar C: which cells a ray visits, and which of them are tested. The kernels cell, packet* and
 * pyramid* follow these rules operation by operation, so that they agree in every bit. papers/numerics.md derives the
 * guarantees.
 *
 *  1. A ray that starts far from the field is moved to it first (ray.h). Then heights are relative to the ray's origin,
 *     and places to the cell. So errors grow with the distance from the origin, not with coordinates.
 *  2. A border at field coordinate b is crossed at t(b) = (b - org) · (1 / dir), each operation rounded once. t is
 *     monotone in b because rounding is monotone, so the order of crossings along an axis is never wrong.
 *  3. The walk is the staircase that the crossings define. At the border crossed first (x if both are crossed at once)
 *     it goes on to the next cell. Hence a cell is on the walk if and only if it is entered in x no later than left in
 *     y, and entered in y earlier than left in x: a property of ray and cell alone, which any walk can check.
 *  4. The gate: a cell is tested only if it is on the walk, its t-interval [t0, t1] is not empty, and the ray's heights
 *     t · dir at t0 and t1 enclose a height between the cell's lowest and highest sample, less the origin's height.
 *     Heights are monotone in t, and differences are monotone in the sample. So the same comparison on a block of cells
 *     can skip the block and never changes a hit.
 *  5. The slab: a walk may begin and end where the ray is strictly beyond the field's lowest and highest sample, as the
 *     gate fails there anyway. A hit of Möller and Trumbore's test may lie beyond these samples by STRICT_ROOM of its
 *     height. For that test the slab is wider, by twice as much. */
#ifndef CELLWALK_SCALAR_STRICT_H
#define CELLWALK_SCALAR_STRICT_H

#include "field.h"
#include "ray.h"

#include <float.h>
#include <math.h>

typedef struct strict_axis {
    float org, dir;    /* as in ray_start */
    float center;      /* the origin of crossings: org, or the middle of org's cell if dir is zero */
    float inverse;     /* 1 / dir, +infinity if dir is zero */
    float first, last; /* the field's borders in walk order */
    int step;          /* +1 or -1 */
} strict_axis;

typedef struct strict_ray {
    strict_axis x, y;
    float oz, dz;
    float t0, t1;      /* over the field, between tmin and tmax: leaf tests clip to it */
    float from, until; /* the range of the walk: these, or less (strict_slab) */
    ray_start start;
} strict_ray;

/* A cell on the walk, with its four border crossings and its samples. */
typedef struct strict_cell {
    size_t i, j;
    float x_in, x_out, y_in, y_out;
    float t0, t1;
    float h00, h10, h01, h11;
} strict_cell;

/* The result of a leaf test: the ray meets the triangle at a t in [t0, t1]. refine.h turns it into a hit. */
typedef struct strict_find {
    float t0, t1;
    bool b; /* triangle B */
} strict_find;

static inline float strict_crossing(const strict_axis *a, float border) { return (border - a->center) * a->inverse; }

/* True if the ray stays clear of every height in [low, high] on [t0, t1]. */
static inline bool strict_clear(const strict_ray *r, float t0, float t1, float low, float high) {
    const float z0 = t0 * r->dz, z1 = t1 * r->dz;
    return !(max_second(z0, z1) >= low - r->oz && min_second(z0, z1) <= high - r->oz);
}

static inline bool strict_axis_init(strict_axis *a, float org, float dir, size_t samples) {
    const float end = (float)(samples - 1);
    if (dir != 0) {
        const bool up = dir > 0;
        *a = (strict_axis){org, dir, org, 1.0f / dir, up ? 0 : end, up ? end : 0, up ? 1 : -1};
        return true;
    }
    const float cell = min_second(floorf(org), end - 1);
    *a = (strict_axis){org, 0, cell + 0.5f, INFINITY, 0, end, 1};
    return org >= 0 && org <= end;
}

/* Room for the rounding of Möller and Trumbore's t: a hit's height may lie this part of itself beyond its cell's
 * lowest and highest sample. Since t may be denormal, the same part of FLT_MIN, and of the ray's rise in so much t,
 * is added. A walk that is cut off by heights has twice as much room, so no hit lies beyond the end of a walk. */
#define STRICT_ROOM 0x1p-19f

/* Room for a height above the ray's origin. */
static inline float strict_room(float height, float dz, float room) {
    return room * (fabsf(height) + FLT_MIN * (1 + fabsf(dz)));
}

/* 8 u of this is a normal float: Intel's CPUs take some 150 cycles for a denormal product. */
#define STRICT_LEAST 0x1p-104f

/* Sets [from, until] to the part of [t0, t1] in which the ray is between the field's lowest and highest sample;
 * holes do not count. The estimate (enter - oz) / dz has an error of 2 u of itself, u = 2^-24, and of 2^-150 if
 * numbers are denormal, and so has a height. It is set back by 8 u of itself, by 2^-125, and by the t in which the
 * ray rises by 2^-125. So it always lies strictly beyond the samples, by no more than the pyramid's slabs have room
 * for (papers/numerics.md). It is used only if the computed height there is beyond, so no hit is cut off; with dz =
 * 0 it is never used. */
static inline void strict_slab(strict_ray *r, const cw_field *f, cw_leaf leaf) {
    const float u = FLT_EPSILON / 2, inverse = 1.0f / r->dz;
    const bool up = r->dz > 0;
    float low = f->low - r->oz, high = f->high - r->oz;
    if (leaf == CW_LEAF_MOLLER_TRUMBORE) {
        low -= strict_room(low, r->dz, 2 * STRICT_ROOM);
        high += strict_room(high, r->dz, 2 * STRICT_ROOM);
    }
    const float enter = up ? low : high, leave = up ? high : low;
    const float a = enter * inverse, b = leave * inverse;
    const float least = STRICT_LEAST * (1 + fabsf(inverse));
    const float s0 = a - (8 * u) * (fabsf(a) + least), s1 = b + (8 * u) * (fabsf(b) + least);
    const float z0 = s0 * r->dz, z1 = s1 * r->dz;
    r->from = (up ? z0 < enter : z0 > enter) && s0 > r->t0 ? s0 : r->t0;
    r->until = (up ? z1 > leave : z1 < leave) && s1 < r->t1 ? s1 : r->t1;
}

/* False if the ray cannot hit: not a ray, or clear of the field's box. */
static inline bool strict_ray_init(strict_ray *r, const cw_field *f, const cw_ray *ray, cw_leaf leaf) {
    ray_start *s = &r->start;
    if (!ray_init(s, f, ray)) return false;
    const bool x = strict_axis_init(&r->x, s->org[0], s->dir[0], f->nx);
    const bool y = strict_axis_init(&r->y, s->org[1], s->dir[1], f->ny);
    if (!x || !y) return false;
    r->oz = s->org[2];
    r->dz = s->dir[2];
    r->t0 = max_second(max_second(strict_crossing(&r->x, r->x.first), strict_crossing(&r->y, r->y.first)), s->tmin);
    r->t1 = min_second(min_second(strict_crossing(&r->x, r->x.last), strict_crossing(&r->y, r->y.last)), s->tmax);
    if (!(r->t0 <= r->t1) || strict_clear(r, r->t0, r->t1, f->low, f->high)) return false;
    strict_slab(r, f, leaf);
    return true;
}

/* The cell's lowest and highest sample. Holes drop out: a NaN never compares below or above. */
static inline float strict_low(const strict_cell *c) {
    return min_second(c->h11, min_second(c->h01, min_second(c->h10, min_second(c->h00, INFINITY))));
}
static inline float strict_high(const strict_cell *c) {
    return max_second(c->h11, max_second(c->h01, max_second(c->h10, max_second(c->h00, -INFINITY))));
}

/* Fills c with cell (i, j); returns whether it passes the gate. */
static inline bool strict_gate(strict_cell *c, const strict_ray *r, const cw_field *f, size_t i, size_t j) {
    const float x_low = (float)i, x_high = (float)(i + 1), y_low = (float)j, y_high = (float)(j + 1);
    c->i = i;
    c->j = j;
    c->x_in = strict_crossing(&r->x, r->x.step > 0 ? x_low : x_high);
    c->x_out = strict_crossing(&r->x, r->x.step > 0 ? x_high : x_low);
    c->y_in = strict_crossing(&r->y, r->y.step > 0 ? y_low : y_high);
    c->y_out = strict_crossing(&r->y, r->y.step > 0 ? y_high : y_low);
    if (!(c->x_in <= c->y_out && c->y_in < c->x_out)) return false;
    c->t0 = max_second(max_second(c->x_in, c->y_in), r->t0);
    c->t1 = min_second(min_second(c->x_out, c->y_out), r->t1);
    if (!(c->t0 <= c->t1)) return false;
    const float *row = f->z + j * f->stride + i;
    c->h00 = row[0];
    c->h10 = row[1];
    c->h01 = row[f->stride];
    c->h11 = row[f->stride + 1];
    return !strict_clear(r, c->t0, c->t1, strict_low(c), strict_high(c));
}

#endif
