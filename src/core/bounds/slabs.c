/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs of nodes larger than a tile, without going through their samples again.
 *
 * The plane follows from sums that the nodes below have. How far samples lie off it is exact, as it is in tiles:
 * slabs of slabs would be thicker at each level and cost steps (papers/walks.md). Only nodes whose samples can be
 * that far off are read: the slabs below bound the distance, and the nodes with the largest bounds come first. */

#include "pyramid.h"
#include "survey.h"

#include <float.h>

/* The sample that is farthest above the node's plane, or below it. */
typedef struct search {
    const cw_field *f;
    const struct cw_pyramid *p;
    float slope_x, slope_y;
    size_t column, row; /* the node's first sample */
    float middle;       /* of the node, seen from there */
    float sign;         /* -1: below */
    double rounding;    /* difference that a distance in float may have from the one of slabs below */
    float best;         /* distance, so far */
} search;

static void search_block(search *s, size_t x, size_t y) {
    const cw_field *f = s->f;
    const size_t last_i = 4 * x + 4 < f->nx - 1 ? 4 * x + 4 : f->nx - 1;
    const size_t last_j = 4 * y + 4 < f->ny - 1 ? 4 * y + 4 : f->ny - 1;
    for (size_t j = 4 * y; j <= last_j; j++) {
        const float along_y = ((float)(j - s->row) - s->middle) * s->slope_y;
        for (size_t i = 4 * x; i <= last_i; i++) {
            const float plane = s->slope_x * ((float)(i - s->column) - s->middle);
            s->best = higher(s->sign * (f->z[j * f->stride + i] - (plane + along_y)), s->best);
        }
    }
}

typedef struct child {
    double most; /* no sample of it is farther off */
    size_t x, y;
} child;

static double most_of(const search *s, int level, size_t x, size_t y) {
    const cw_pyramid_slab *b = &s->p->slab[(size_t)s->p->first[level + 1] + y * cw_pyramid_across(s->f, level) + x];
    if (!(b->low <= b->high)) return -DBL_MAX;
    const double half = 0.5 * (double)s->p->level[level].side, middle = (double)s->middle;
    const double dx = (double)(2 * x + 1) * half - (double)s->column - middle;
    const double dy = (double)(2 * y + 1) * half - (double)s->row - middle;
    const double own_x = (double)b->slope_x, own_y = (double)b->slope_y, sx = (double)s->slope_x,
                 sy = (double)s->slope_y;
    const double lean = (fabs(own_x - sx) + fabs(own_y - sy)) * half, here = sx * dx + sy * dy;
    const double off = s->sign > 0 ? (double)b->high - here : here - (double)b->low;
    return off + lean + s->rounding + 0x1p-20 * (fabs(own_x) + fabs(own_y)) * half;
}

static void search_node(search *s, int level, size_t x, size_t y) {
    if (level == 0) {
        search_block(s, x, y);
        return;
    }
    const size_t across = cw_pyramid_across(s->f, level - 1), down = cw_pyramid_down(s->f, level - 1);
    child children[16];
    int n = 0;
    for (size_t b = 4 * y; b < 4 * y + 4 && b < down; b++)
        for (size_t a = 4 * x; a < 4 * x + 4 && a < across; a++) {
            const child c = {most_of(s, level - 1, a, b), a, b};
            int k = n++;
            for (; k > 0 && children[k - 1].most < c.most; k--) children[k] = children[k - 1];
            children[k] = c;
        }
    for (int k = 0; k < n && children[k].most > (double)s->best; k++)
        search_node(s, level - 1, children[k].x, children[k].y);
}

/* The sums of the node's children, moved to its first sample. */
static cw_pyramid_sum sum_up(const cw_field *f, const struct cw_pyramid *p, int level, size_t x, size_t y) {
    const size_t across = cw_pyramid_across(f, level - 1), down = cw_pyramid_down(f, level - 1);
    const double side = (double)((size_t)4 << (2 * (level - 1)));
    cw_pyramid_sum all = {0, 0, 0, 0};
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
    /* As in tiles: m numbers one apart have the sum of squares m (m² - 1) / 12 about their middle. */
    const float slope_x = (float)((sum->xz - 0.5 * (m - 1) * sum->z) * 12 / (m * (m * m - 1) * n));
    const float slope_y = (float)((sum->yz - 0.5 * (n - 1) * sum->z) * 12 / (n * (n * n - 1) * m));
    if (!(fabsf(slope_x) + fabsf(slope_y) <= FLT_MAX) || (slope_x == 0 && slope_y == 0)) {
        slab->low = low;
        slab->high = high;
    } else {
        const float half = 0.5f * (float)side;
        search s = {.f = f, .p = p, .slope_x = slope_x, .slope_y = slope_y, .column = x * side, .row = y * side};
        s.middle = half;
        /* With u = 2^-24, a distance has an error of 3 u of the plane's rise and u of the height. The slabs below
         * were set from such distances, with errors of the same parts of their planes. */
        const double heights = fmax(fabs((double)low), fabs((double)high));
        s.rounding = 0x1p-20 * (heights + (fabs((double)slope_x) + fabs((double)slope_y)) * (double)half);
        for (int k = 0; k < 2; k++) {
            s.sign = k == 0 ? 1 : -1;
            s.best = -INFINITY;
            search_node(&s, level, x, y);
            *(k == 0 ? &slab->high : &slab->low) = s.sign * s.best;
        }
        slab->slope_x = slope_x;
        slab->slope_y = slope_y;
    }
    sum->steepest = fmax((double)cw_slab_outward(slab, f, low, high), sum->steepest);
}
