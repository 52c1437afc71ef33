/* SPDX-License-Identifier: Apache-2.0 */
#include "extension.h"

#include <string.h>

enum { BLOCK = 512, PIECE = 8 * BLOCK };

typedef struct tracing {
    const rays *rays;
    const cw_field *field;
    work *work;
    cw_run run; /* of a block */
    cw_hit *hits;
    uint8_t *any;
    atomic_size_t done;
    atomic_int status;
} tracing;

static inline const char *operand(const rays *r, int which, size_t k) {
    return (const char *)r->at[which] + (ptrdiff_t)k * r->step[which];
}

/* count rays of eight numbers of so many bytes, a constant, as cw_ray and cw_user_ray have them. */
static inline void gather(const rays *r, size_t begin, size_t count, size_t size, char *to) {
    for (size_t k = begin; k < begin + count; k++, to += 8 * size) {
        memcpy(to, operand(r, RAYS_ORIGIN, k), 3 * size);
        memcpy(to + 3 * size, operand(r, RAYS_TMIN, k), size);
        memcpy(to + 4 * size, operand(r, RAYS_DIRECTION, k), 3 * size);
        memcpy(to + 7 * size, operand(r, RAYS_TMAX, k), size);
    }
}

/* count rays, of which the first is number begin of all. */
static cw_status trace(const tracing *t, const cw_run *run, const void *from, size_t begin, size_t count) {
    const cw_field *f = t->field;
    cw_hit *hits = t->hits ? t->hits + begin : NULL;
    uint8_t *any = t->any ? t->any + begin : NULL;
    if (t->rays->user)
        return hits ? cw_closest_user(f, run, from, count, hits) : cw_occluded_user(f, run, from, count, any);
    return hits ? cw_closest(f, run, from, count, hits) : cw_occluded(f, run, from, count, any);
}

static void trace_blocks(void *context, size_t begin, size_t end) {
    tracing *t = context;
    const rays *r = t->rays;
    double user[8 * BLOCK];
    float own[8 * BLOCK];
    while (begin < end) {
        const size_t count = end - begin < BLOCK ? end - begin : BLOCK;
        if (r->wide)
            gather(r, begin, count, sizeof *user, (char *)user);
        else
            gather(r, begin, count, sizeof *own, (char *)own);
        for (size_t k = 0; k < 8 * count && r->user && !r->wide; k++) user[k] = (double)own[k];
        const cw_status status = trace(t, &t->run, r->user ? (void *)user : (void *)own, begin, count);
        if (status != CW_OK) atomic_store(&t->status, (int)status);
        const size_t done = atomic_fetch_add(&t->done, count) + count;
        if (!work_watch(t->work, (double)done / (double)r->n)) return;
        begin += count;
    }
}

/* Rays that lie in memory as the library has them go there as they are. */
static bool is_packed(const rays *r) {
    const size_t size = r->wide ? sizeof(double) : sizeof(float);
    static const size_t place[RAYS_OPERANDS] = {0, 4, 3, 7};
    if (r->user != r->wide || r->at[RAYS_ORIGIN] % size != 0) return false;
    for (int k = 0; k < RAYS_OPERANDS; k++)
        if (r->step[k] != (ptrdiff_t)(8 * size) || r->at[k] != r->at[RAYS_ORIGIN] + place[k] * size) return false;
    return true;
}

cw_status rays_trace(const rays *r, const cw_field *field, work *w, cw_hit *hits, uint8_t *any) {
    tracing t = {.rays = r, .field = field, .work = w, .run = w->run, .hits = hits, .any = any};
    if (r->n == 0) return CW_OK;
    if (is_packed(r)) return trace(&t, &w->run, (const void *)r->at[RAYS_ORIGIN], 0, r->n);
    t.run.pool = NULL;
    t.run.watch = NULL;
    /* A pool's threads are woken only for as many rays as the library wakes them for. */
    cw_pool_run(r->n < 2 * BLOCK ? NULL : w->run.pool, r->n, r->n < (size_t)PIECE * 64 ? BLOCK : PIECE, trace_blocks,
                &t);
    if (atomic_load(&t.status) != CW_OK) trace_blocks(&t, 0, 1); /* fails alike, with the text in this thread */
    return (cw_status)atomic_load(&t.status);
}
