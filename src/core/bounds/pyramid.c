/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the pyramid, and repairs it after samples have changed: tiles first, which depend on samples alone, then
 * the levels above them one by one, and last the highest samples of nodes two by two. */

#include "pyramid.h"

#include "fpenv.h"
#include "memory.h"
#include "run.h"
#include "survey.h"

#include <float.h>

static size_t blocks(size_t n) { return (n + 3) / 4; }

/* Nodes of a level, all in. */
typedef cw_tiles nodes;

/* The part to be built again: all of it, or the nodes that depend on some tiles. */
typedef struct pyramid_job {
    cw_field *f;
    struct cw_pyramid *p;
    cw_tiles tiles;
    cw_refusal *refusal;
    int level;
    nodes nodes; /* of that level, or tiles, or bricks: what is worked on */
    void (*one)(const struct pyramid_job *w, size_t x, size_t y);
} pyramid_job;

static size_t across(const nodes *n) { return n->x_last - n->x + 1; }
static size_t count(const nodes *n) { return across(n) * (n->y_last - n->y + 1); }

static void do_each(void *context, size_t begin, size_t end) {
    const pyramid_job *w = context;
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++)
        w->one(w, w->nodes.x + k % across(&w->nodes), w->nodes.y + k / across(&w->nodes));
    fpenv_leave(caller);
}

static void do_tile(const pyramid_job *w, size_t x, size_t y) {
    w->p->holes[y * cw_tiles_across(w->f) + x] = cw_count_holes(w->f, x, y, w->refusal);
    cw_pyramid_tile(w->f, w->p, x, y);
}

static void do_slab(const pyramid_job *w, size_t x, size_t y) { cw_pyramid_node_slab(w->f, w->p, w->level, x, y); }

/* ---- ahead ------------------------------------------------------------------------------------------------------- */

enum { BRICKS_AT_ONCE = 64 };

/* The highest sample of a node; -infinity outside the field, and if all its samples are holes. */
static float node_high(const cw_pyramid_level *l, size_t x, size_t y) {
    if (x >= 4 * (size_t)l->across || y >= 4 * (size_t)l->down) return -INFINITY; /* 0 - 1 is, too */
    return higher(cw_pyramid_node(l, x, y)[16], -INFINITY);
}

/* The numbers of brick (x, y), from the nodes of it and of the bricks before it. */
static void do_ahead(const pyramid_job *w, size_t x, size_t y) {
    const cw_pyramid_level *l = &w->p->level[w->level];
    const size_t across = 4 * (size_t)l->across + 1, down = 4 * (size_t)l->down + 1;
    float high[5][5];
    for (size_t j = 0; j < 5; j++)
        for (size_t i = 0; i < 5; i++) high[j][i] = node_high(l, 4 * x + i - 1, 4 * y + j - 1);
    for (size_t j = 0; j < 4 && 4 * y + j < down; j++)
        for (size_t i = 0; i < 4 && 4 * x + i < across; i++)
            l->ahead[(4 * y + j) * across + 4 * x + i] =
                higher(higher(high[j][i], high[j][i + 1]), higher(high[j + 1][i], high[j + 1][i + 1]));
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

/* Nodes of a level that the tiles, level TILE_LEVEL, reach into. */
static nodes nodes_of(const pyramid_job *w, int level) {
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

/* The bricks whose numbers ahead depend on them: beyond the field's far borders also those of nodes that it does not have. */
static nodes ahead_of(const pyramid_job *w, int level) {
    const cw_pyramid_level *l = &w->p->level[level];
    const nodes n = nodes_of(w, level);
    return (nodes){n.x / 4, n.y / 4,
                   n.x_last + 1 < cw_pyramid_across(w->f, level) ? (n.x_last + 1) / 4 : (size_t)l->across,
                   n.y_last + 1 < cw_pyramid_down(w->f, level) ? (n.y_last + 1) / 4 : (size_t)l->down};
}

static float steepest(const cw_field *f, const struct cw_pyramid *p) {
    const int top = p->levels - 1 > TILE_LEVEL ? p->levels - 1 : TILE_LEVEL;
    double most = 0;
    for (size_t k = 0; k < cw_pyramid_across(f, top) * cw_pyramid_down(f, top); k++)
        most = fmax(p->sum[top][k].steepest, most);
    return (float)most;
}

/* Sets the field's numbers. */
static void total(cw_field *f, struct cw_pyramid *p) {
    const float *brick = p->level[p->levels - 1].bricks;
    float low = FLT_MAX, high = -FLT_MAX;
    for (int k = 0; k < 16; k++) {
        low = lower(brick[k], low);
        high = higher(brick[16 + k], high);
    }
    f->low = low + 0.0f; /* which zero is lowest would depend on the order of samples */
    f->high = p->high = high + 0.0f;
    f->holes = 0;
    for (size_t k = 0; k < cw_tiles_across(f) * cw_tiles_down(f); k++) f->holes += p->holes[k];
    cw_set_reach(f);
}

/* Everything above the tiles, which are done. */
static void do_upper(pyramid_job *w, cw_pool *pool) {
    struct cw_pyramid *p = w->p;
    w->one = do_slab;
    for (w->level = TILE_LEVEL + 1; w->level < p->levels; w->level++) {
        w->nodes = nodes_of(w, w->level);
        for (size_t y = w->nodes.y; y <= w->nodes.y_last; y++)
            for (size_t x = w->nodes.x; x <= w->nodes.x_last; x++)
                cw_pyramid_bound_brick(&p->level[w->level - 1], &p->level[w->level], x, y);
        cw_pool_run(pool, count(&w->nodes), 1, do_each, w);
    }
    w->one = do_ahead;
    for (w->level = 0; w->level < p->levels; w->level++) {
        w->nodes = ahead_of(w, w->level);
        cw_pool_run(pool, count(&w->nodes), BRICKS_AT_ONCE, do_each, w);
    }
    p->steepest = steepest(w->f, p);
    total(w->f, p);
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
               aheads * sizeof(float) + cw_tiles_across(f) * cw_tiles_down(f) * sizeof *p->holes;
    p->memory = cw_memory_allocate(&f->memory, p->bytes);
    if (p->memory == NULL) return false;
    p->slab = (cw_pyramid_slab *)((float *)p->memory + bricks * BRICK_FLOATS);
    cw_pyramid_sum *sum = (cw_pyramid_sum *)(p->slab + slabs);
    float *ahead = (float *)(sum + sums);
    p->holes = (uint32_t *)(ahead + aheads);
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
    pyramid_job w = {
        .f = f, .tiles = {0, 0, cw_tiles_across(f) - 1, cw_tiles_down(f) - 1}, .refusal = &refusal, .one = do_tile};
    w.nodes = w.tiles;
    w.p = cw_memory_clear(&f->memory, sizeof *w.p);
    if (w.p == NULL || !lay_out(w.p, f)) {
        cw_pyramid_destroy(f, w.p);
        return cw_fail_plainly(CW_ERROR_MEMORY);
    }
    clear_upper(w.p);
    cw_status status = cw_run_work(how, count(&w.tiles), TILES_AT_ONCE, TILES_AT_ONCE, do_each, &w);
    if (status == CW_OK) status = cw_refusal_status(f, &refusal);
    if (status != CW_OK) {
        cw_pyramid_destroy(f, w.p);
        return status;
    }
    do_upper(&w, how->pool);
    f->pyramid = w.p;
    return CW_OK;
}

void cw_pyramid_update(cw_field *f, cw_tiles changed, cw_pool *pool) {
    cw_refusal refusal = {CW_REFUSED_NONE}; /* nothing will be: the samples have been checked */
    pyramid_job w = {.f = f, .p = f->pyramid, .tiles = changed, .refusal = &refusal, .nodes = changed, .one = do_tile};
    cw_pool_run(pool, count(&changed), TILES_AT_ONCE, do_each, &w);
    do_upper(&w, pool);
}

void cw_pyramid_destroy(const cw_field *f, struct cw_pyramid *p) {
    if (p == NULL) return;
    cw_memory_free(&f->memory, p->memory);
    cw_memory_free(&f->memory, p);
}
