/* SPDX-License-Identifier: Apache-2.0 */
/* A block of the raster matters to the horizons of samples in another if something in it may rise more steeply, from
 * one of these samples, than all that is nearer. With z the sample's height, H the block's highest and c the share of
 * the square of a distance by which the earth's curvature lowers what is there, nothing in the block rises by more than
 * (H - z) / D - c E, where E is the least distance in metres, and D the least one for H above z and the greatest for H
 * below. On the way there the ray crosses every ring of blocks around the sample's block that is nearer than the block
 * itself. It crosses the square in the ring's middle too, where its blocks are whole, on an edge between two samples of
 * the ring. So if the ring has no holes and its lowest sample is L, something rises by at least (L - z) / d - c d, d
 * being a distance of the ring: the greatest where L is above z, the least where it is below. Both bounds consist of
 * straight lines in z, so only the ends, z = L and z = H matter. H is raised and L lowered by what heights between
 * samples are rounded by.
 *
 * On a flat earth a summit sees to the raster's end, so this bounds little unless nothing below the level counts. */
#include "reach.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rises are computed in float: more than what they, heights between samples and distances are off by, as a share. */
static const double hair = 0x1p-18;

/* Distances in cells as metres, at all rows that share a heading with a row of blocks. */
typedef struct scale {
    double cells[2]; /* that a metre is long at most */
    double diagonal; /* metres that the longer diagonal of a cell is long at most */
} scale;

static scale scale_of(const terrain *whole, size_t block_row) {
    scale s = {{0, 0}, 0};
    const double from = fmax((double)(block_row * REACH_BLOCK) - 256, 0),
                 until = fmin((double)((block_row + 1) * REACH_BLOCK) + 256, (double)(whole->ny - 1));
    for (double j = from; j <= until; j += terrain_has_rows(whole) ? 0.5 : until - from + 1) {
        double metres[2];
        cw_terrain_metres(whole, 0.5 * (double)(whole->nx - 1), j, metres);
        for (int k = 0; k < 2; k++) {
            const double turn = k ? 1 : -1, x = whole->map[0][0] + turn * whole->map[0][1],
                         y = whole->map[1][0] + turn * whole->map[1][1];
            s.cells[k] = fmax(s.cells[k], hypot(whole->back[k][0] / metres[0], whole->back[k][1] / metres[1]));
            s.diagonal = fmax(s.diagonal, hypot(x * metres[0], y * metres[1]));
        }
    }
    return s;
}

/* What rises at least around a block: ring number k. */
typedef struct ring {
    double low, high; /* its lowest sample, lowered; -infinity: it has holes */
    double from, to;  /* least and greatest distance in metres */
} ring;

typedef struct place {
    const reach_horizons *horizons;
    size_t x, y; /* of the block */
    double low, high;
    scale scale;
    double drop, up; /* curvature lowers by drop times the square of metres; metres of height in a sample's number */
    ring *rings;
    size_t count, *best; /* the ring before number k that hides most from the highest sample; 0: none */
} place;

static size_t apart(size_t a, size_t b) { return a > b ? a - b : b - a; }

static double least_rise(const place *p, const ring *r, double z) {
    const double d = r->low < z ? r->from : r->to, over = (r->low - z) * p->up / d, fall = p->drop * r->to;
    return over - fall - hair * ((fabs(r->low) + fabs(z)) * p->up / d + fall);
}

static double most_rise(const place *p, double high, const double distance[2], double z) {
    const double fall = p->drop * distance[0];
    return (high - z) * p->up / distance[high < z] - fall +
           hair * ((fabs(high) + fabs(z)) * p->up / distance[0] + fall);
}

static void find_rings(place *p) {
    const reach_blocks *b = p->horizons->blocks;
    for (size_t k = 0; k < p->count; k++) {
        const double middle = (double)(k * REACH_BLOCK), half = 0.5 * REACH_BLOCK;
        p->rings[k] = (ring){INFINITY, -INFINITY, (middle - half) / fmax(p->scale.cells[0], p->scale.cells[1]),
                             (middle + half) * p->scale.diagonal};
    }
    for (size_t y = 0; y < b->down; y++)
        for (size_t x = 0; x < b->across; x++) {
            const size_t dx = apart(x, p->x), dy = apart(y, p->y), k = dx > dy ? dx : dy, at = y * b->across + x;
            const double low = b->holes[at] ? -INFINITY : (double)b->low[at];
            p->rings[k].low = fmin(p->rings[k].low, low);
            p->rings[k].high = fmax(p->rings[k].high, (double)b->high[at]);
        }
    double most = -INFINITY;
    size_t best = 0;
    for (size_t k = 1; k < p->count; k++) {
        p->rings[k].low -= REACH_ROUNDING * fmax(p->rings[k].high - p->rings[k].low, 0);
        p->best[k] = best;
        const double rise = p->rings[k].low > -INFINITY ? least_rise(p, &p->rings[k], p->high) : -INFINITY;
        if (rise > most) {
            most = rise;
            best = k;
        }
    }
}

/* Whether something in block (x, y) may be the horizon of a sample here. */
static bool matters(const place *p, size_t x, size_t y) {
    const reach_horizons *h = p->horizons;
    const size_t dx = apart(x, p->x), dy = apart(y, p->y), k = dx > dy ? dx : dy;
    if (k < 2) return true;
    const double high = cw_reach_highest(h->blocks, x, y);
    if (!(high > -INFINITY)) return false; /* all are holes; edges to the next blocks are theirs too */
    const double gap[2] = {dx > 0 ? (double)(dx - 1) * REACH_BLOCK : 0, dy > 0 ? (double)(dy - 1) * REACH_BLOCK : 0};
    const double distance[2] = {fmax(gap[0] / p->scale.cells[0], gap[1] / p->scale.cells[1]),
                                (double)((k + 1) * REACH_BLOCK) * p->scale.diagonal};
    if (h->above_level && (high - p->low) * p->up <= p->drop * distance[0] * distance[0] * (1 - hair)) return false;
    if (p->best[k] == 0) return true;
    const ring *r = &p->rings[p->best[k]];
    const double heights[4] = {p->low, p->high, fmin(fmax(r->low, p->low), p->high), fmin(fmax(high, p->low), p->high)};
    for (int n = 0; n < 4; n++)
        if (most_rise(p, high, distance, heights[n]) > least_rise(p, r, heights[n])) return true;
    return false;
}

/* Adds what matters to a block, from the outermost blocks on: what lies between is then part of it. */
static void add_block(place *p, cw_rectangle *all) {
    const reach_blocks *b = p->horizons->blocks;
    find_rings(p);
    for (size_t k = p->count; k-- > 0;)
        for (size_t y = p->y > k ? p->y - k : 0; y <= p->y + k && y < b->down; y++)
            for (size_t x = p->x > k ? p->x - k : 0; x <= p->x + k && x < b->across; x++) {
                const cw_rectangle block = cw_reach_block(b, x, y), both = cw_reach_both(*all, block);
                const bool on_ring = apart(x, p->x) == k || apart(y, p->y) == k;
                if (!on_ring && x < p->x + k) x = p->x + k - 1 > x ? p->x + k - 1 : x;
                if (on_ring && memcmp(&both, all, sizeof both) != 0 && matters(p, x, y)) *all = both;
            }
}

static cw_rectangle row_of_blocks(const reach_horizons *h, size_t y) {
    const reach_blocks *b = h->blocks;
    const size_t most = b->across > b->down ? b->across : b->down;
    const cw_rectangle window = h->window;
    cw_rectangle all = {0};
    place p = {.horizons = h, .y = y, .count = most, .scale = scale_of(b->whole, y)};
    p.up = terrain_metres_of_height(b->whole);
    p.drop = h->curvature / (2 * b->whole->radius);
    p.rings = h->rings;
    p.best = h->best;
    for (p.x = window.i / REACH_BLOCK; p.x <= (window.i + window.nx - 1) / REACH_BLOCK; p.x++) {
        const size_t at = y * b->across + p.x;
        p.low = (double)b->low[at];
        p.high = (double)b->high[at];
        if (p.low <= p.high) add_block(&p, &all);
    }
    return all;
}

cw_status cw_reach_horizons_create(const reach_blocks *blocks, cw_rectangle window, double curvature, bool above_level,
                                   reach_horizons *h) {
    const size_t most = blocks->across > blocks->down ? blocks->across : blocks->down;
    *h = (reach_horizons){.blocks = blocks, .window = window, .curvature = curvature, .above_level = above_level};
    h->rows = calloc(blocks->down, sizeof *h->rows);
    h->rings = calloc(most, sizeof(ring));
    h->best = calloc(most, sizeof *h->best);
    if (h->rows && h->rings && h->best) return CW_OK;
    cw_reach_horizons_destroy(h);
    return CW_ERROR_MEMORY;
}

void cw_reach_horizons_destroy(reach_horizons *h) {
    free(h->rows);
    free(h->rings);
    free(h->best);
    *h = (reach_horizons){0};
}

cw_rectangle cw_reach_of_horizons(reach_horizons *h, cw_rectangle part) {
    const terrain *whole = h->blocks->whole;
    cw_rectangle all = part;
    for (size_t y = part.j / REACH_BLOCK; y <= (part.j + part.ny - 1) / REACH_BLOCK; y++) {
        if (!h->rows[y].known) h->rows[y] = (struct reach_row){true, row_of_blocks(h, y)};
        all = cw_reach_both(all, h->rows[y].matters);
    }
    return cw_reach_grow(whole, all, REACH_BESIDE);
}
