/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs of nodes larger than a tile, from what its tiles have: the plane from their sums, and how far samples lie off
 * it from their slabs. Rejected: a search for the sample that is farthest off, which gives no more speed, and slabs of
 * the level below, which are thicker at each level (papers/walks.md). */

#include "pyramid.h"

#include <float.h>

/* Sets low and high of a slab, whose plane is set, to what encloses its tiles. With u = 2^-24, a tile's distances have
 * an error of 3 u of its plane's rise and u of the height; there is room for 16. */
static void enclose_tiles(cw_pyramid_slab *s, const cw_field *f, const struct cw_pyramid *p, int level, size_t x,
                          size_t y, double heights) {
    const int shift = 2 * (level - TILE_LEVEL);
    const size_t across = cw_pyramid_across(f, TILE_LEVEL), end_x = least((x + 1) << shift, across);
    const size_t end_y = least((y + 1) << shift, cw_pyramid_down(f, TILE_LEVEL));
    const double half = 0.5 * TILE_SIDE, tiles = (double)((size_t)1 << shift), sx = (double)s->slope_x,
                 sy = (double)s->slope_y;
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (size_t b = y << shift; b < end_y; b++)
        for (size_t a = x << shift; a < end_x; a++) {
            const cw_pyramid_slab *t = &p->sum[TILE_LEVEL][b * across + a].slab;
            const double tx = (double)t->slope_x, ty = (double)t->slope_y;
            const double dx = (double)(2 * (a - (x << shift)) + 1) - tiles,
                         dy = (double)(2 * (b - (y << shift)) + 1) - tiles;
            const double plane = (sx * dx + sy * dy) * half;
            const double lean = (fabs(tx - sx) + fabs(ty - sy) + 0x1p-20 * (fabs(tx) + fabs(ty))) * half;
            low = fmin(low, (double)t->low - plane - lean);
            high = fmax(high, (double)t->high - plane + lean);
        }
    const double room = 0x1p-20 * (heights + (fabs(sx) + fabs(sy)) * half * tiles);
    s->low = (float)(low - room);
    s->high = (float)(high + room);
}

/* The sums of the node's children, moved to its first sample. */
static cw_pyramid_sum sum_up(const cw_field *f, const struct cw_pyramid *p, int level, size_t x, size_t y) {
    const size_t across = cw_pyramid_across(f, level - 1), down = cw_pyramid_down(f, level - 1);
    const double side = (double)((size_t)4 << (2 * (level - 1)));
    cw_pyramid_sum all = {0};
    for (size_t b = 0; b < 4 && 4 * y + b < down; b++)
        for (size_t a = 0; a < 4 && 4 * x + a < across; a++) {
            const cw_pyramid_sum *c = &p->sum[level - 1][(4 * y + b) * across + 4 * x + a];
            all.z += c->z;
            all.xz += c->xz + (double)a * side * c->z;
            all.yz += c->yz + (double)b * side * c->z;
            all.steepest = fmax(c->steepest, all.steepest);
        }
    if (isnan(all.z)) all.z = all.xz = all.yz = (double)NAN; /* one NaN of all that there are */
    return all;
}

/* How many samples a node that begins at begin owns. */
static size_t owned(size_t begin, size_t side, size_t n) { return begin + side >= n - 1 ? n - begin : side; }

void cw_pyramid_node_slab(const cw_field *f, struct cw_pyramid *p, int level, size_t x, size_t y) {
    const size_t side = (size_t)4 << (2 * level), number = y * cw_pyramid_across(f, level) + x;
    cw_pyramid_sum *sum = &p->sum[level][number];
    cw_pyramid_slab *slab = &p->slab[(size_t)p->first[level + 1] + number];
    const float *bounds = cw_pyramid_node(&p->level[level], x, y), low = bounds[0], high = bounds[16];
    *sum = sum_up(f, p, level, x, y);
    *slab = (cw_pyramid_slab){INFINITY, -INFINITY, 0, 0};
    if (!(low <= high)) return; /* nothing but holes */

    const double m = (double)owned(x * side, side, f->nx), n = (double)owned(y * side, side, f->ny);
    /* By the sums of squares of tile.c. */
    const float slope_x = (float)((sum->xz - 0.5 * (m - 1) * sum->z) * 12 / (m * (m * m - 1) * n));
    const float slope_y = (float)((sum->yz - 0.5 * (n - 1) * sum->z) * 12 / (n * (n * n - 1) * m));
    if (!(fabsf(slope_x) + fabsf(slope_y) <= FLT_MAX) || (slope_x == 0 && slope_y == 0)) {
        slab->low = low;
        slab->high = high;
    } else {
        slab->slope_x = slope_x;
        slab->slope_y = slope_y;
        enclose_tiles(slab, f, p, level, x, y, fmax(fabs((double)low), fabs((double)high)));
    }
    sum->steepest = fmax((double)cw_slab_outward(slab, f, low, high), sum->steepest);
}
