/* SPDX-License-Identifier: Apache-2.0 */
/* One ray over the pyramid, for calls of few rays, and for rays that keep a lane for long (lane_walk.h). Lanes are places: the
 * 16 children of a node, or the 16 cells of a block, are tested at once (children.h), by the gate's own operations. So a level
 * costs one chain of operations and one branch that is hard to foretell.
 *
 * The walk opens a node: it finds the children that the ray meets. It goes down into the nearest, and up when none is left. If
 * the ray begins near the ground, the walk begins at its block: mostly no node above need be opened, and those that must be do
 * not depend on each other. Else it begins at the top, as do rays that enter the field from outside.
 *
 * A ray that opens many nodes runs beside a surface as a rule, nearer than bounds can tell. Then nodes are also judged by
 * slabs, in double, which are wider than their samples only by what the leaf test's own rounding needs this far from the ray's
 * origin.
 *
 * Invariant: at each level what the ray meets is opened from front to back, and all before the first node opened is behind the
 * ray, so the first cell found is the first one hit. A slab passes over a node only if the leaf test's sign is strict on all of
 * it; papers/numerics.md derives how wide it has to be for that. Rejected: slabs for each ray, which take longer than the nodes
 * that they save; all lanes on the columns of a ray that is beside a surface; lanes in walk order, crossings of children carried
 * down, or computed a level ahead (papers/walks.md). */

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

/* Crossings with the borders of node (x, y)'s children, which have that side, in lanes k W and on. Borders are whole numbers, which
 * nothing rounds. */
CW_INLINE void cross_children(const vray *r, quadrant q, int32_t x, int32_t y, float side, size_t k, vcell *c) {
    const vfloat s = vf_set(side), low_x = vf_set((float)(4 * x) * side), low_y = vf_set((float)(4 * y) * side);
    const size_t column = k * COLUMNS_STEP, row = k * W;
    c->x_in = crossing(&r->x, vf_add(low_x, vf_mul(vf_load(lane_x[!q.up_x] + column), s)));
    c->y_in = crossing(&r->y, vf_add(low_y, vf_mul(vf_load(lane_y[!q.up_y] + row), s)));
    c->x_out = crossing(&r->x, vf_add(low_x, vf_mul(vf_load(lane_x[q.up_x] + column), s)));
    c->y_out = crossing(&r->y, vf_add(low_y, vf_mul(vf_load(lane_y[q.up_y] + row), s)));
}

/* The children of node (x, y) that the ray meets, in walk order. */
CW_INLINE unsigned open_node(const vray *r, quadrant q, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++) {
        vcell c;
        cross_children(r, q, x, y, l->side, k, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const vfloat z0 = vf_mul(t0, r->dz), z1 = vf_mul(t1, r->dz);
        const vfloat low = above_origin(r, vf_load(brick + k * W));
        const vfloat high = above_origin(r, vf_load(brick + CHILDREN + k * W));
        /* meets, whose second comparison would wait for the first */
        const vmask here = vm_and(vf_le(t0, t1), vf_ge(vf_max(z0, z1), low));
        mask |= (vm_bits(here) & vm_bits(vf_le(vf_min(z0, z1), high))) << (k * W);
    }
    return in_walk_order(mask, q);
}

/* Tests the cells of block (x, y). */
static inline bool test_block(const vray *r, quadrant q, const cw_field *f, int32_t x, int32_t y, one_find *found) {
    block_samples s;
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    const ptrdiff_t step = (ptrdiff_t)s.stride;
    for (size_t n = 0; n < CHILD_VECTORS; n++) {
        size_t k = q.up_y ? n : CHILD_VECTORS - 1 - n; /* front to back */
        if (W == 1) k ^= (size_t)turn(q);
        vcell c;
        cross_children(r, q, x, y, 1, k, &c);
        clip_cell(&c, r);
        c.h00 = vf_load_block(s.z, step, k);
        c.h10 = vf_load_block(s.z + 1, step, k);
        c.h01 = vf_load_block(s.z + step, step, k);
        c.h11 = vf_load_block(s.z + step + 1, step, k);
        const vmask gate = cell_gate(r, &c);
        if (!vm_any(gate)) continue;
        c.i = vf_add(vf_set((float)(4 * x)), vf_load(lane_x[0] + k * COLUMNS_STEP));
        c.j = vf_add(vf_set((float)(4 * y)), vf_load(lane_y[0] + k * W));
        vfind find;
        const unsigned hits = vm_bits(wt_cell_in(r, &c, gate, &find));
        if (hits == 0) continue;
        const int lane = nearest(in_walk_order(hits, q), q) ^ turn(q), place = lane + (int)k * W;
        found->t0 = vf_lane(&find.t0, (unsigned)lane);
        found->t1 = vf_lane(&find.t1, (unsigned)lane);
        found->b = vm_bits(find.b) >> lane & 1;
        found->i = 4 * x + (place & 3);
        found->j = 4 * y + (place >> 2);
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

/* From start on, or from the top if that is NULL. late: from t on, with slabs from the first node on. */
static __attribute__((noinline)) bool walk_one(const cw_field *f, const cw_ray *ray, const one_start *start, bool late,
                                               float t, strict_ray *one, one_find *found) {
    const struct cw_pyramid *p = f->pyramid;
    if (!init_one_ray(one, f, ray)) return false;
    if (late) one->from = max_second(t, one->from);
    const quadrant q = {one->x.step > 0, one->y.step > 0};
    vray r;
    r.x.org = vf_set(one->x.org), r.x.dir = vf_set(one->x.dir), r.x.up = vm_set(q.up_x);
    r.y.org = vf_set(one->y.org), r.y.dir = vf_set(one->y.dir), r.y.up = vm_set(q.up_y);
    r.x.center = vf_set(one->x.center), r.x.inverse = vf_set(one->x.inverse);
    r.y.center = vf_set(one->y.center), r.y.inverse = vf_set(one->y.inverse);
    r.oz = vf_set(one->oz), r.dz = vf_set(one->dz);
    r.t0 = vf_set(one->t0), r.t1 = vf_set(one->t1), r.from = vf_set(one->from), r.until = vf_set(one->until);
    unsigned mask = 0, keep = ~0u, todo[PYRAMID_LEVELS_MAX];
    int level = p->levels - 1, opened = late ? OPENS : 0; /* level -1: cells */
    int32_t x = 0, y = 0;
    if (start) level = -1, x = start->i >> 2, y = start->j >> 2;
    int top = level;
    for (;;) {
        if (level < 0) {
            if (test_block(&r, q, f, x, y, found)) return true;
            mask = 0;
        } else {
            const bool judged = __builtin_expect(opened >= OPENS, 0) && level + 1 < p->levels;
            mask = judged && slab_misses(one, f, level + 1, x, y) ? 0 : open_node(&r, q, &p->level[level], x, y) & keep;
            keep = ~0u;
        }
        while (mask == 0) {
            if (++level == p->levels) return false;
            const int own = ((y & 3) << 2 | (x & 3)) ^ turn(q);
            x >>= 2;
            y >>= 2;
            if (level > top) {
                top = level;
                keep = ~(1u << own); /* rejected: what to take off, for which GCC uses mask registers */
                break;
            }
            mask = todo[level];
        }
        if (mask == 0) continue;
        opened++;
        const int32_t place = nearest(mask, q), child = place ^ turn(q);
        todo[level--] = mask ^ 1u << place;
        x = 4 * x + (child & 3);
        y = 4 * y + (child >> 2);
    }
}

/* True if the ray seems to fall to the ground within SOON_CELLS cells. */
static inline bool falls_soon(const cw_field *f, const cw_ray *ray, const one_start *at) {
    const float *d = ray->dir;
    if (!(d[2] < 0 && at->height >= 0 && at->height * (fabsf(d[0]) + fabsf(d[1])) <= SOON_CELLS * -d[2])) return false;
    /* The rows that it may need: or their loads would wait for the first one's. */
    const size_t j = (size_t)at->j, next = d[1] > 0 ? j + 2 : j - 1; /* below 0 it wraps, beyond every field */
    const float *z = f->z + j * f->stride + at->i;
    __builtin_prefetch(z + f->stride);
    if (next < f->ny) __builtin_prefetch(f->z + next * f->stride + at->i);
    return true;
}

/* cw_one1, cw_one4, cw_one8 or cw_one16. */
void CW_CODE(one)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        one_find at;
        strict_ray one;
        cw_hit *const hit = hits ? &hits[k] : NULL;
        uint8_t *const blocked = hits ? NULL : &occluded[k];
        one_start start;
        const bool inside = starts_inside(f, &rays[k], &start);
        if (inside && falls_soon(f, &rays[k], &start) && cw_cell_few(f, &rays[k], SOON_CELLS, hit, blocked)) continue;
        if (W == 1) { /* faster in plain C */
            cw_pyramid1.trace[CW_LEAF_WATERTIGHT](f, &rays[k], 1, hit, blocked);
            continue;
        }
        const bool low = inside && fabsf(start.height) <= LOW_HEIGHT;
        const bool found = walk_one(f, &rays[k], low ? &start : NULL, false, 0, &one, &at);
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
    if (!walk_one(f, ray, NULL, true, t, &one, &at)) return false;
    const float *row = f->z + (size_t)at.j * f->stride + (size_t)at.i, *corner = at.b ? row + f->stride : row + 1;
    const float numbers[FOUND_NUMBERS] = {at.t0,  at.t1,   (float)at.i,        (float)at.j,
                                          row[0], *corner, row[f->stride + 1], at.b ? 1 : 0};
    memcpy(find, numbers, sizeof numbers);
    return true;
}
