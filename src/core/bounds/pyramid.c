/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the pyramid, and repairs it after samples have changed: tiles first, which depend on samples alone, then
 * the levels above them one by one, and last the highest samples of nodes two by two. */

#include "pyramid.h"

#include "fpenv.h"
#include "memory.h"
#include "run.h"
#include "survey.h"

#include <stdlib.h>

static size_t blocks(size_t n) { return (n + 3) / 4; }
static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Nodes of a level, all in. */
typedef cw_tiles nodes;

/* The part to be built again: all of it, or the nodes that depend on some tiles. */
typedef struct job {
    cw_field *f;
    struct cw_pyramid *p;
    cw_tiles tiles;
    cw_refusal *refusal;
    int level;
    nodes nodes; /* of that level */
} job;

static size_t across(const nodes *n) { return n->x_last - n->x + 1; }
static size_t count(const nodes *n) { return across(n) * (n->y_last - n->y + 1); }

static void do_tiles(void *context, size_t begin, size_t end) {
    const job *w = context;
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++) {
        const size_t x = w->tiles.x + k % across(&w->tiles), y = w->tiles.y + k / across(&w->tiles);
        cw_survey_tile(w->f, x, y, w->refusal);
        cw_pyramid_tile(w->f, w->p, x, y);
    }
    fpenv_leave(caller);
}

static void do_slabs(void *context, size_t begin, size_t end) {
    const job *w = context;
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++)
        cw_pyramid_node_slab(w->f, w->p, w->level, w->nodes.x + k % across(&w->nodes),
                             w->nodes.y + k / across(&w->nodes));
    fpenv_leave(caller);
}

/* ---- ahead ------------------------------------------------------------------------------------------------------- */

enum { AHEAD = 256 }; /* numbers a side that are done at a time */

/* Numbers begin to end of a row of them, from row y of nodes alone: the higher of two neighbours. */
static void highest_of_two(const cw_pyramid_level *l, size_t y, size_t begin, size_t end, float *restrict to) {
    float high[4 + AHEAD + 12]; /* whole bricks, and something lower than all to either side */
    const size_t first = begin >= 1 ? (begin - 1) / 4 : 0, last = least((end - 1) / 4 + 1, (size_t)l->across);
    for (size_t b = first; b < last; b++) {
        const float *from = cw_pyramid_node(l, 4 * b, y) + 16;
        for (size_t k = 0; k < 4; k++) high[4 + 4 * (b - first) + k] = from[k];
    }
    high[3] = high[4 + 4 * (last - first)] = -INFINITY;
    const float *restrict at = high + 4 + begin - 4 * first;
    for (size_t k = 0; k < end - begin; k++)
        to[k] = higher(at[k], higher(at[(ptrdiff_t)k - 1], -INFINITY)); /* a node of holes alone is NaN */
}

/* Separable: the higher of two nodes in a row, then of two such rows. */
static void do_ahead_part(const cw_pyramid_level *l, const nodes *part) {
    float rows[2][AHEAD];
    const size_t n = 4 * (size_t)l->across + 1, down = 4 * (size_t)l->down, begin = part->x, end = part->x_last + 1;
    for (size_t y = part->y; y <= part->y_last + 1; y++) { /* row y - 1 of nodes */
        float *here = rows[y % 2];
        if (1 <= y && y <= down) {
            highest_of_two(l, y - 1, begin, end, here);
        } else {
            for (size_t x = 0; x < end - begin; x++) here[x] = -INFINITY;
        }
        if (y == part->y) continue;
        const float *before = rows[(y + 1) % 2];
        float *out = l->ahead + (y - 1) * n + begin;
        for (size_t x = 0; x < end - begin; x++) out[x] = higher(before[x], here[x]);
    }
}

static size_t parts(size_t first, size_t last) { return (last - first) / AHEAD + 1; }

static void do_ahead(void *context, size_t begin, size_t end) {
    const job *w = context;
    const nodes *all = &w->nodes;
    const size_t in_row = parts(all->x, all->x_last);
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++) {
        nodes part = {.x = all->x + k % in_row * AHEAD, .y = all->y + k / in_row * AHEAD};
        part.x_last = least(part.x + AHEAD - 1, all->x_last);
        part.y_last = least(part.y + AHEAD - 1, all->y_last);
        do_ahead_part(&w->p->level[w->level], &part);
    }
    fpenv_leave(caller);
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

/* Nodes of a level that the tiles, level TILE_LEVEL, reach into. */
static nodes nodes_of(const job *w, int level) {
    const cw_tiles *t = &w->tiles;
    if (level >= TILE_LEVEL) {
        const int up = 2 * (level - TILE_LEVEL);
        return (nodes){t->x >> up, t->y >> up, t->x_last >> up, t->y_last >> up};
    }
    const int down = 2 * (TILE_LEVEL - level);
    nodes n = {t->x << down, t->y << down, ((t->x_last + 1) << down) - 1, ((t->y_last + 1) << down) - 1};
    n.x_last = least(n.x_last, cw_pyramid_across(w->f, level) - 1);
    n.y_last = least(n.y_last, cw_pyramid_down(w->f, level) - 1);
    return n;
}

/* The numbers that depend on them; bricks at the field's far borders have more nodes than the field. */
static nodes ahead_of(const job *w, int level) {
    const cw_pyramid_level *l = &w->p->level[level];
    nodes n = nodes_of(w, level);
    n.x_last = n.x_last + 1 < cw_pyramid_across(w->f, level) ? n.x_last + 1 : 4 * (size_t)l->across;
    n.y_last = n.y_last + 1 < cw_pyramid_down(w->f, level) ? n.y_last + 1 : 4 * (size_t)l->down;
    return n;
}

static float steepest(const cw_field *f, const struct cw_pyramid *p) {
    const int top = p->levels - 1 > TILE_LEVEL ? p->levels - 1 : TILE_LEVEL;
    double most = 0;
    for (size_t k = 0; k < cw_pyramid_across(f, top) * cw_pyramid_down(f, top); k++)
        most = fmax(p->sum[top][k].steepest, most);
    return (float)most;
}

/* Everything above the tiles, which are done. */
static void do_upper(job *w, cw_pool *pool) {
    struct cw_pyramid *p = w->p;
    for (w->level = TILE_LEVEL + 1; w->level < p->levels; w->level++) {
        w->nodes = nodes_of(w, w->level);
        for (size_t y = w->nodes.y; y <= w->nodes.y_last; y++)
            for (size_t x = w->nodes.x; x <= w->nodes.x_last; x++)
                cw_pyramid_bound_brick(&p->level[w->level - 1], &p->level[w->level], x, y);
        cw_pool_run(pool, count(&w->nodes), 1, do_slabs, w);
    }
    for (w->level = 0; w->level < p->levels; w->level++) {
        w->nodes = ahead_of(w, w->level);
        cw_pool_run(pool, parts(w->nodes.x, w->nodes.x_last) * parts(w->nodes.y, w->nodes.y_last), 1, do_ahead, w);
    }
    p->steepest = steepest(w->f, p);
    p->high = w->f->high;
}

/* Where everything lies in one piece of memory. */
static bool lay_out(struct cw_pyramid *p, const cw_field *f) {
    size_t bricks = 0, aheads = 0, first_brick[PYRAMID_LEVELS_MAX], first_ahead[PYRAMID_LEVELS_MAX];
    size_t x = blocks(f->nx - 1), y = blocks(f->ny - 1);
    float side = 4;
    do {
        cw_pyramid_level *l = &p->level[p->levels];
        x = blocks(x);
        y = blocks(y);
        *l = (cw_pyramid_level){.across = (int32_t)x, .down = (int32_t)y, .side = side};
        first_brick[p->levels] = bricks;
        first_ahead[p->levels++] = aheads;
        bricks += x * y;
        aheads += (4 * x + 1) * (4 * y + 1);
        side *= 4;
    } while (x > 1 || y > 1);

    size_t slabs = 0, sums = 0;
    for (int l = 0; l < p->levels; l++) {
        p->first[l + 1] = (int32_t)slabs;
        slabs += cw_pyramid_across(f, l) * cw_pyramid_down(f, l);
    }
    for (int l = TILE_LEVEL; l < p->levels || l == TILE_LEVEL; l++)
        sums += cw_pyramid_across(f, l) * cw_pyramid_down(f, l);
    p->bytes = bricks * BRICK_FLOATS * sizeof(float) + slabs * sizeof(cw_pyramid_slab) + sums * sizeof(cw_pyramid_sum) +
               aheads * sizeof(float);
    p->memory = cw_memory_allocate(&f->memory, p->bytes);
    if (p->memory == NULL) return false;
    p->slab = (cw_pyramid_slab *)((float *)p->memory + bricks * BRICK_FLOATS);
    cw_pyramid_sum *sum = (cw_pyramid_sum *)(p->slab + slabs);
    float *ahead = (float *)(sum + sums);
    for (int l = 0; l < p->levels; l++) {
        p->level[l].bricks = (float *)p->memory + first_brick[l] * BRICK_FLOATS;
        p->level[l].ahead = ahead + first_ahead[l];
    }
    for (int l = TILE_LEVEL; l < p->levels || l == TILE_LEVEL; l++) {
        p->sum[l] = sum;
        sum += cw_pyramid_across(f, l) * cw_pyramid_down(f, l);
    }
    return true;
}

/* Bricks from the tiles' level on belong to several tiles; those of lower levels are theirs alone. */
static void clear_upper(struct cw_pyramid *p) {
    for (int l = TILE_LEVEL; l < p->levels; l++) {
        const size_t floats = (size_t)p->level[l].across * (size_t)p->level[l].down * BRICK_FLOATS;
        for (size_t k = 0; k < floats; k++) p->level[l].bricks[k] = NAN;
    }
}

/* Tiles that a thread takes at a time: neighbours in a row, which share cache lines. */
enum { TILES_AT_ONCE = 4 };

cw_status cw_pyramid_build(cw_field *f, const cw_run *how) {
    cw_refusal refusal = {CW_REFUSED_NONE};
    job w = {.f = f, .tiles = {0, 0, cw_tiles_across(f) - 1, cw_tiles_down(f) - 1}, .refusal = &refusal};
    w.p = cw_memory_clear(&f->memory, sizeof *w.p);
    if (w.p == NULL || !lay_out(w.p, f)) {
        cw_pyramid_destroy(f, w.p);
        return cw_fail_plainly(CW_ERROR_MEMORY);
    }
    clear_upper(w.p);
    cw_status status = cw_run_work(how, count(&w.tiles), TILES_AT_ONCE, TILES_AT_ONCE, do_tiles, &w);
    if (status == CW_OK) status = cw_refusal_status(f, &refusal);
    if (status != CW_OK) {
        cw_pyramid_destroy(f, w.p);
        return status;
    }
    cw_survey_total(f, w.tiles);
    do_upper(&w, how->pool);
    f->pyramid = w.p;
    return CW_OK;
}

void cw_pyramid_update(cw_field *f, cw_tiles changed, cw_pool *pool) {
    cw_refusal refusal = {CW_REFUSED_NONE}; /* nothing will be: the samples have been checked */
    job w = {.f = f, .p = f->pyramid, .tiles = changed, .refusal = &refusal};
    cw_pool_run(pool, count(&changed), TILES_AT_ONCE, do_tiles, &w);
    cw_survey_total(f, changed);
    do_upper(&w, pool);
}

void cw_pyramid_destroy(const cw_field *f, struct cw_pyramid *p) {
    if (p == NULL) return;
    cw_memory_free(&f->memory, p->memory);
    cw_memory_free(&f->memory, p);
}
