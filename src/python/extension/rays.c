/* SPDX-License-Identifier: Apache-2.0 */
/* Rays from arrays of any layout; points and normals of hits. */
#include "extension.h"

#include <string.h>

enum { ORIGIN, DIRECTION, TMIN, TMAX, OPERANDS };

/* Number k of an operand is at + k * step bytes; step 0 is one for all. */
typedef struct tracing {
    const py_field *field;
    const char *at[OPERANDS];
    Py_ssize_t step[OPERANDS];
    bool wide;  /* operands are double, else float */
    bool user;  /* rays go to the library in user space, as doubles; else as they are, user space being field space */
    cw_run run; /* of a block */
    cw_hit *hits;
    uint8_t *any;
    work *work;
    size_t n;
    atomic_size_t done;
    atomic_int status;
} tracing;

enum { BLOCK = 512, PIECE = 8 * BLOCK };

static inline const char *operand(const tracing *t, int which, size_t k) {
    return t->at[which] + (Py_ssize_t)k * t->step[which];
}

/* count rays of eight numbers of so many bytes, a constant, as cw_ray and cw_user_ray have them. */
static inline void gather(const tracing *t, size_t begin, size_t count, size_t size, char *to) {
    for (size_t k = 0; k < count; k++, to += 8 * size) {
        memcpy(to, operand(t, ORIGIN, begin + k), 3 * size);
        memcpy(to + 3 * size, operand(t, TMIN, begin + k), size);
        memcpy(to + 4 * size, operand(t, DIRECTION, begin + k), 3 * size);
        memcpy(to + 7 * size, operand(t, TMAX, begin + k), size);
    }
}

/* count rays, of which the first is number begin of all. */
static cw_status trace_rays(const tracing *t, const cw_run *run, const void *rays, size_t begin, size_t count) {
    const cw_field *f = t->field->field;
    cw_hit *hits = t->hits ? t->hits + begin : NULL;
    uint8_t *any = t->any ? t->any + begin : NULL;
    if (t->user) return hits ? cw_closest_user(f, run, rays, count, hits) : cw_occluded_user(f, run, rays, count, any);
    return hits ? cw_closest(f, run, rays, count, hits) : cw_occluded(f, run, rays, count, any);
}

static void trace_blocks(void *context, size_t begin, size_t end) {
    tracing *t = context;
    double user[8 * BLOCK];
    float own[8 * BLOCK];
    while (begin < end) {
        const size_t count = end - begin < BLOCK ? end - begin : BLOCK;
        if (t->wide)
            gather(t, begin, count, sizeof *user, (char *)user);
        else
            gather(t, begin, count, sizeof *own, (char *)own);
        for (size_t k = 0; k < 8 * count && t->user && !t->wide; k++) user[k] = (double)own[k];
        const cw_status status = trace_rays(t, &t->run, t->user ? (void *)user : (void *)own, begin, count);
        if (status != CW_OK) atomic_store(&t->status, (int)status);
        const size_t done = atomic_fetch_add(&t->done, count) + count;
        if (!work_watch(t->work, (double)done / (double)t->n)) return;
        begin += count;
    }
}

/* Rays that lie in memory as the library has them go there as they are. */
static bool is_packed(const tracing *t) {
    const size_t size = t->wide ? sizeof(double) : sizeof(float);
    static const size_t place[OPERANDS] = {0, 4, 3, 7};
    if (t->user != t->wide || (uintptr_t)t->at[ORIGIN] % size != 0) return false;
    for (int k = 0; k < OPERANDS; k++)
        if (t->step[k] != (Py_ssize_t)(8 * size) || t->at[k] != t->at[ORIGIN] + place[k] * size) return false;
    return true;
}

/* Takes n rows of three numbers, or n numbers, with any step between them. */
static bool take_operand(call *c, tracing *t, int which) {
    static const char *const names[OPERANDS] = {"origins", "directions", "tmin", "tmax"};
    const Py_buffer *b = &c->in[which];
    const int ranks = which <= DIRECTION ? 2 : 1;
    const Py_ssize_t size = t->wide ? sizeof(double) : sizeof(float);
    t->at[which] = b->buf;
    t->step[which] = b->strides[0];
    if (b->itemsize == size && b->ndim == ranks && b->shape[0] == (Py_ssize_t)t->n &&
        (ranks == 1 || (b->shape[1] == 3 && b->strides[1] == size)))
        return true;
    call_fail(c, "%s: not as many numbers as there are rays", names[which]);
    return false;
}

/* Inputs: origins and directions as rows of three, tmin and tmax, all of them floats or doubles. Output: a hit for each, or a byte. */
static cw_status trace(call *c, bool any) {
    const py_field *f = c->field;
    tracing t = {.field = f, .work = &c->work, .run = c->work.run};
    void *out = call_output(c, 0, 0);
    if (out == NULL || c->in_count != OPERANDS) return call_fail(c, "rays: expected four operands");
    t.n = (size_t)c->out[0].len / (any ? 1 : sizeof(cw_hit));
    t.wide = c->in[ORIGIN].itemsize == sizeof(double);
    t.user = t.wide || !f->identity;
    t.any = any ? out : NULL;
    t.hits = any ? NULL : out;
    for (int k = 0; k < OPERANDS; k++)
        if (!take_operand(c, &t, k)) return CW_ERROR_ARGUMENT;
    if (t.n == 0) return CW_OK;
    if (is_packed(&t)) return trace_rays(&t, &c->work.run, t.at[ORIGIN], 0, t.n);
    t.run.pool = NULL;
    t.run.watch = NULL;
    /* A pool's threads are woken only for as many rays as the library wakes them for. */
    cw_pool_run(t.n < 2 * BLOCK ? NULL : c->work.run.pool, t.n, t.n < (size_t)PIECE * 64 ? BLOCK : PIECE, trace_blocks,
                &t);
    return (cw_status)atomic_load(&t.status);
}

cw_status make_closest(call *c) { return trace(c, false); }
cw_status make_occluded(call *c) { return trace(c, true); }

/* Input: points of the map, of which z does not count. Outputs: room for as many hits, and the points on the surface. */
cw_status make_heights(call *c) {
    const py_field *f = c->field;
    size_t n;
    const double(*places)[3] = call_input(c, 0, sizeof *places, &n);
    cw_hit *hits = call_output(c, 0, n * sizeof *hits);
    double(*points)[3] = call_output(c, 1, n * sizeof *points);
    if (f->map[0][2] != 0 || f->map[1][2] != 0)
        return call_fail(c, "transform: leans the heights, so that no single place is above x and y");
    if (hits == NULL || points == NULL) return CW_ERROR_ARGUMENT;
    if (!work_part(&c->work, 0, 0.5)) return CW_ERROR_CANCELLED;
    const cw_status status = cw_surface_at_user(f->field, &c->work.run, *places, n, hits);
    if (status != CW_OK || !work_part(&c->work, 0.5, 0.5)) return status;
    return cw_hit_points(f->field, &c->work.run, hits, n, *points);
}

/* Input: records as closest makes them. Output: three doubles for each, of the kind. */
cw_status make_points(call *c) {
    enum { POINTS, NORMALS, SMOOTH_NORMALS };
    const cw_field *f = c->field->field;
    const cw_run *run = &c->work.run;
    size_t n;
    const cw_hit *hits = call_input(c, 0, sizeof *hits, &n);
    double *out = call_output(c, 0, n * 3 * sizeof *out);
    if (out == NULL) return CW_ERROR_ARGUMENT;
    return c->n.kind == POINTS    ? cw_hit_points(f, run, hits, n, out)
           : c->n.kind == NORMALS ? cw_hit_normals(f, run, hits, n, out)
                                  : cw_hit_phong_normals(f, run, hits, n, out);
}
