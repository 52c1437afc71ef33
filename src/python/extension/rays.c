/* SPDX-License-Identifier: Apache-2.0 */
/* Rays from arrays of any layout; points and normals of hits. */
#include "field_object.h"

#include <math.h>
#include <string.h>

/* An operand of rays: number k of it is at + k * step bytes; step 0 is one for all. */
typedef struct operand {
    Py_buffer buffer;
    Py_ssize_t offset, step;
} operand;

enum { ORIGIN, DIRECTION, TMIN, TMAX, OPERANDS };

typedef struct tracing {
    const py_field *field;
    const char *at[OPERANDS];
    size_t step[OPERANDS];
    bool wide;  /* operands are double, else float */
    cw_run run; /* of a block */
    cw_hit *hits;
    uint8_t *any;
    work *work;
    size_t n;
    atomic_size_t done;
    atomic_int status;
} tracing;

enum { BLOCK = 512, PIECE = 8 * BLOCK };

static inline double number(const tracing *t, int which, size_t k, size_t component) {
    const char *at = t->at[which] + k * t->step[which];
    if (t->wide) {
        double x;
        memcpy(&x, at + component * sizeof x, sizeof x);
        return x;
    }
    float x;
    memcpy(&x, at + component * sizeof x, sizeof x);
    return (double)x;
}

static void gather(const tracing *t, size_t begin, size_t count, cw_user_ray *to) {
    for (size_t k = 0; k < count; k++)
        for (size_t c = 0; c < 3; c++) {
            to[k].org[c] = number(t, ORIGIN, begin + k, c);
            to[k].dir[c] = number(t, DIRECTION, begin + k, c);
        }
    for (size_t k = 0; k < count; k++) {
        to[k].tmin = number(t, TMIN, begin + k, 0);
        to[k].tmax = number(t, TMAX, begin + k, 0);
    }
}

/* Floats are not widened on the way where user space is field space. */
static void gather_floats(const tracing *t, size_t begin, size_t count, cw_ray *to) {
    for (size_t k = 0; k < count; k++) {
        const size_t n = begin + k;
        memcpy(to[k].org, t->at[ORIGIN] + n * t->step[ORIGIN], sizeof to[k].org);
        memcpy(to[k].dir, t->at[DIRECTION] + n * t->step[DIRECTION], sizeof to[k].dir);
        memcpy(&to[k].tmin, t->at[TMIN] + n * t->step[TMIN], sizeof to[k].tmin);
        memcpy(&to[k].tmax, t->at[TMAX] + n * t->step[TMAX], sizeof to[k].tmax);
    }
}

static cw_status trace_block(const tracing *t, size_t begin, size_t count) {
    const cw_field *f = t->field->field;
    cw_hit *hits = t->hits ? t->hits + begin : NULL;
    uint8_t *any = t->any ? t->any + begin : NULL;
    if (!t->wide && t->field->identity) {
        cw_ray rays[BLOCK];
        gather_floats(t, begin, count, rays);
        return hits ? cw_closest(f, &t->run, rays, count, hits) : cw_occluded(f, &t->run, rays, count, any);
    }
    cw_user_ray rays[BLOCK];
    gather(t, begin, count, rays);
    return hits ? cw_closest_user(f, &t->run, rays, count, hits) : cw_occluded_user(f, &t->run, rays, count, any);
}

static void trace_blocks(void *context, size_t begin, size_t end) {
    tracing *t = context;
    while (begin < end) {
        const size_t count = end - begin < BLOCK ? end - begin : BLOCK;
        const cw_status status = trace_block(t, begin, count);
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
    if ((uintptr_t)t->at[ORIGIN] % size != 0) return false;
    for (int k = 0; k < OPERANDS; k++)
        if (t->step[k] != 8 * size || t->at[k] != t->at[ORIGIN] + place[k] * size) return false;
    return true;
}

static cw_status trace_packed(const tracing *t, const cw_run *run) {
    const cw_field *f = t->field->field;
    const void *rays = t->at[ORIGIN];
    if (t->wide)
        return t->hits ? cw_closest_user(f, run, rays, t->n, t->hits) : cw_occluded_user(f, run, rays, t->n, t->any);
    return t->hits ? cw_closest(f, run, rays, t->n, t->hits) : cw_occluded(f, run, rays, t->n, t->any);
}

static cw_status trace(tracing *t, work *w) {
    const py_field *f = t->field;
    if (is_packed(t) && (t->wide || f->identity)) return trace_packed(t, &w->run);
    t->run = w->run;
    t->run.pool = NULL;
    t->run.watch = NULL;
    /* A pool's threads are woken only for as many rays as the library wakes them for. */
    cw_pool_run(t->n < 2 * BLOCK ? NULL : w->run.pool, t->n, t->n < (size_t)PIECE * 64 ? BLOCK : PIECE, trace_blocks,
                t);
    return (cw_status)atomic_load(&t->status);
}

/* Builds the structure of a kernel if the field lacks it. Must not run beside queries. */
static bool make_ready(py_field *f, unsigned threads, const char *kernel, PyObject *progress) {
    const cw_run run = {.expert.kernel = kernel ? cw_kernel_find(kernel) : NULL};
    if (cw_run_check(f->field, &run) != CW_ERROR_NOT_BUILT) return true;
    work w;
    if (f->users != 0) {
        PyErr_Format(PyExc_RuntimeError, "kernel: %s is to be built first, but other queries are running", kernel);
        return false;
    }
    f->users = -1;
    const bool good =
        work_begin(&w, threads, kernel, progress) && work_end(&w, cw_field_build(f->field, &w.run), "kernel");
    f->users = 0;
    return good;
}

static bool is_within(const operand *o, size_t n, size_t width, const char *name) {
    if (o->offset >= 0 && o->step >= 0)
        return n == 0 || buffer_holds(&o->buffer, (size_t)o->offset + (n - 1) * (size_t)o->step + width, name);
    PyErr_Format(PyExc_ValueError, "%s: a negative offset", name);
    return false;
}

/* trace(any, wide, n, (buffer, offset, step) of origins, directions, tmin and tmax, out, threads, kernel, progress) */
PyObject *field_trace(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    operand o[OPERANDS];
    Py_buffer out = {0};
    int any, wide;
    Py_ssize_t n;
    unsigned threads;
    const char *kernel;
    PyObject *progress;
    memset(o, 0, sizeof o);
    if (!PyArg_ParseTuple(arguments, "ppn(y*nn)(y*nn)(y*nn)(y*nn)w*IzO:trace", &any, &wide, &n, &o[0].buffer,
                          &o[0].offset, &o[0].step, &o[1].buffer, &o[1].offset, &o[1].step, &o[2].buffer, &o[2].offset,
                          &o[2].step, &o[3].buffer, &o[3].offset, &o[3].step, &out, &threads, &kernel, &progress))
        return NULL;
    static const char *const names[OPERANDS] = {"origins", "directions", "tmin", "tmax"};
    tracing t = {.field = f, .wide = wide != 0, .n = (size_t)n};
    const size_t size = wide ? sizeof(double) : sizeof(float);
    bool good = n >= 0 && buffer_holds(&out, (size_t)n * (any ? 1 : sizeof(cw_hit)), "out");
    for (int k = 0; k < OPERANDS; k++) {
        good = good && is_within(&o[k], (size_t)n, size * (k <= DIRECTION ? 3 : 1), names[k]);
        t.at[k] = (const char *)o[k].buffer.buf + o[k].offset;
        t.step[k] = (size_t)o[k].step;
    }
    if (any)
        t.any = out.buf;
    else
        t.hits = out.buf;
    if (good && n > 0 && (good = field_is_idle(f) && make_ready(f, threads, kernel, progress) && field_enter(f))) {
        work w;
        if ((good = work_begin(&w, threads, kernel, progress))) {
            t.work = &w;
            const cw_status status = trace(&t, &w);
            good = work_end(&w, status == CW_ERROR_CANCELLED ? CW_OK : status, any ? "occluded" : "closest");
        }
        field_leave(f);
    }
    for (int k = 0; k < OPERANDS; k++) PyBuffer_Release(&o[k].buffer);
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

typedef struct looking {
    const py_field *field;
    const double *x, *y;
    double *z;
    work *work;
    size_t n;
    atomic_size_t done;
    atomic_int status;
} looking;

static void look_down(void *context, size_t begin, size_t end) {
    looking *l = context;
    while (begin < end) {
        const size_t until = end - begin < BLOCK ? end : begin + BLOCK, count = until - begin;
        for (; begin < until; begin++) {
            cw_hit hit;
            double point[3] = {l->x[begin], l->y[begin], l->field->site.map[2][3]};
            cw_status status = cw_surface_at_user(l->field->field, NULL, point, 1, &hit);
            if (status == CW_OK) status = cw_hit_points(l->field->field, NULL, &hit, 1, point);
            if (status != CW_OK) atomic_store(&l->status, (int)status);
            l->z[begin] = point[2];
        }
        if (!work_watch(l->work, (double)(atomic_fetch_add(&l->done, count) + count) / (double)l->n)) return;
    }
}

/* at(x, y, z, threads, progress): contiguous doubles, as many of each */
PyObject *field_at(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer x = {0}, y = {0}, z = {0};
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "y*y*w*IO:at", &x, &y, &z, &threads, &progress)) return NULL;
    if (f->site.map[0][2] != 0 || f->site.map[1][2] != 0) {
        PyErr_SetString(PyExc_ValueError, "transform: leans the heights, so that no single place is above x and y");
        PyBuffer_Release(&x);
        PyBuffer_Release(&y);
        PyBuffer_Release(&z);
        return NULL;
    }
    looking l = {.field = f, .x = x.buf, .y = y.buf, .z = z.buf, .n = (size_t)z.len / sizeof(double)};
    bool good = buffer_holds(&x, (size_t)z.len, "x") && buffer_holds(&y, (size_t)z.len, "y") && field_enter(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            l.work = &w;
            cw_pool_run(w.run.pool, l.n, PIECE, look_down, &l);
            good = work_end(&w, (cw_status)atomic_load(&l.status), "at");
        }
        field_leave(f);
    }
    PyBuffer_Release(&x);
    PyBuffer_Release(&y);
    PyBuffer_Release(&z);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

enum { POINTS, NORMALS, SMOOTH_NORMALS };

static cw_status follow(const py_field *f, work *w, int kind, const cw_hit *hits, size_t n, double (*out)[3]) {
    enum { AT_ONCE = 1 << 18 };
    for (size_t k = 0; k < n; k += AT_ONCE) {
        const size_t count = n - k < AT_ONCE ? n - k : AT_ONCE;
        if (!work_watch(w, (double)k / (double)n)) return CW_ERROR_CANCELLED;
        const cw_status status = kind == POINTS    ? cw_hit_points(f->field, &w->run, hits + k, count, out[k])
                                 : kind == NORMALS ? cw_hit_normals(f->field, &w->run, hits + k, count, out[k])
                                                   : cw_hit_phong_normals(f->field, &w->run, hits + k, count, out[k]);
        if (status != CW_OK) return status;
    }
    return CW_OK;
}

/* points(kind, hits, out, threads, progress): records as closest makes them, three doubles for each */
PyObject *field_points(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer hits = {0}, out = {0};
    int kind;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "iy*w*IO:points", &kind, &hits, &out, &threads, &progress)) return NULL;
    const size_t n = (size_t)hits.len / sizeof(cw_hit);
    bool good = buffer_holds(&out, n * 3 * sizeof(double), "out") && field_enter(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            const cw_status status = n > 0 ? follow(f, &w, kind, hits.buf, n, out.buf) : CW_OK;
            good = work_end(&w, status, kind == POINTS ? "points" : "normals");
        }
        field_leave(f);
    }
    PyBuffer_Release(&hits);
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}
