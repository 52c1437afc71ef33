/* SPDX-License-Identifier: Apache-2.0 */
/* One ray over the pyramid, for calls of few rays, and for rays that keep a lane for long (lane_walk.h). Lanes are
 * places: the 16 children of a node, or the 16 cells of a block, are tested at once (children.h), by the gate's own
 * operations. So a level costs one chain of operations and one branch that is hard to foretell. With 16 lanes, opening
 * a node has no branch that depends on the ray's quadrant, which is as good as random.
 *
 * The walk opens a node: it finds the children that the ray meets. It goes down into the nearest, and up when none is
 * left. If the ray begins near the ground, the walk begins at its block: mostly no node above need be opened, and those
 * that must be do not depend on each other. Else it begins at the top, as do rays that enter the field from outside.
 *
 * A ray that opens many nodes runs beside a surface as a rule, nearer than bounds can tell. Then nodes above blocks are
 * also judged by slabs, in double, which are wider than their samples only by what the leaf test's own rounding needs
 * this far from the ray's origin.
 *
 * Invariant: at each level what the ray meets is opened from front to back, and all before the first node opened is
 * behind the ray, so the first cell found is the first one hit. A slab passes over a node only if the leaf test's sign
 * is strict on all of it; papers/numerics.md derives how wide it has to be for that. Rejected: slabs for each ray,
 * which take longer than the nodes that they save; all lanes on the columns of a ray that is beside a surface; fewer
 * than 16 lanes in walk order, crossings of children carried down, or computed a level ahead (papers/walks.md). */

#include "../src/scalar/refine.h"
#include "children.h"
#include "kernels.h"
#include "lane_queue.h"
#include "one_ray.h"
#include "pyramid.h"
#include "vector_watertight.h"

#include <float.h>

/* See falls_soon. Rays that begin at most LOW_HEIGHT above or below a sample of their cell begin their walk at its
 * block. After OPENS nodes slabs judge nodes too. All three were measured. */
enum { SOON_CELLS = 8, LOW_HEIGHT = 8, OPENS = 48 };

/* With 16 lanes one instruction puts a node's bounds in walk order. With fewer, the mask is put in walk order. */
enum { ORDERED = W == CHILDREN };

/* The borders where a ray of one quadrant enters and leaves children, in sides of a child. */
typedef struct child_borders {
    float in_x[CHILDREN], in_y[CHILDREN], out_x[CHILDREN], out_y[CHILDREN];
} child_borders;

/* in_place: lanes are children. on_way: lane k is child[k], rows too being numbered from where the ray enters, so that
 * the nearest of some is the lowest bit of their mask. Rejected: to compute these for each ray (papers/walks.md). */
typedef struct walk_order {
    child_borders in_place, on_way;
    int32_t child[CHILDREN];
} walk_order;

#define COLUMNS(a, b, c, d)                                                                                            \
    { a, b, c, d, a, b, c, d, a, b, c, d, a, b, c, d }
#define ROWS(a, b, c, d)                                                                                               \
    { a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d }
static const walk_order orders[4] = {
    {{COLUMNS(1, 2, 3, 4), ROWS(1, 2, 3, 4), COLUMNS(0, 1, 2, 3), ROWS(0, 1, 2, 3)},
     {COLUMNS(4, 3, 2, 1), ROWS(4, 3, 2, 1), COLUMNS(3, 2, 1, 0), ROWS(3, 2, 1, 0)},
     {15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0}},
    {{COLUMNS(0, 1, 2, 3), ROWS(1, 2, 3, 4), COLUMNS(1, 2, 3, 4), ROWS(0, 1, 2, 3)},
     {COLUMNS(0, 1, 2, 3), ROWS(4, 3, 2, 1), COLUMNS(1, 2, 3, 4), ROWS(3, 2, 1, 0)},
     {12, 13, 14, 15, 8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3}},
    {{COLUMNS(1, 2, 3, 4), ROWS(0, 1, 2, 3), COLUMNS(0, 1, 2, 3), ROWS(1, 2, 3, 4)},
     {COLUMNS(4, 3, 2, 1), ROWS(0, 1, 2, 3), COLUMNS(3, 2, 1, 0), ROWS(1, 2, 3, 4)},
     {3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12}},
    {{COLUMNS(0, 1, 2, 3), ROWS(0, 1, 2, 3), COLUMNS(1, 2, 3, 4), ROWS(1, 2, 3, 4)},
     {COLUMNS(0, 1, 2, 3), ROWS(0, 1, 2, 3), COLUMNS(1, 2, 3, 4), ROWS(1, 2, 3, 4)},
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}},
};
#undef COLUMNS
#undef ROWS

/* Where a node begins, in sides of a child: a number in all lanes. */
typedef struct node_corner {
    vfloat x, y;
} node_corner;

static inline node_corner corner_of(ptrdiff_t x, ptrdiff_t y) {
    return (node_corner){vf_set((float)(int32_t)(4 * x)), vf_set((float)(int32_t)(4 * y))};
}

/* Those of a node's children, in walk order. Loaded by the child's place, its corner is known sooner than it could be
 * computed from the child's number, and all operations on that child wait for it. */
typedef struct child_corners {
    float x[CHILDREN], y[CHILDREN];
} child_corners;

CW_INLINE void place_children(child_corners *to, node_corner at, const child_borders *b) {
    vf_store(to->x, vf_mul(vf_set(4), vf_add(at.x, vf_min(vf_load(b->in_x), vf_load(b->out_x)))));
    vf_store(to->y, vf_mul(vf_set(4), vf_add(at.y, vf_min(vf_load(b->in_y), vf_load(b->out_y)))));
}

/* Crossings with the borders of lanes k and on, of the node that begins there, whose children have that side. A border
 * is a side, which is a power of two, times a number below 2^24: nothing rounds it. */
CW_INLINE void cross_children(const vray *r, const child_borders *b, size_t k, node_corner at, float side, vcell *c) {
    const vfloat s = vf_set(side);
    const size_t column = W < 4 ? k : 0; /* columns are the same in each row, so vectors of whole rows share them */
    c->x_in = vf_mul(vf_mul_sub(vf_add(at.x, vf_load(b->in_x + column)), s, r->x.center), r->x.inverse);
    c->y_in = vf_mul(vf_mul_sub(vf_add(at.y, vf_load(b->in_y + k)), s, r->y.center), r->y.inverse);
    c->x_out = vf_mul(vf_mul_sub(vf_add(at.x, vf_load(b->out_x + column)), s, r->x.center), r->x.inverse);
    c->y_out = vf_mul(vf_mul_sub(vf_add(at.y, vf_load(b->out_y + k)), s, r->y.center), r->y.inverse);
}

/* The children of node (x, y) that the ray meets, in walk order. */
CW_INLINE unsigned open_node(const vray *r, quadrant q, const walk_order *o, const cw_pyramid_level *l, ptrdiff_t x,
                             ptrdiff_t y, node_corner at) {
    const float *brick = l->bricks + (y * l->across + x) * BRICK_FLOATS;
    unsigned mask = 0;
    for (size_t k = 0; k < CHILDREN; k += W) {
        vcell c;
        cross_children(r, ORDERED ? &o->on_way : &o->in_place, k, at, l->side, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        const vfloat z0 = vf_mul(t0, r->dz), z1 = vf_mul(t1, r->dz);
        const float *lows = brick + k, *highs = lows + CHILDREN;
        const vint child = vi_load(o->child);
        const vfloat low = above_origin(r, ORDERED ? vf_lookup(lows, child) : vf_load(lows));
        const vfloat high = above_origin(r, ORDERED ? vf_lookup(highs, child) : vf_load(highs));
        /* meets, whose second comparison would wait for the first */
        const vmask here = vm_and(vf_le(t0, t1), vf_ge(vf_max(z0, z1), low));
        mask |= (vm_bits(here) & vm_bits(vf_le(vf_min(z0, z1), high))) << k;
    }
    return ORDERED ? mask : in_walk_order(mask, q);
}

/* Tests the cells of block (x, y). Lanes stay in the cells' own order: only a hit needs a mask in walk order. */
CW_INLINE one_cell test_block(const one_ray *one, const vray *r, quadrant q, const walk_order *o, const cw_field *f,
                              ptrdiff_t x, ptrdiff_t y, node_corner at, strict_find *found) {
    block_samples s;
    load_samples(&s, f, (size_t)(4 * x), (size_t)(4 * y));
    const ptrdiff_t step = (ptrdiff_t)s.stride;
    for (size_t n = 0; n < CHILDREN; n += W) {
        size_t k = q.up_y ? n : CHILDREN - W - n; /* front to back */
        if (W == 1) k ^= (size_t)turn(q);
        vcell c;
        c.i = vf_add(at.x, vf_load(lane_x[0] + (W < 4 ? k : 0)));
        c.j = vf_add(at.y, vf_load(lane_y[0] + k));
        /* The leaf test's division takes long, so it begins before the gate. Without the asm, compilers put it behind. */
        vfloat crossing = vf_div(vf_sub(vf_sub(vf_set(one->org[1]), c.j), vf_sub(vf_set(one->org[0]), c.i)),
                                 vf_set(one->dir[0] - one->dir[1]));
        __asm__ volatile("" : "+m"(crossing));
        cross_children(r, &o->in_place, k, at, 1, &c);
        clip_cell(&c, r);
        c.h00 = vf_load_block(s.z, step, k / W);
        c.h10 = vf_load_block(s.z + 1, step, k / W);
        c.h01 = vf_load_block(s.z + step, step, k / W);
        c.h11 = vf_load_block(s.z + step + 1, step, k / W);
        const vmask gate = cell_gate(r, &c);
        if (!vm_any(gate)) continue;
        vfind find;
        vray whole = *r;
        /* What nodes do not read. Without the asm, compilers make it before the walk, and store it. */
        __asm__("" : "+r"(one));
        whole.x.up = vm_set(q.up_x), whole.y.up = vm_set(q.up_y);
        whole.x.org = vf_set(one->org[0]), whole.x.dir = vf_set(one->dir[0]);
        whole.y.org = vf_set(one->org[1]), whole.y.dir = vf_set(one->dir[1]);
        const unsigned hits = vm_bits(wt_cell_in(&whole, &c, gate, &crossing, &find));
        if (hits == 0) continue;
        int lane = __builtin_ctz(hits); /* mostly the only one */
        if (hits & (hits - 1)) lane = nearest(in_walk_order(hits, q), q) ^ turn(q);
        const int place = lane + (int)k;
        found->t0 = vf_lane(&find.t0, (unsigned)lane);
        found->t1 = vf_lane(&find.t1, (unsigned)lane);
        found->b = vm_bits(find.b) >> lane & 1;
        return (one_cell)(4 * y + (place >> 2)) << 32 | (4 * x + (place & 3));
    }
    return NO_CELL;
}

/* True if the ray hits nothing in node (x, y) of a level. Not inlined: else its inputs stay live for the whole walk. */
static __attribute__((noinline)) bool slab_misses(const one_ray *r, const cw_field *f, int level, int32_t x,
                                                  int32_t y) {
    const struct cw_pyramid *p = f->pyramid;
    const int32_t side = (int32_t)4 << 2 * level;
    const cw_pyramid_slab *s =
        &p->slab[(size_t)p->first[level + 1] + (size_t)y * cw_pyramid_across(f, level) + (size_t)x];
    const float *bounds = cw_pyramid_node(&p->level[level], (size_t)x, (size_t)y);
    if (!(s->low <= s->high)) return true;
    const int32_t corner[2] = {x * side, y * side};
    const bool up[2] = {r->up & 1, r->up >> 1};
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
    /* Slabs with a slope have been set outward for rays from anywhere (cw_slab_outward). That is taken back, and
     * replaced by the width that this ray needs here. */
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

/* From start on, or from the top if that is NULL. opened: how many nodes count as opened before. up and the last seven
 * are members of one, in registers: loads would wait for their stores. */
static __attribute__((noinline)) one_cell walk_one(const cw_field *f, const one_ray *one, const one_start *start,
                                                   unsigned up, int opened, strict_find *found, quarter org,
                                                   quarter dir, quarter center, quarter inverse, float t0, float t1,
                                                   float from) {
    const struct cw_pyramid *p = f->pyramid;
    const quadrant q = {up & 1, up >> 1};
    const walk_order *o = &orders[up];
    const int flip = ORDERED ? o->child[0] : turn(q);
    vray r;
    r.x.center = vf_set(center[0]), r.x.inverse = vf_set(inverse[0]);
    r.y.center = vf_set(QUARTER_FLOAT(center, 1)), r.y.inverse = vf_set(QUARTER_FLOAT(inverse, 1));
    r.oz = vf_set(QUARTER_FLOAT(org, 2)), r.dz = vf_set(QUARTER_FLOAT(dir, 2));
    r.t0 = vf_set(t0), r.t1 = r.until = vf_set(t1), r.from = vf_set(from);
    unsigned mask = 0, keep = ~0u, todo[PYRAMID_LEVELS_MAX];
    ptrdiff_t level = p->levels - 1; /* level -1: cells */
    ptrdiff_t x = 0, y = 0;
    if (start) level = -1, x = start->i >> 2, y = start->j >> 2;
    ptrdiff_t top = level;
    child_corners corners[PYRAMID_LEVELS_MAX]; /* set if ORDERED */
    node_corner at = corner_of(x, y);
    for (;;) {
        __asm__("" : "+r"(o)); /* else compilers load its tables before the walk, to store them again */
        if (level < 0) {
            const one_cell cell = test_block(one, &r, q, o, f, x, y, at, found);
            if (cell != NO_CELL) return cell;
            mask = 0;
        } else {
            const bool judged = __builtin_expect(opened >= OPENS, 0) && level + 1 < p->levels;
            mask = judged && slab_misses(one, f, (int)level + 1, (int32_t)x, (int32_t)y)
                       ? 0
                       : open_node(&r, q, o, &p->level[level], x, y, at) & keep;
            keep = ~0u;
            if (ORDERED && mask != 0) place_children(&corners[level], at, &o->on_way);
        }
        while (mask == 0) {
            if (++level == p->levels) return NO_CELL;
            const int own = (int)((y & 3) << 2 | (x & 3)) ^ flip;
            x >>= 2;
            y >>= 2;
            if (level > top) {
                top = level;
                keep = ~(1u << own); /* rejected: what to take off, for which GCC uses mask registers */
                break;
            }
            mask = todo[level];
        }
        if (mask == 0) {
            at = corner_of(x, y);
            continue;
        }
        opened++;
        const int32_t place = ORDERED ? __builtin_ctz(mask) : nearest(mask, q), child = place ^ flip;
        if (ORDERED) at = (node_corner){vf_set(corners[level].x[place]), vf_set(corners[level].y[place])};
        todo[level--] = mask ^ 1u << place;
        x = 4 * x + (child & 3);
        y = 4 * y + (child >> 2);
        if (!ORDERED) at = corner_of(x, y);
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
        one_start start;
        const bool inside = starts_inside(f, &rays[k], &start);
        if (inside && falls_soon(f, &rays[k], &start) &&
            cw_cell_few(f, &rays[k], SOON_CELLS, hits ? &hits[k] : NULL, hits ? NULL : &occluded[k]))
            continue;
        if (W == 1) { /* faster in plain C */
            cw_pyramid1.trace[CW_LEAF_WATERTIGHT](f, &rays[k], 1, hits ? &hits[k] : NULL, hits ? NULL : &occluded[k]);
            continue;
        }
        const bool low = inside && fabsf(start.height) <= LOW_HEIGHT;
        const one_cell cell = init_one_ray(&one, f, &rays[k])
                                  ? walk_one(f, &one, low ? &start : NULL, one.up, 0, &at, one.org, one.dir, one.center,
                                             one.inverse, one.t0, one.t1, one.from)
                                  : NO_CELL;
        if (hits == NULL) {
            occluded[k] = cell != NO_CELL;
        } else if (cell != NO_CELL) {
            const size_t i = (uint32_t)cell, j = (uint32_t)(cell >> 32);
            const ray_start s = start_of_one(&one, f, &rays[k]);
            hits[k] = refine_hit(f, &s, i, j, &at);
        } else { /* not by miss(), which compilers make elsewhere and copy */
            hits[k].t = INFINITY;
            hits[k].i = hits[k].j = -1;
            hits[k].triangle = 0;
            hits[k].u = hits[k].v = 0;
        }
    }
}

one_cell CW_CODE(one_late)(const cw_field *f, const cw_ray *ray, float t, strict_find *find) {
    one_ray one;
    if (!init_one_ray(&one, f, ray)) return NO_CELL;
    one.from = max_second(t, one.from);
    return walk_one(f, &one, NULL, one.up, OPENS, find, one.org, one.dir, one.center, one.inverse, one.t0, one.t1,
                    one.from);
}
