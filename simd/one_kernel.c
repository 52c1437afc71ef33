/* SPDX-License-Identifier: Apache-2.0 */
/* One ray over the pyramid, for calls of few rays, and for rays that keep a lane for long (lane_walk.h). Lanes are places: the
 * 16 children of a node, or the 16 cells of a block, are tested at once (children.h), by the gate's own operations. So a level
 * costs one chain of operations and one branch that is hard to foretell.
 *
 * The walk opens a node: it finds the children that the ray meets. It goes down into the nearest, and up when none is left. If
 * the ray begins near the ground, the walk begins at its block: mostly no node above need be opened, and those that must be do
 * not depend on each other. Else it begins at the top.
 *
 * A ray that opens many nodes runs beside a surface as a rule, nearer than bounds can tell. Then nodes are also judged by
 * slabs, in double, which are wider than their samples only by what the leaf test's own rounding needs this far from the ray's
 * origin.
 *
 * Invariant: at each level what the ray meets is opened from front to back, and all before the first node opened is behind the
 * ray, so the first cell found is the first one hit. A slab passes over a node only if the leaf test's sign is strict on all of
 * it; papers/numerics.md derives how wide it has to be for that. Rejected: slabs for each ray, which take longer than the nodes
 * that they save; all lanes on the columns of a ray that is beside a surface (papers/walks.md). */

#include "../src/scalar/refine.h"
#include "children.h"
#include "kernels.h"
#include "lane_queue.h"
#include "one_ray.h"
#include "pyramid.h"
#include "vector_watertight.h"

#include <float.h>
#include <string.h>

/* Rays that begin less than LOW_HEIGHT above the ground begin their walk at their block; after OPENS nodes slabs judge them too: measured
 * (papers/walks.md). */
enum { SOON_CELLS = 8, LOW_HEIGHT = 8, OPENS = 48 };

/* The find of a leaf test in cell (i, j): see strict_find. */
typedef struct one_find {
    int32_t i, j;
    float t0, t1;
    bool b;
} one_find;

/* The children of a node in lanes k W and on. */
typedef struct one_children {
    vfloat x, y; /* low corners, mirrored */
    vfloat x_in, y_in, x_out, y_out;
} one_children;

/* The ray's crossings in all lanes, mirrored so that it goes up along both axes, which no operation rounds differently. */
typedef struct one_lanes {
    vfloat center[2], inverse[2];
    bool up_x, up_y;
} one_lanes;

/* Of node (x, y), whose children have that side. Whole numbers, which nothing rounds. */
CW_INLINE one_children children_of(const one_lanes *a, int32_t x, int32_t y, float side, size_t k) {
    one_children c;
    const vfloat s = vf_set(side);
    /* 4 · number XOR this is the mirrored number of the first child in walk order. */
    const int32_t mirror_x = a->up_x ? 0 : ~3, mirror_y = a->up_y ? 0 : ~3;
    c.x = vf_mul(vf_add(vf_set((float)(4 * x ^ mirror_x)), vf_load(lane_x[a->up_x] + k * COLUMNS_STEP)), s);
    c.y = vf_mul(vf_add(vf_set((float)(4 * y ^ mirror_y)), vf_load(lane_y + k * W)), s);
    c.x_in = vf_mul(vf_sub(c.x, a->center[0]), a->inverse[0]);
    c.y_in = vf_mul(vf_sub(c.y, a->center[1]), a->inverse[1]);
    c.x_out = vf_mul(vf_sub(vf_add(c.x, s), a->center[0]), a->inverse[0]);
    c.y_out = vf_mul(vf_sub(vf_add(c.y, s), a->center[1]), a->inverse[1]);
    return c;
}

/* The children of node (x, y) that the ray meets. */
CW_INLINE unsigned open_node(const one_lanes *a, const vray *r, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    const float *row = first_row(a->up_y, brick, 4);
    const ptrdiff_t step = row_step(a->up_y, 4);
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++) {
        const one_children c = children_of(a, x, y, l->side, k);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const vmask m = meets(r, t0, t1, vf_load_block(row, step, k), vf_load_block(row + 16, step, k));
        mask |= vm_bits(vm_and(vf_le(t0, t1), m)) << (k * W);
    }
    return in_walk_order(mask, a->up_x);
}

/* Tests the cells of block (x, y). */
static inline bool test_block(const one_lanes *a, const vray *r, const cw_field *f, int32_t x, int32_t y,
                              one_find *found) {
    block_samples s;
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    const float *row = first_row(a->up_y, s.z, s.stride);
    const ptrdiff_t step = row_step(a->up_y, s.stride);
    for (size_t n = 0; n < CHILD_VECTORS; n++) {
        const size_t k = W == 1 && !a->up_x ? n ^ 3 : n; /* front to back */
        const one_children at = children_of(a, x, y, 1, k);
        vcell c;
        c.x_in = at.x_in, c.y_in = at.y_in, c.x_out = at.x_out, c.y_out = at.y_out;
        c.t0 = vf_max(vf_max(c.x_in, c.y_in), r->t0);
        c.t1 = vf_min(vf_min(c.x_out, c.y_out), r->t1);
        c.h00 = vf_load_block(row, step, k);
        c.h10 = vf_load_block(row + 1, step, k);
        c.h01 = vf_load_block(row + s.stride, step, k);
        c.h11 = vf_load_block(row + s.stride + 1, step, k);
        const vmask gate = cell_gate(r, &c);
        if (!vm_any(gate)) continue;
        /* Low corners in the field: the mirrored high ones with the other sign. */
        const vfloat one = vf_set(1);
        c.i = a->up_x ? at.x : vf_sub(vf_sub(vf_set(0), at.x), one);
        c.j = a->up_y ? at.y : vf_sub(vf_sub(vf_set(0), at.y), one);
        vfind find;
        const unsigned hits = in_walk_order(vm_bits(wt_cell_in(r, &c, gate, &find)), a->up_x);
        if (hits == 0) continue;
        const int lane = __builtin_ctz(hits) ^ flip(a->up_x), place = lane + (int)k * W;
        found->t0 = vf_lane(&find.t0, (unsigned)lane);
        found->t1 = vf_lane(&find.t1, (unsigned)lane);
        found->b = vm_bits(find.b) >> lane & 1;
        found->i = 4 * x + (place & 3);
        found->j = 4 * y + ((place >> 2) ^ flip(a->up_y));
        return true;
    }
    return false;
}

/* True if the ray hits nothing in node (x, y) of a level. */
static inline bool slab_misses(const strict_ray *r, const cw_field *f, int level, int32_t x, int32_t y) {
    const struct cw_pyramid *p = f->pyramid;
    const int32_t side = (int32_t)4 << 2 * level;
    const cw_pyramid_slab *s =
        &p->slab[(size_t)p->first[level + 1] + (size_t)y * cw_pyramid_across(f, level) + (size_t)x];
    const float *bounds = cw_pyramid_node(&p->level[level], (size_t)x, (size_t)y);
    if (!(s->low <= s->high)) return true;
    const int32_t corner[2] = {x * side, y * side};
    const strict_axis *const axis[2] = {&r->x, &r->y};
    float t0 = r->from, t1 = r->until;
    for (int c = 0; c < 2; c++) {
        const bool up = axis[c]->step > 0;
        t0 = max_second(t0, strict_crossing(axis[c], (float)(corner[c] + (up ? 0 : side))));
        t1 = min_second(t1, strict_crossing(axis[c], (float)(corner[c] + (up ? side : 0))));
    }
    const double u = (double)(FLT_EPSILON / 2), low = (double)s->low, high = (double)s->high, half = 0.5 * side;
    const double oz = (double)r->oz, dz = (double)r->dz, a = (double)s->slope_x, b = (double)s->slope_y;
    const double dx = (double)r->x.dir, dy = (double)r->y.dir;
    const double px = (double)r->x.org - (corner[0] + half), py = (double)r->y.org - (corner[1] + half);
    const double steep = fabs(a) + fabs(b), sigma = steep + (high - low),
                 absolute = max_second_d(fabs(low), fabs(high));
    /* Slabs with a slope have been set outward for rays from anywhere (cw_slab_outward). That is taken back, and replaced by
     * the width that this ray needs here. */
    const double k = (double)SLAB_ROUNDING * 2 * (double)(f->nx + f->ny);
    const double wide = steep > 0 ? k / (1 + 2 * k) * (1 - 0x1p-20) * max_second_d(0, sigma - 2 * u * absolute) : 0;
    const double away = fabs(px) + fabs(py) + 2 * half + 2;
    const double heights = max_second_d(fabs((double)bounds[0] - oz), fabs((double)bounds[16] - oz));
    const double least = (double)FLT_MIN * (1 + fabs((double)t0) + fabs((double)t1) +
                                            0x1p-14 * (fabs(dz) + sigma * (fabs(dx) + fabs(dy))));
    const double pad = 1.001 * u * (sigma * (8 * away + 2 * side) + 4 * (heights + absolute)) + least - wide;
    const double o = oz - (a * px + b * py), rate = dz - (a * dx + b * dy);
    const double d0 = o + (double)t0 * rate, d1 = o + (double)t1 * rate;
    return min_second_d(d0, d1) > high + pad || max_second_d(d0, d1) < low - pad;
}

/* late: from t on, from the top, with slabs from the first node on. */
static __attribute__((noinline)) bool walk_one(const cw_field *f, const cw_ray *ray, bool late, float t,
                                               strict_ray *one, one_find *found) {
    const struct cw_pyramid *p = f->pyramid;
    if (!init_one_ray(one, f, ray)) return false;
    if (late) one->from = max_second(t, one->from);
    one_lanes a = {.up_x = one->x.step > 0, .up_y = one->y.step > 0};
    const strict_axis *const axis[2] = {&one->x, &one->y};
    for (int c = 0; c < 2; c++) {
        a.center[c] = vf_set((float)axis[c]->step * axis[c]->center);
        a.inverse[c] = vf_set(fabsf(axis[c]->inverse));
    }
    vray r;
    r.x.org = vf_set(one->x.org), r.x.dir = vf_set(one->x.dir), r.x.up = vm_set(a.up_x);
    r.y.org = vf_set(one->y.org), r.y.dir = vf_set(one->y.dir), r.y.up = vm_set(a.up_y);
    r.oz = vf_set(one->oz), r.dz = vf_set(one->dz);
    r.t0 = vf_set(one->t0), r.t1 = vf_set(one->t1), r.from = vf_set(one->from), r.until = vf_set(one->until);
    const int flip_x = flip(a.up_x), flip_y = flip(a.up_y);
    unsigned mask = 0, done = 0, todo[PYRAMID_LEVELS_MAX];
    int level = p->levels - 1, left = late ? 0 : OPENS; /* -1: cells */
    int32_t x = 0, y = 0;
    if (!late) {
        const int32_t i = cell_at(&one->x, one->from, f->nx), j = cell_at(&one->y, one->from, f->ny);
        const float height = one->from * one->dz - (f->z[(size_t)j * f->stride + (size_t)i] - one->oz);
        if (fabsf(height) <= LOW_HEIGHT) level = -1, x = i >> 2, y = j >> 2;
    }
    int top = level;
    for (;;) {
        if (level < 0) {
            if (test_block(&a, &r, f, x, y, found)) return true;
            mask = 0;
        } else {
            const bool judged = left == 0 && level + 1 < p->levels;
            mask =
                judged && slab_misses(one, f, level + 1, x, y) ? 0 : open_node(&a, &r, &p->level[level], x, y) & ~done;
            done = 0;
        }
        while (mask == 0) {
            if (++level == p->levels) return false;
            const int own = ((y & 3) ^ flip_y) << 2 | ((x & 3) ^ flip_x);
            x >>= 2;
            y >>= 2;
            if (level > top) {
                top = level;
                done = 1u << own;
                break;
            }
            mask = todo[level];
        }
        if (mask == 0) continue;
        left -= left > 0;
        const int32_t place = __builtin_ctz(mask);
        todo[level--] = mask & (mask - 1);
        x = 4 * x + ((place & 3) ^ flip_x);
        y = 4 * y + ((place >> 2) ^ flip_y);
    }
}

/* True if the ray begins within the field and seems to fall to the ground within SOON_CELLS cells. */
static inline bool falls_soon(const cw_field *f, const cw_ray *ray) {
    const float *o = ray->org, *d = ray->dir;
    if (!(d[2] < 0)) return false;
    const float x = o[0] + ray->tmin * d[0], y = o[1] + ray->tmin * d[1];
    if (!(x >= 0 && x < (float)(f->nx - 1) && y >= 0 && y < (float)(f->ny - 1))) return false;
    const size_t i = (size_t)x, j = (size_t)y,
                 next = d[1] > 0 ? j + 2 : j - 1; /* below 0 it wraps, beyond every field */
    const float *z = f->z + j * f->stride + i, height = o[2] + ray->tmin * d[2] - *z;
    if (!(height >= 0 && height * (fabsf(d[0]) + fabsf(d[1])) <= SOON_CELLS * -d[2])) return false;
    /* The rows that it may need: or their loads would wait for the first one's. */
    __builtin_prefetch(z + f->stride);
    if (next < f->ny) __builtin_prefetch(f->z + next * f->stride + i);
    return true;
}

/* cw_one1, cw_one4, cw_one8 or cw_one16. */
void CW_CODE(one)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        one_find at;
        strict_ray one;
        cw_hit *const hit = hits ? &hits[k] : NULL;
        uint8_t *const blocked = hits ? NULL : &occluded[k];
        if (falls_soon(f, &rays[k]) && cw_cell_few(f, &rays[k], SOON_CELLS, hit, blocked)) continue;
        if (W == 1) { /* faster in plain C */
            cw_pyramid1.trace[CW_LEAF_WATERTIGHT](f, &rays[k], 1, hit, blocked);
            continue;
        }
        const bool found = walk_one(f, &rays[k], false, 0, &one, &at);
        if (hits == NULL) {
            occluded[k] = found;
        } else if (found) {
            const float *row = f->z + (size_t)at.j * f->stride + (size_t)at.i;
            const strict_cell c = {.i = (size_t)at.i,
                                   .j = (size_t)at.j,
                                   .h00 = row[0],
                                   .h10 = row[1],
                                   .h01 = row[f->stride],
                                   .h11 = row[f->stride + 1]};
            hits[k] = refine_hit(&one.start, &c, &(strict_find){at.t0, at.t1, at.b});
        } else { /* not by miss(), which compilers make elsewhere and copy */
            hits[k].t = INFINITY;
            hits[k].i = hits[k].j = -1;
            hits[k].triangle = 0;
            hits[k].u = hits[k].v = 0;
        }
    }
}

bool CW_CODE(one_late)(const cw_field *f, const cw_ray *ray, float t, float find[FOUND_NUMBERS]) {
    one_find at;
    strict_ray one;
    if (!walk_one(f, ray, true, t, &one, &at)) return false;
    const float *row = f->z + (size_t)at.j * f->stride + (size_t)at.i, *corner = at.b ? row + f->stride : row + 1;
    const float numbers[FOUND_NUMBERS] = {at.t0,  at.t1,   (float)at.i,        (float)at.j,
                                          row[0], *corner, row[f->stride + 1], at.b ? 1 : 0};
    memcpy(find, numbers, sizeof numbers);
    return true;
}
