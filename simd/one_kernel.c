/* SPDX-License-Identifier: Apache-2.0 */
/* One ray over the pyramid, for calls of few rays, and for rays that keep a lane for long (lane_walk.h). Lanes are places: the
 * 16 children of a node, or the 16 cells of a block, are tested at once (children.h), by the gate's own operations. So a level
 * costs one chain of operations and one branch that is hard to foretell. With 16 lanes, opening a node has no branch that depends on
 * the ray's quadrant, which is as good as random.
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
 * that they save; all lanes on the columns of a ray that is beside a surface; fewer than 16 lanes in walk order, crossings of
 * children carried down, or computed a level ahead (papers/walks.md). */

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

/* A cell's row above 32 bits, and its column; or none. One number: of two, GCC makes two stores and one load, which waits for both. */
typedef int64_t one_cell;
enum { NO_CELL = -1 };

/* With 16 lanes one instruction puts a node's bounds in walk order. With fewer, the mask is put in walk order. */
enum { ORDERED = W == CHILDREN };

/* The borders where a ray enters and leaves children, in sides of a child. */
typedef struct child_borders {
    vfloat in_x, in_y, out_x, out_y;
} child_borders;

/* Those of lanes k W and on, in the children's own order. */
CW_INLINE child_borders borders_of(quadrant q, size_t k) {
    const size_t column = k * COLUMNS_STEP, row = k * W;
    return (child_borders){vf_load(lane_x[!q.up_x] + column), vf_load(lane_y[!q.up_y] + row),
                           vf_load(lane_x[q.up_x] + column), vf_load(lane_y[q.up_y] + row)};
}

/* Bit k of a mask is child k XOR flip. If ORDERED, rows too are numbered from where the ray enters, so the nearest child is the lowest
 * bit; lane k is that child, and borders are the lanes'. */
typedef struct walk_order {
    quadrant q;
    int flip;
    vint child;
    child_borders borders;
} walk_order;

CW_INLINE walk_order order_of(quadrant q) {
    static const int32_t number[CHILDREN] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    static const float in_x[2][CHILDREN] = {{4, 3, 2, 1, 4, 3, 2, 1, 4, 3, 2, 1, 4, 3, 2, 1},
                                            {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3}};
    static const float in_y[2][CHILDREN] = {{4, 4, 4, 4, 3, 3, 3, 3, 2, 2, 2, 2, 1, 1, 1, 1},
                                            {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3}};
    walk_order o = {.q = q, .flip = ORDERED ? 15 - 3 * q.up_x - 12 * q.up_y : turn(q)};
    if (!ORDERED) return o;
    const vfloat x = vf_load(in_x[q.up_x]), y = vf_load(in_y[q.up_y]);
    const vfloat step_x = vf_set((float)(2 * q.up_x - 1)), step_y = vf_set((float)(2 * q.up_y - 1));
    o.child = vi_xor(vi_load(number), vi_set(o.flip));
    o.borders = (child_borders){x, y, vf_add(x, step_x), vf_add(y, step_y)};
    return o;
}

/* Crossings with the borders of some children of node (x, y), which have that side. Borders are whole numbers, which nothing
 * rounds. */
CW_INLINE void cross_children(const vray *r, const child_borders *b, int32_t x, int32_t y, float side, vcell *c) {
    const vfloat s = vf_set(side), low_x = vf_set((float)(4 * x) * side), low_y = vf_set((float)(4 * y) * side);
    c->x_in = crossing(&r->x, vf_add(low_x, vf_mul(b->in_x, s)));
    c->y_in = crossing(&r->y, vf_add(low_y, vf_mul(b->in_y, s)));
    c->x_out = crossing(&r->x, vf_add(low_x, vf_mul(b->out_x, s)));
    c->y_out = crossing(&r->y, vf_add(low_y, vf_mul(b->out_y, s)));
}

/* The children of node (x, y) that the ray meets, in walk order. */
CW_INLINE unsigned open_node(const vray *r, const walk_order *o, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++) {
        vcell c;
        const child_borders b = ORDERED ? o->borders : borders_of(o->q, k);
        cross_children(r, &b, x, y, l->side, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const vfloat z0 = vf_mul(t0, r->dz), z1 = vf_mul(t1, r->dz);
        const float *lows = brick + k * W, *highs = lows + CHILDREN;
        const vfloat low = above_origin(r, ORDERED ? vf_lookup(lows, o->child) : vf_load(lows));
        const vfloat high = above_origin(r, ORDERED ? vf_lookup(highs, o->child) : vf_load(highs));
        /* meets, whose second comparison would wait for the first */
        const vmask here = vm_and(vf_le(t0, t1), vf_ge(vf_max(z0, z1), low));
        mask |= (vm_bits(here) & vm_bits(vf_le(vf_min(z0, z1), high))) << (k * W);
    }
    return ORDERED ? mask : in_walk_order(mask, o->q);
}

/* Tests the cells of block (x, y). Lanes stay in the cells' own order: only a hit needs a mask in walk order. */
static inline one_cell test_block(const vray *r, quadrant q, const cw_field *f, int32_t x, int32_t y,
                                  strict_find *found) {
    block_samples s;
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    const ptrdiff_t step = (ptrdiff_t)s.stride;
    for (size_t n = 0; n < CHILD_VECTORS; n++) {
        size_t k = q.up_y ? n : CHILD_VECTORS - 1 - n; /* front to back */
        if (W == 1) k ^= (size_t)turn(q);
        vcell c;
        const child_borders b = borders_of(q, k);
        cross_children(r, &b, x, y, 1, &c);
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
        return (one_cell)(4 * y + (place >> 2)) << 32 | (4 * x + (place & 3));
    }
    return NO_CELL;
}

/* True if the ray hits nothing in node (x, y) of a level. Not inlined: else its inputs stay live through the whole walk. */
static __attribute__((noinline)) bool slab_misses(const one_ray *r, const cw_field *f, int level, int32_t x,
                                                  int32_t y) {
    const struct cw_pyramid *p = f->pyramid;
    const int32_t side = (int32_t)4 << 2 * level;
    const cw_pyramid_slab *s =
        &p->slab[(size_t)p->first[level + 1] + (size_t)y * cw_pyramid_across(f, level) + (size_t)x];
    const float *bounds = cw_pyramid_node(&p->level[level], (size_t)x, (size_t)y);
    if (!(s->low <= s->high)) return true;
    const int32_t corner[2] = {x * side, y * side};
    const bool up[2] = {r->q.up_x, r->q.up_y};
    float t0 = r->from, t1 = r->t1;
    for (int c = 0; c < 2; c++) {
        const float enter = (float)(corner[c] + (up[c] ? 0 : side)), leave = (float)(corner[c] + (up[c] ? side : 0));
        t0 = max_second(t0, (enter - r->center[c]) * r->inverse[c]);
        t1 = min_second(t1, (leave - r->center[c]) * r->inverse[c]);
    }
    const double u = (double)(FLT_EPSILON / 2), low = (double)s->low, high = (double)s->high, half = 0.5 * side;
    const double oz = (double)r->org[2], dz = (double)r->dir[2], a = (double)s->slope_x, b = (double)s->slope_y;
    const double dx = (double)r->dir[0], dy = (double)r->dir[1];
    const double px = (double)r->org[0] - (corner[0] + half), py = (double)r->org[1] - (corner[1] + half);
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

/* From start on, or from the top if that is NULL. late: with slabs from the first node on. The last seven are members of one, in
 * registers: loads would wait for their stores. */
static __attribute__((noinline)) one_cell walk_one(const cw_field *f, const one_ray *one, const one_start *start,
                                                   bool late, strict_find *found, quarter org, quarter dir,
                                                   quarter center, quarter inverse, float t0, float t1, float from) {
    const struct cw_pyramid *p = f->pyramid;
    const walk_order o = order_of(one->q);
    vray r;
    r.x.org = vf_set(org[0]), r.x.dir = vf_set(dir[0]), r.x.up = vm_set(o.q.up_x);
    r.y.org = vf_set(QUARTER_FLOAT(org, 1)), r.y.dir = vf_set(QUARTER_FLOAT(dir, 1)), r.y.up = vm_set(o.q.up_y);
    r.x.center = vf_set(center[0]), r.x.inverse = vf_set(inverse[0]);
    r.y.center = vf_set(QUARTER_FLOAT(center, 1)), r.y.inverse = vf_set(QUARTER_FLOAT(inverse, 1));
    r.oz = vf_set(QUARTER_FLOAT(org, 2)), r.dz = vf_set(QUARTER_FLOAT(dir, 2));
    r.t0 = vf_set(t0), r.t1 = r.until = vf_set(t1), r.from = vf_set(from);
    unsigned mask = 0, keep = ~0u, todo[PYRAMID_LEVELS_MAX];
    int level = p->levels - 1, opened = late ? OPENS : 0; /* level -1: cells */
    int32_t x = 0, y = 0;
    if (start) level = -1, x = start->i >> 2, y = start->j >> 2;
    int top = level;
    for (;;) {
        if (level < 0) {
            const one_cell cell = test_block(&r, o.q, f, x, y, found);
            if (cell != NO_CELL) return cell;
            mask = 0;
        } else {
            const bool judged = __builtin_expect(opened >= OPENS, 0) && level + 1 < p->levels;
            mask =
                judged && slab_misses(one, f, level + 1, x, y) ? 0 : open_node(&r, &o, &p->level[level], x, y) & keep;
            keep = ~0u;
        }
        while (mask == 0) {
            if (++level == p->levels) return NO_CELL;
            const int own = ((y & 3) << 2 | (x & 3)) ^ o.flip;
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
        const int32_t place = ORDERED ? __builtin_ctz(mask) : nearest(mask, o.q), child = place ^ o.flip;
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

void CW_CODE(one)(const cw_field *f, const cw_ray *rays, size_t n, cw_hit *hits, uint8_t *occluded) {
    for (size_t k = 0; k < n; k++) {
        one_ray one;
        strict_find at;
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
        const one_cell cell = init_one_ray(&one, f, &rays[k])
                                  ? walk_one(f, &one, low ? &start : NULL, false, &at, one.org, one.dir, one.center,
                                             one.inverse, one.t0, one.t1, one.from)
                                  : NO_CELL;
        if (hits == NULL) {
            occluded[k] = cell != NO_CELL;
        } else if (cell != NO_CELL) {
            const size_t i = (uint32_t)cell, j = (uint32_t)(cell >> 32);
            const float *row = f->z + j * f->stride + i;
            const strict_cell c = {
                .i = i, .j = j, .h00 = row[0], .h10 = row[1], .h01 = row[f->stride], .h11 = row[f->stride + 1]};
            const ray_start s = start_of_one(&one, f, &rays[k]);
            hits[k] = refine_hit(&s, &c, &at);
        } else { /* not by miss(), which compilers make elsewhere and copy */
            hits[k].t = INFINITY;
            hits[k].i = hits[k].j = -1;
            hits[k].triangle = 0;
            hits[k].u = hits[k].v = 0;
        }
    }
}

bool CW_CODE(one_late)(const cw_field *f, const cw_ray *ray, float t, float find[FOUND_NUMBERS]) {
    one_ray one;
    strict_find at;
    if (!init_one_ray(&one, f, ray)) return false;
    one.from = max_second(t, one.from);
    const one_cell cell =
        walk_one(f, &one, NULL, true, &at, one.org, one.dir, one.center, one.inverse, one.t0, one.t1, one.from);
    if (cell == NO_CELL) return false;
    const size_t i = (uint32_t)cell, j = (uint32_t)(cell >> 32);
    const float *row = f->z + j * f->stride + i, *corner = at.b ? row + f->stride : row + 1;
    const float numbers[FOUND_NUMBERS] = {at.t0,  at.t1,   (float)i,           (float)j,
                                          row[0], *corner, row[f->stride + 1], at.b ? 1 : 0};
    memcpy(find, numbers, sizeof numbers);
    return true;
}
