/* SPDX-License-Identifier: Apache-2.0 */
/* Builds the pyramid, and repairs it after samples have changed: tiles first, which depend on samples alone, then the
 * levels above them one by one, and last the highest samples of nodes two by two. Samples that are holes or refused are
 * found with the tiles. So the number of holes is found again in little time when some samples change. */

#include "pyramid.h"

#include "fpenv.h"
#include "memory.h"
#include "run.h"

#include <float.h>
#include <stdatomic.h>

/* Nodes x to x_last, y to y_last of a level, all in. */
typedef struct nodes {
    size_t x, y, x_last, y_last;
} nodes;

/* The part to be built again: all of it, or the nodes that depend on some tiles. */
typedef struct pyramid_job {
    cw_field *f;
    struct cw_pyramid *p;
    nodes tiles;
    int level;
    nodes nodes; /* of that level, or tiles, or bricks: what is worked on */
    void (*one)(struct pyramid_job *w, size_t x, size_t y);
    atomic_uint_least64_t
        refused; /* number of the first sample in the order of rows that is, for any number of threads */
} pyramid_job;

static size_t across(const nodes *n) { return n->x_last - n->x + 1; }
static size_t count(const nodes *n) { return across(n) * (n->y_last - n->y + 1); }

static size_t nodes_in(const cw_field *f, int level) { return cw_pyramid_across(f, level) * cw_pyramid_down(f, level); }

/* ---- samples ----------------------------------------------------------------------------------------------------- */

static cw_status fail_sample(size_t i, size_t j, float z) {
    return cw_fail(CW_ERROR_SAMPLE, "sample (%zu, %zu) is %g; %s", i, j, (double)z,
                   isfinite(z) ? "heights lie within plus or minus 2^100" : "borrowed samples mark holes by NaN alone");
}

/* True if one of n samples is no height. Without a branch, so that compilers vectorize it. */
static bool some_odd(const float *z, size_t n) {
    int32_t odd = 0;
    for (size_t k = 0; k < n; k++) odd |= !(fabsf(z[k]) <= CW_HEIGHT_MAX);
    return odd != 0;
}

cw_status cw_check_samples(const float *z, size_t i, size_t j, size_t n, bool infinities) {
    const bool odd = some_odd(z, n);
    for (size_t k = 0; odd && k < n; k++)
        if (fabsf(z[k]) > CW_HEIGHT_MAX && !(infinities && isinf(z[k]))) return fail_sample(i + k, j, z[k]);
    return CW_OK;
}

static void refuse(pyramid_job *w, uint64_t number) {
    uint64_t first = atomic_load(&w->refused);
    while (number < first && !atomic_compare_exchange_weak(&w->refused, &first, number)) continue;
}

/* Holes among the samples that tile (x, y) owns: each sample is owned by one tile, the one in which it is not on the
 * last row or column, if there is one. Also finds refused ones. */
static uint32_t count_holes(pyramid_job *w, size_t x, size_t y) {
    const cw_field *f = w->f;
    const size_t begin = x * TILE_SIDE, end = x + 1 < cw_pyramid_across(f, TILE_LEVEL) ? begin + TILE_SIDE : f->nx;
    const size_t row = y * TILE_SIDE, row_end = y + 1 < cw_pyramid_down(f, TILE_LEVEL) ? row + TILE_SIDE : f->ny;
    uint32_t holes = 0;
    for (size_t j = row; j < row_end; j++) {
        const float *z = f->z + j * f->stride;
        for (size_t i = some_odd(z + begin, end - begin) ? begin : end; i < end; i++)
            if (isnan(z[i]))
                holes++;
            else if (fabsf(z[i]) > CW_HEIGHT_MAX)
                refuse(w, (uint64_t)j * f->nx + i);
    }
    return holes;
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

static void do_each(void *context, size_t begin, size_t end) {
    pyramid_job *w = context;
    const fpenv caller = fpenv_enter();
    for (size_t k = begin; k < end; k++)
        w->one(w, w->nodes.x + k % across(&w->nodes), w->nodes.y + k / across(&w->nodes));
    fpenv_leave(caller);
}

static void do_tile(pyramid_job *w, size_t x, size_t y) {
    w->p->holes[y * cw_pyramid_across(w->f, TILE_LEVEL) + x] = count_holes(w, x, y);
    cw_pyramid_tile(w->f, w->p, x, y);
}

static void do_slab(pyramid_job *w, size_t x, size_t y) { cw_pyramid_node_slab(w->f, w->p, w->level, x, y); }

/* ---- ahead ------------------------------------------------------------------------------------------------------- */

enum { BRICKS_AT_ONCE = 64 };

/* The highest sample of a node; -infinity outside the field, and if all its samples are holes. */
static float node_high(const cw_pyramid_level *l, size_t x, size_t y) {
    if (x >= 4 * (size_t)l->across || y >= 4 * (size_t)l->down) return -INFINITY; /* 0 - 1 is, too */
    return higher(cw_pyramid_node(l, x, y)[16], -INFINITY);
}

/* The numbers of brick (x, y), from the nodes of it and of the bricks before it. */
static void do_ahead(pyramid_job *w, size_t x, size_t y) {
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
    const nodes *t = &w->tiles;
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

/* The bricks whose numbers ahead depend on them: beyond the field's far borders also those of nodes that it lacks. */
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
    for (size_t k = 0; k < nodes_in(f, top); k++) most = fmax(p->sum[top][k].steepest, most);
    return (float)most;
}

/* The field's box. And from farther away than reach, a ray's origin would add more to errors than the field itself
 * does: half a side's length outside the field; and eight times its range of heights above or below, as rays from a
 * camera above should count as near. */
static void set_box(cw_field *f) {
    const float range = f->high - f->low;
    for (int c = 0; c < 2; c++) {
        f->last[c] = f->reach[c] = (float)((c == 0 ? f->nx : f->ny) - 1);
        f->middle[c] = 0.5f * f->last[c];
    }
    f->middle[2] = range >= 0 ? 0.5f * (f->low + f->high) : 0;
    f->reach[2] = range > 0 ? 8 * range : INFINITY; /* on a level field, or none, heights cost no accuracy */
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
    for (size_t k = 0; k < nodes_in(f, TILE_LEVEL); k++) f->holes += p->holes[k];
    set_box(f);
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

/* Sets where everything lies in one piece of memory that begins at base; returns its bytes. */
static size_t lay_out(struct cw_pyramid *p, const cw_field *f, uintptr_t base) {
    uintptr_t at = base;
    cw_pyramid_level *l;
    p->levels = 0;
    do {
        l = &p->level[p->levels++];
        l->bricks = (float *)at;
        l->across = (int32_t)cw_pyramid_across(f, p->levels); /* a brick is a node of the next level */
        l->down = (int32_t)cw_pyramid_down(f, p->levels);
        l->side = (float)((size_t)1 << 2 * p->levels);
        at += nodes_in(f, p->levels) * BRICK_FLOATS * sizeof *l->bricks;
    } while (l->across > 1 || l->down > 1);
    p->slab = (cw_pyramid_slab *)at;
    for (int k = 0; k < p->levels; k++) {
        p->first[k + 1] = (int32_t)((at - (uintptr_t)p->slab) / sizeof *p->slab);
        at += nodes_in(f, k) * sizeof *p->slab;
    }
    for (int k = TILE_LEVEL; k < p->levels || k == TILE_LEVEL; k++) {
        p->sum[k] = (cw_pyramid_sum *)at;
        at += nodes_in(f, k) * sizeof *p->sum[k];
    }
    for (l = p->level; l < p->level + p->levels; l++) {
        l->ahead = (float *)at;
        at += (4 * (size_t)l->across + 1) * (4 * (size_t)l->down + 1) * sizeof *l->ahead;
    }
    p->holes = (uint32_t *)at;
    return at + nodes_in(f, TILE_LEVEL) * sizeof *p->holes - base;
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

/* The work on those that have some of the samples, be it on the border. */
static pyramid_job tile_job(cw_field *f, const cw_rectangle *at, struct cw_pyramid *p) {
    const size_t x = (at->i + at->nx - 1) / TILE_SIDE, y = (at->j + at->ny - 1) / TILE_SIDE;
    const nodes tiles = {(at->i > 0 ? at->i - 1 : 0) / TILE_SIDE, (at->j > 0 ? at->j - 1 : 0) / TILE_SIDE,
                         least(x, cw_pyramid_across(f, TILE_LEVEL) - 1), least(y, cw_pyramid_down(f, TILE_LEVEL) - 1)};
    return (pyramid_job){.f = f, .p = p, .tiles = tiles, .nodes = tiles, .one = do_tile, .refused = UINT64_MAX};
}

cw_status cw_pyramid_build(cw_field *f, const cw_run *how) {
    struct cw_pyramid *p = cw_memory_clear(&f->memory, sizeof *p);
    if (p != NULL) {
        p->bytes = lay_out(p, f, 0);
        p->memory = cw_memory_allocate(&f->memory, p->bytes);
    }
    if (p == NULL || p->memory == NULL) {
        cw_pyramid_destroy(f, p);
        return cw_fail_plainly(CW_ERROR_MEMORY);
    }
    lay_out(p, f, (uintptr_t)p->memory);
    clear_upper(p);
    pyramid_job w = tile_job(f, &(cw_rectangle){0, 0, f->nx, f->ny}, p);
    cw_status status = cw_run_work(how, count(&w.tiles), TILES_AT_ONCE, TILES_AT_ONCE, do_each, &w);
    if (status == CW_OK && w.refused != UINT64_MAX) {
        const size_t i = w.refused % f->nx, j = w.refused / f->nx;
        status = fail_sample(i, j, f->z[j * f->stride + i]);
    }
    if (status != CW_OK) {
        cw_pyramid_destroy(f, p);
        return status;
    }
    do_upper(&w, how->pool);
    f->pyramid = p;
    return CW_OK;
}

void cw_pyramid_update(cw_field *f, const cw_rectangle *at, cw_pool *pool) {
    pyramid_job w = tile_job(f, at, f->pyramid);
    cw_pool_run(pool, count(&w.tiles), TILES_AT_ONCE, do_each, &w);
    do_upper(&w, pool);
}

void cw_pyramid_destroy(const cw_field *f, struct cw_pyramid *p) {
    if (p == NULL) return;
    cw_memory_free(&f->memory, p->memory);
    cw_memory_free(&f->memory, p);
}
