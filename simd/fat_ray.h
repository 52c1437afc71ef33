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

#include <math.h>
#include <stdalign.h>

/* Rays of a tile, a bit each; the lanes of packet p are bits p W and on. */
typedef uint64_t ray_set;
/* Its packets. */
typedef uint64_t packet_set;
enum { TILE = 64, PACKETS = TILE / W };

/* For fewer rays than this, making a fat ray takes longer than it saves. */
enum { SHARE_AT_LEAST = 4 };

/* Greatest distance in cells between the origins of a tile that shares a walk, along each axis. With more, shadow rays
 * lose time, as the tile falls apart at once. */
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

/* False if the first rays are seen at once to go into several quadrants, as those of incoherent tiles mostly do. */
static inline bool may_cohere(const packet *packets, ray_set rays) {
    const size_t p = (size_t)__builtin_ctzll(rays) / W;
    const unsigned here = packet_bits(rays, p);
    const unsigned x = vm_bits(packets[p].r.x.up) & here, y = vm_bits(packets[p].r.y.up) & here;
    return (x == 0 || x == here) && (y == 0 || y == here);
}

/* Numbers of which some rays' lowest and highest are found; of from the lowest only, as the last of 16. */
enum { HULL_X, HULL_DX, HULL_Y, HULL_DY, HULL_OZ, HULL_DZ, HULL_UNTIL, HULL_NUMBERS, HULL_FROM = 15 };

/* Adds the rays of a packet in m, or all of them. */
CW_INLINE void hull_add(vfloat hull[16], const vray *r, bool all, vmask m) {
    const vfloat number[HULL_NUMBERS] = {r->x.center, r->x.dir, r->y.center, r->y.dir, r->oz, r->dz, r->until};
    for (int k = 0; k < HULL_NUMBERS; k++) {
        vfloat *low = &hull[k], *high = &hull[HULL_NUMBERS + k];
        const vfloat lower = vf_min(*low, number[k]), higher = vf_max(*high, number[k]);
        *low = all ? lower : vf_select(m, lower, *low);
        *high = all ? higher : vf_select(m, higher, *high);
    }
    const vfloat from = vf_min(hull[HULL_FROM], r->from);
    hull[HULL_FROM] = all ? from : vf_select(m, from, hull[HULL_FROM]);
}

/* Sets one axis from the ends of its center and its direction. Those of 1 / dir follow, since rounded division is
 * monotone. False if rays go both up and down. If some stand and some go, a distance of zero times infinity may be NaN,
 * which vf_min and vf_max of fat_meets, in that order, make no limit. */
static inline bool fat_axis_init(fat_axis *a, bool *up, const float low[2], const float minus_high[2]) {
    const float least = low[1], most = -minus_high[1];
    *up = least >= 0;
    if (*up != (most >= 0)) return false;
    a->center_in = vf_set(*up ? -minus_high[0] : low[0]);
    a->center_out = vf_set(*up ? low[0] : -minus_high[0]);
    a->inverse_low = vf_set(most == 0 ? INFINITY : 1 / most);
    a->inverse_high = vf_set(least == 0 ? INFINITY : 1 / least);
    return true;
}

/* False if the rays are not coherent: in one direction quadrant, with directions that differ by at most 1/4 of the
 * longest, and origins by TILE_CELLS. Right answers require only one quadrant, and no negative from, so that products of
 * t and dz keep their order; the other conditions are for speed. Rejected: to judge the rays first, with all of their
 * numbers read twice. */
static __attribute__((noinline)) bool fat_init(fat_ray *a, const packet *packets, ray_set rays) {
    vfloat hull[16];
    for (int k = 0; k < 16; k++) hull[k] = vf_set(k / HULL_NUMBERS == 1 ? -INFINITY : INFINITY);
    for (ray_set left = rays; left != 0;) {
        const size_t p = next_packet(&left);
        const unsigned here = packet_bits(rays, p);
        if (here == packet_bits(~(ray_set)0, p))
            hull_add(hull, &packets[p].r, true, vm_set(true));
        else
            hull_add(hull, &packets[p].r, false, vm_from_bits(here));
    }
    for (int k = 0; k < HULL_NUMBERS; k++) hull[HULL_NUMBERS + k] = vf_flip(hull[HULL_NUMBERS + k], vf_set(-0.0f));
    float low[16], longest = 0;
    vf_lowest_of_each(hull, low);
    const float *const minus_high = low + HULL_NUMBERS;
    for (int k = HULL_DX; k <= HULL_DZ; k += 2) {
        if (-low[k] > longest) longest = -low[k];
        if (-minus_high[k] > longest) longest = -minus_high[k];
    }
    bool close = low[HULL_FROM] >= 0;
    for (int k = HULL_DX; k <= HULL_DZ; k += 2) close &= -minus_high[k] - low[k] <= 0.25f * longest;
    for (int k = HULL_X; k <= HULL_Y; k += 2) close &= -minus_high[k] - low[k] <= TILE_CELLS;
    if (!close) return false;
    a->oz_low = vf_set(low[HULL_OZ]);
    a->oz_high = vf_set(-minus_high[HULL_OZ]);
    a->dz_low = vf_set(low[HULL_DZ]);
    a->dz_high = vf_set(-minus_high[HULL_DZ]);
    a->from = vf_set(low[HULL_FROM]);
    a->until = vf_set(-minus_high[HULL_UNTIL]);
    return fat_axis_init(&a->x, &a->q.up_x, low + HULL_X, minus_high + HULL_X) &&
           fat_axis_init(&a->y, &a->q.up_y, low + HULL_Y, minus_high + HULL_Y);
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
