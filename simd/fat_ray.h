/* SPDX-License-Identifier: Apache-2.0 */
/* A fat ray: an interval for each number of some coherent rays of a tile, tested against 16 children or cells at once.
 * So opening a node costs 64 rays little more than one.
 *
 * Invariant: the fat ray uses interval arithmetic in the gate's own operations, in their order. Each is monotone in
 * each of its arguments, also after rounding. So its intervals enclose the numbers of each ray without padding, and no
 * child that a ray must visit is skipped. Visits are front to back for all rays of one direction quadrant. */
#ifndef CELLWALK_SIMD_FAT_RAY_H
#define CELLWALK_SIMD_FAT_RAY_H

#include "children.h"
#include "flat_walk.h"
#include "pyramid.h"

#include <float.h>
#include <math.h>
#include <stdalign.h>

/* Rays of a tile, a bit each; the lanes of packet p are bits p W and on. */
typedef uint64_t ray_set;
/* Its packets. */
typedef uint64_t packet_set;
enum { TILE = 64, PACKETS = TILE / W };

/* For fewer rays than this, making a fat ray takes longer than it saves. */
enum { SHARE_AT_LEAST = 4 };

/* Greatest distance in cells between the origins of a tile that shares a walk and that of its first ray, along each
 * axis. With more, shadow rays lose time, as the tile falls apart at once. */
enum { TILE_CELLS = 16 };

static inline unsigned packet_bits(ray_set rays, size_t p) {
    return (unsigned)(rays >> (p * W)) & (unsigned)(((ray_set)1 << W) - 1);
}

/* Returns the first packet with some of the rays, and removes its rays from them. */
static inline size_t next_packet(ray_set *rays) {
    const size_t p = (size_t)__builtin_ctzll(*rays) / W;
    *rays &= ~((((ray_set)1 << W) - 1) << (p * W));
    return p;
}
/* Counts a bit for each packet, its highest, to which the sum of the others carries. */
static inline int packets_of(ray_set rays) {
    const ray_set top = ~(ray_set)0 / (((ray_set)1 << W) - 1) << (W - 1);
    return __builtin_popcountll((((rays & ~top) + ~top) | rays) & top);
}

/* Intervals over some rays, each number in all lanes: of centers the end for entry and that for exit borders. */
typedef struct fat_axis {
    vfloat center_in, center_out, inverse_low, inverse_high;
} fat_axis;

/* Whole cache lines: another size moves other stack arrays to where stores and loads collide (papers/walks.md). */
typedef struct fat_ray {
    alignas(64) fat_axis x;
    fat_axis y;
    vfloat oz_low, oz_high, dz_low, dz_high;
    vfloat from, until;
    quadrant q;
} fat_ray;

/* True if the rays are coherent: in one direction quadrant, directions within 1/8 of the first one's length from it,
 * origins within TILE_CELLS of its origin. Right answers require only one quadrant and no negative from; the other
 * conditions are for speed. */
static inline bool coherent(const packet *packets, ray_set rays) {
    const unsigned first = (unsigned)__builtin_ctzll(rays);
    const vray *one = &packets[first / W].r;
    const unsigned lane = first % W;
    const vfloat dx = vf_set(vf_lane(&one->x.dir, lane)), dy = vf_set(vf_lane(&one->y.dir, lane)),
                 dz = vf_set(vf_lane(&one->dz, lane));
    const vfloat ox = vf_set(vf_lane(&one->x.org, lane)), oy = vf_set(vf_lane(&one->y.org, lane));
    const vfloat length = vf_max(vf_max(vf_abs(dx), vf_abs(dy)), vf_abs(dz)), zero = vf_set(0);
    const vfloat angle = vf_mul(length, vf_set(0.125f)), apart = vf_set(TILE_CELLS);
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const unsigned here = packet_bits(rays, p);
        const vray *r = &packets[p].r;
        vmask m = vm_and(vf_le(vf_abs(vf_sub(r->x.dir, dx)), angle), vf_le(vf_abs(vf_sub(r->y.dir, dy)), angle));
        m = vm_and(m, vf_le(vf_abs(vf_sub(r->dz, dz)), angle));
        m = vm_and(m, vm_and(vf_le(vf_abs(vf_sub(r->x.org, ox)), apart), vf_le(vf_abs(vf_sub(r->y.org, oy)), apart)));
        m = vm_andnot(m, vm_or(vm_xor(r->x.up, vf_ge(dx, zero)), vm_xor(r->y.up, vf_ge(dy, zero))));
        m = vm_and(m, vf_ge(r->from, zero)); /* products of t and dz keep their order */
        if ((vm_bits(m) & here) != here) return false;
    }
    return true;
}

/* Numbers of the intervals. The highest of each is found as the lowest of its negative. */
enum { HULL_X, HULL_X_INVERSE, HULL_Y, HULL_Y_INVERSE, HULL_OZ, HULL_DZ, HULL_UNTIL, HULL_NUMBERS, HULL_FROM = 15 };

/* False if on some axis the direction is zero for some rays and not for others: infinity, the inverse of zero, times a
 * distance of zero is NaN. If it is zero for all, that cannot happen, as their centers lie between borders. */
static __attribute__((noinline)) bool fat_init(fat_ray *a, const packet *packets, ray_set rays) {
    const vfloat minus = vf_set(-0.0f), infinite = vf_set(INFINITY);
    const unsigned first = (unsigned)__builtin_ctzll(rays);
    vfloat hull[16];
    for (int k = 0; k < 16; k++) hull[k] = infinite;
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const vray *r = &packets[p].r;
        const vmask m = vm_from_bits(packet_bits(rays, p));
        const vfloat number[HULL_NUMBERS] = {r->x.center, r->x.inverse, r->y.center, r->y.inverse,
                                             r->oz,       r->dz,        r->until};
        for (int k = 0; k < HULL_NUMBERS; k++) {
            const vfloat low = vf_select(m, number[k], infinite);
            const vfloat high = vf_select(m, vf_flip(number[k], minus), infinite);
            hull[k] = vf_min(hull[k], low);
            hull[HULL_NUMBERS + k] = vf_min(hull[HULL_NUMBERS + k], high);
        }
        const vfloat from = vf_select(m, r->from, infinite);
        hull[HULL_FROM] = vf_min(hull[HULL_FROM], from);
    }
    float low[16];
    vf_lowest_of_each(hull, low);
    const float *minus_high = low + HULL_NUMBERS;

    a->q.up_x = vm_bits(packets[first / W].r.x.up) >> (first % W) & 1;
    a->q.up_y = vm_bits(packets[first / W].r.y.up) >> (first % W) & 1;
    a->oz_low = vf_set(low[HULL_OZ]);
    a->oz_high = vf_set(-minus_high[HULL_OZ]);
    a->dz_low = vf_set(low[HULL_DZ]);
    a->dz_high = vf_set(-minus_high[HULL_DZ]);
    a->from = vf_set(low[HULL_FROM]);
    a->until = vf_set(-minus_high[HULL_UNTIL]);
    fat_axis *const axis[2] = {&a->x, &a->y};
    for (int c = 0; c < 2; c++) {
        const bool up = c == 0 ? a->q.up_x : a->q.up_y;
        const vfloat least = vf_set(low[2 * c]), most = vf_set(-minus_high[2 * c]);
        axis[c]->center_in = up ? most : least;
        axis[c]->center_out = up ? least : most;
        axis[c]->inverse_low = vf_set(low[2 * c + 1]);
        axis[c]->inverse_high = vf_set(-minus_high[2 * c + 1]);
    }
    /* Only rays that go up have infinite ones. */
    const bool mixed_x = a->q.up_x && -minus_high[HULL_X_INVERSE] > FLT_MAX && low[HULL_X_INVERSE] <= FLT_MAX;
    const bool mixed_y = a->q.up_y && -minus_high[HULL_Y_INVERSE] > FLT_MAX && low[HULL_Y_INVERSE] <= FLT_MAX;
    return !mixed_x && !mixed_y;
}

/* The earliest t at which one of the rays crosses an entry border, and the latest for an exit border. */
static inline vfloat fat_in(const fat_axis *a, vfloat border) {
    const vfloat far = vf_sub(border, a->center_in);
    return vf_min(vf_mul(far, a->inverse_low), vf_mul(far, a->inverse_high));
}
static inline vfloat fat_out(const fat_axis *a, vfloat border) {
    const vfloat far = vf_sub(border, a->center_out);
    return vf_max(vf_mul(far, a->inverse_low), vf_mul(far, a->inverse_high));
}

/* Lanes k W and on of 16 places of that side, from corner (x, y) on, where a ray may meet heights in [low, high]. */
static inline vmask fat_meets(const fat_ray *a, vfloat x, vfloat y, vfloat side, size_t k, vfloat low, vfloat high) {
    const bool up_x = a->q.up_x, up_y = a->q.up_y;
    const vfloat enter_x = vf_add(x, vf_mul(vf_load(lane_x[!up_x] + k * COLUMNS_STEP), side));
    const vfloat leave_x = vf_add(x, vf_mul(vf_load(lane_x[up_x] + k * COLUMNS_STEP), side));
    const vfloat enter_y = vf_add(y, vf_mul(vf_load(lane_y[!up_y] + k * W), side));
    const vfloat leave_y = vf_add(y, vf_mul(vf_load(lane_y[up_y] + k * W), side));
    const vfloat t0 = vf_max(vf_max(fat_in(&a->x, enter_x), fat_in(&a->y, enter_y)), a->from);
    const vfloat t1 = vf_min(vf_min(fat_out(&a->x, leave_x), fat_out(&a->y, leave_y)), a->until);
    const vfloat bottom = vf_min(vf_mul(t0, a->dz_low), vf_mul(t1, a->dz_low));
    const vfloat top = vf_max(vf_mul(t0, a->dz_high), vf_mul(t1, a->dz_high));
    const vmask meets = vm_and(vf_ge(top, vf_sub(low, a->oz_high)), vf_le(bottom, vf_sub(high, a->oz_low)));
    return vm_and(vf_le(t0, t1), meets);
}

/* The children of node (x, y) that some ray may meet, in walk order. */
static inline unsigned fat_open(const fat_ray *a, const cw_pyramid_level *l, int32_t x, int32_t y) {
    const float *brick = l->bricks + ((size_t)y * (size_t)l->across + (size_t)x) * BRICK_FLOATS;
    const float s = l->side;
    const vfloat side = vf_set(s), low_x = vf_set((float)(4 * x) * s), low_y = vf_set((float)(4 * y) * s);
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++)
        mask |= vm_bits(fat_meets(a, low_x, low_y, side, k, vf_load(brick + k * W), vf_load(brick + CHILDREN + k * W)))
                << (k * W);
    return in_walk_order(mask, a->q);
}

/* The cells of a block that some ray may meet, in walk order. Also sets the cells' lowest and highest samples. */
static inline unsigned fat_cells(const fat_ray *a, block_samples *s, int32_t x, int32_t y) {
    const vfloat low_x = vf_set((float)(4 * x)), low_y = vf_set((float)(4 * y));
    const ptrdiff_t step = (ptrdiff_t)s->stride;
    unsigned mask = 0;
    for (size_t k = 0; k < CHILD_VECTORS; k++) {
        vcell c;
        c.h00 = vf_load_block(s->z, step, k);
        c.h10 = vf_load_block(s->z + 1, step, k);
        c.h01 = vf_load_block(s->z + step, step, k);
        c.h11 = vf_load_block(s->z + step + 1, step, k);
        const vfloat low = cell_low(&c), high = cell_high(&c);
        vf_store(s->low + k * W, low);
        vf_store(s->high + k * W, high);
        mask |= vm_bits(fat_meets(a, low_x, low_y, vf_set(1), k, low, high)) << (k * W);
    }
    return in_walk_order(mask, a->q);
}

/* Crossings of the place with lowest corner (x, y), a ray a lane. */
static inline void place_crossings(const vray *r, quadrant q, float x, float y, float side, vcell *c) {
    c->x_in = crossing(&r->x, vf_set(q.up_x ? x : x + side));
    c->x_out = crossing(&r->x, vf_set(q.up_x ? x + side : x));
    c->y_in = crossing(&r->y, vf_set(q.up_y ? y : y + side));
    c->y_out = crossing(&r->y, vf_set(q.up_y ? y + side : y));
}

/* The rays whose heights over the block meet its bounds. */
static inline ray_set block_rays(const fat_ray *a, const packet *packets, ray_set rays, const cw_pyramid_level *l,
                                 int32_t x, int32_t y) {
    const float *n =
        l->bricks + ((size_t)(y >> 2) * (size_t)l->across + (size_t)(x >> 2)) * BRICK_FLOATS + ((y & 3) << 2 | (x & 3));
    ray_set concerned = 0;
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const vray *r = &packets[p].r;
        vcell c;
        place_crossings(r, a->q, (float)(4 * x), (float)(4 * y), 4, &c);
        const vfloat t0 = vf_max(vf_max(c.x_in, c.y_in), r->from), t1 = vf_min(vf_min(c.x_out, c.y_out), r->until);
        concerned |= (ray_set)vm_bits(vm_and(vf_le(t0, t1), meets(r, t0, t1, vf_set(n[0]), vf_set(n[16])))) << (p * W);
    }
    return concerned & rays;
}

#endif
