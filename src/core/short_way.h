/* SPDX-License-Identifier: Apache-2.0 */
/* A guess whether a ray crosses only a few cells. If so, stepping from cell to cell takes less time than the pyramid, for which a ray must
 * be made ready. A wrong guess changes no answer: the walk stops after about SHORT_TURNS cells, and the pyramid traces the ray. */
#ifndef CELLWALK_CORE_SHORT_WAY_H
#define CELLWALK_CORE_SHORT_WAY_H

#include "pyramid.h"

#include <math.h>

/* Below SHORT_CELLS cells the walk from cell to cell was measured to be faster. */
enum { SHORT_CELLS = 32, SHORT_TURNS = 40 };

/* True if a ray leaves the field's samples along an axis, or has left them, within so many cells; speed is in cells per t. */
static inline bool short_leaves(float org, float dir, float low, float high, float tmin, float speed) {
    const float left = dir < 0 ? org - low : high - org, fast = fabsf(dir);
    return (left - tmin * fast) * speed <= SHORT_CELLS * fast;
}

/* True if it ends, or leaves the field's box, within some cells. Without a division, as it is part of every call of one ray. */
static inline bool short_in_box(const cw_field *f, const cw_ray *r, float speed) {
    const float zero = 0;
    return (r->tmax - r->tmin) * speed <= SHORT_CELLS ||
           short_leaves(r->org[2], r->dir[2], f->low, f->high, r->tmin, speed) ||
           short_leaves(r->org[0], r->dir[0], zero, (float)(f->nx - 1), r->tmin, speed) ||
           short_leaves(r->org[1], r->dir[1], zero, (float)(f->ny - 1), r->tmin, speed);
}

/* True if within SHORT_CELLS cells it comes below the slab of the 16 × 16 cells that it starts above. It has then met the ground, unless
 * it has left these cells and the ground falls away there. Rejected: the plane of the three nearest samples, which is more often in the
 * cache but more often wrong (papers/walks.md). */
static inline bool short_over_slab(const cw_field *f, const cw_ray *r, float speed) {
    const struct cw_pyramid *p = f->pyramid;
    const int level = p->levels > 1 ? 1 : 0, shift = 2 * level + 2;
    const float x = r->org[0] + r->tmin * r->dir[0], y = r->org[1] + r->tmin * r->dir[1];
    if (!(x >= 0 && x < (float)(f->nx - 1) && y >= 0 && y < (float)(f->ny - 1))) return false;
    const size_t i = (size_t)x >> shift, j = (size_t)y >> shift, half = (size_t)1 << (shift - 1);
    const cw_pyramid_slab *s = &p->slab[(size_t)p->first[level + 1] + j * cw_pyramid_across(f, level) + i];
    const float z = r->org[2] + r->tmin * r->dir[2] - s->slope_x * (x - (float)((i << shift) + half)) -
                    s->slope_y * (y - (float)((j << shift) + half));
    const float fall = s->slope_x * r->dir[0] + s->slope_y * r->dir[1] - r->dir[2];
    return z >= s->low && (z - s->low) * speed <= SHORT_CELLS * fall;
}

static inline float short_speed(const cw_ray *r) { return fabsf(r->dir[0]) + fabsf(r->dir[1]); }

#endif
