/* SPDX-License-Identifier: Apache-2.0 */
#include "call.h"

#include "cellwalk_terrain.h"

#include <math.h>
#include <string.h>
#include <structmember.h>
#include <unistd.h>

bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name) {
    if (buffer->len >= 0 && (size_t)buffer->len >= bytes) return true;
    PyErr_Format(PyExc_ValueError, "%s: a buffer of %zd bytes, where %zu are needed", name, buffer->len, bytes);
    return false;
}

static void forget_other_process(py_field *f) {
    const long process = (long)getpid();
    if (f->process != process) f->users = 0;
    f->process = process;
}

bool field_is_idle(py_field *f) {
    forget_other_process(f);
    if (f->users >= 0) return true;
    PyErr_SetString(PyExc_RuntimeError, "the field is being changed by another thread");
    return false;
}

bool field_enter(py_field *f) {
    if (!field_is_idle(f)) return false;
    f->users++;
    return true;
}

bool field_enter_site(py_field *f) {
    if (f->terrain.field != NULL) return field_enter(f);
    PyErr_SetString(PyExc_ValueError, "transform: cannot be inverted");
    return false;
}

void field_leave(py_field *f) { f->users--; }

static bool is_identity(double m[3][4]) {
    for (int k = 0; k < 12; k++)
        if (m[k / 4][k % 4] != (k / 4 == k % 4 ? 1 : 0)) return false;
    return true;
}

/* Field(samples, nx, ny, map, geographic, north_up, unit, semi_major, inverse_flattening, threads, progress[,
 * (columns, rows, column, row, map) of the raster that the samples are a window of]). Returns None in place of a
 * field whose samples hold an infinity, which borrowed samples must not. */
static cw_status make(py_field *f, work *w) {
    cw_field_desc desc = {0};
    desc.samples = f->samples.buf;
    desc.nx = f->nx;
    desc.ny = f->ny;
    desc.storage = CW_BORROW;
    memcpy(desc.map, f->site.map, sizeof desc.map);
    return cw_field_create(&desc, &w->run, &f->field);
}

static bool has_infinity(const py_field *f) {
    const float *z = f->samples.buf;
    for (size_t k = 0; k < f->nx * f->ny; k++)
        if (isinf(z[k])) return true;
    return false;
}

static PyObject *field_new(PyTypeObject *type, PyObject *arguments, PyObject *keywords) {
    PyObject *samples, *progress;
    Py_buffer map = {0};
    Py_ssize_t nx, ny;
    int geographic, north_up;
    double unit, semi_major, inverse_flattening;
    unsigned threads;
    Py_buffer whole_map = {0};
    double raster[3][4];
    Py_ssize_t whole_nx = 0, whole_ny = 0, column = 0, row = 0;
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "Onny*ppdddIO|(nnnny*):Field", &samples, &nx, &ny, &map, &geographic, &north_up,
                          &unit, &semi_major, &inverse_flattening, &threads, &progress, &whole_nx, &whole_ny, &column,
                          &row, &whole_map))
        return NULL;
    const bool is_window = whole_map.obj != NULL;
    const bool placed = !is_window || site_take_map(&whole_map, raster);
    PyBuffer_Release(&whole_map);
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    py_field *f = (py_field *)allocate(type, 0);
    const bool good = f != NULL && placed && site_take_map(&map, f->site.map) &&
                      PyObject_GetBuffer(samples, &f->samples, PyBUF_SIMPLE) == 0;
    PyBuffer_Release(&map);
    if (!good || nx < 0 || ny < 0 || (ny > 0 && nx > PY_SSIZE_T_MAX / 4 / ny) ||
        !buffer_holds(&f->samples, (size_t)nx * (size_t)ny * sizeof(float), "samples")) {
        if (!PyErr_Occurred()) PyErr_SetString(PyExc_ValueError, "samples: too many");
        Py_XDECREF((PyObject *)f);
        return NULL;
    }
    f->nx = (size_t)nx;
    f->ny = (size_t)ny;
    f->site.geographic = geographic != 0;
    f->site.north_up = north_up != 0;
    f->site.unit = unit;
    f->site.semi_major = semi_major;
    f->site.inverse_flattening = inverse_flattening;
    f->identity = is_identity(f->site.map);
    work w;
    if (!work_begin(&w, threads, NULL, progress)) {
        Py_DECREF((PyObject *)f);
        return NULL;
    }
    const cw_status status = make(f, &w);
    const bool infinite = status == CW_ERROR_SAMPLE && has_infinity(f);
    if (!work_end(&w, infinite ? CW_OK : status, "z")) {
        Py_DECREF((PyObject *)f);
        return NULL;
    }
    if (infinite) {
        Py_DECREF((PyObject *)f);
        Py_RETURN_NONE;
    }
    if (!site_init(&f->terrain, &f->site, f->field, f->nx, f->ny, f->samples.buf))
        f->terrain.field = NULL; /* products will say so */
    if (is_window) {
        site whole = f->site;
        memcpy(whole.map, raster, sizeof whole.map);
        if (!site_init(&f->whole, &whole, f->field, (size_t)whole_nx, (size_t)whole_ny, f->samples.buf))
            f->terrain.field = NULL;
        f->terrain.whole = &f->whole;
        f->terrain.column = (size_t)column;
        f->terrain.row = (size_t)row;
    }
    return (PyObject *)f;
}

static void field_dealloc(PyObject *self) {
    py_field *f = (py_field *)self;
    PyTypeObject *type = Py_TYPE(self);
    cw_field_destroy(f->field);
    if (f->samples.obj != NULL) PyBuffer_Release(&f->samples);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DECREF(type);
}

/* Copies block into the samples. If the field refuses it, the old samples are restored. */
static cw_status put(py_field *f, const cw_update *u, const cw_run *run, const float *block, float *before) {
    float *z = f->samples.buf;
    for (size_t y = 0; y < u->at.ny; y++) {
        float *row = z + (u->at.j + y) * f->nx + u->at.i;
        memcpy(before + y * u->at.nx, row, u->at.nx * sizeof *row);
        memcpy(row, block + y * u->at.nx, u->at.nx * sizeof *row);
    }
    const cw_status status = cw_field_update(f->field, run, u);
    if (status == CW_OK) return status;
    for (size_t y = 0; y < u->at.ny; y++)
        memcpy(z + (u->at.j + y) * f->nx + u->at.i, before + y * u->at.nx, u->at.nx * sizeof *z);
    cw_field_update(f->field, run, u);
    return status;
}

/* update(row, column, rows, columns, block, before, threads): before is as large as block. */
static PyObject *field_update(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer block = {0}, before = {0};
    Py_ssize_t row, column, rows, columns;
    unsigned threads;
    if (!PyArg_ParseTuple(arguments, "nnnny*w*I:update", &row, &column, &rows, &columns, &block, &before, &threads))
        return NULL;
    forget_other_process(f);
    const size_t bytes = (size_t)rows * (size_t)columns * sizeof(float);
    bool good = buffer_holds(&block, bytes, "block") && buffer_holds(&before, bytes, "before");
    if (good && (row < 0 || column < 0 || rows < 0 || columns < 0 || (size_t)rows > f->ny || (size_t)columns > f->nx ||
                 (size_t)row > f->ny - (size_t)rows || (size_t)column > f->nx - (size_t)columns)) {
        PyErr_SetString(PyExc_ValueError, "update: the rectangle is not within the field");
        good = false;
    }
    if (good && (f->users != 0 || f->samples.readonly)) {
        PyErr_SetString(PyExc_RuntimeError, f->users ? "update: queries or another update are running on the field"
                                                     : "update: the samples are read-only");
        good = false;
    }
    if (good) {
        work w;
        f->users = -1;
        if ((good = work_begin(&w, threads, NULL, Py_None))) {
            const cw_update u = {.at = {(size_t)column, (size_t)row, (size_t)columns, (size_t)rows}};
            good = work_end(&w, put(f, &u, &w.run, block.buf, before.buf), "block");
        }
        f->users = 0;
    }
    PyBuffer_Release(&block);
    PyBuffer_Release(&before);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

/* coarser(factor, filter, rows, columns, out, threads, progress): rows * columns heights go to out. Returns (above,
 * below, rms, lost, made). */
static PyObject *field_coarser(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer out = {0};
    Py_ssize_t factor, rows, columns;
    int filter;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "ninnw*IO:coarser", &factor, &filter, &rows, &columns, &out, &threads, &progress))
        return NULL;
    cw_difference d = {0};
    cw_field *coarser = NULL;
    bool good = factor >= 0 && field_enter(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, "cell", progress)))
            good = work_end(&w, cw_field_coarser(f->field, &w.run, (size_t)factor, filter, &coarser, &d, sizeof d),
                            "coarser");
        field_leave(f);
    }
    if (good) {
        const cw_field_info info = cw_field_describe(coarser);
        good = info.nx == (size_t)columns && info.ny == (size_t)rows &&
               buffer_holds(&out, info.nx * info.ny * sizeof(float), "out");
        for (size_t j = 0; good && j < info.ny; j++)
            memcpy((float *)out.buf + j * info.nx, cw_field_row(coarser, j), info.nx * sizeof(float));
    }
    if (!good && !PyErr_Occurred()) PyErr_SetString(PyExc_ValueError, "coarser: out is of another size");
    cw_field_destroy(coarser);
    PyBuffer_Release(&out);
    if (!good) return NULL;
    return Py_BuildValue("(dddKK)", d.above, d.below, d.rms, (unsigned long long)d.lost, (unsigned long long)d.made);
}

/* scale(nodes): how long the map's unit is on the ground, as find_scale has it. Before the first product. */
static PyObject *field_scale(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer nodes = {0};
    if (!PyArg_ParseTuple(arguments, "y*:scale", &nodes)) return NULL;
    const bool good = site_take_scale(&nodes, &f->scale, &f->terrain);
    f->whole.scale = f->terrain.scale;
    PyBuffer_Release(&nodes);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

static PyObject *field_describe(PyObject *self, PyObject *unused) {
    const py_field *f = (const py_field *)self;
    (void)unused;
    const cw_field_info info = cw_field_describe(f->field);
    return Py_BuildValue("{s:d,s:d,s:n,s:n,s:d}", "low", (double)info.low, "high", (double)info.high, "holes",
                         (Py_ssize_t)info.holes, "bytes_built", (Py_ssize_t)info.bytes_built, "build_seconds",
                         cw_field_build_seconds(f->field));
}

static PyMethodDef methods[] = {
    {"trace", field_trace, METH_VARARGS, NULL},
    {"at", field_at, METH_VARARGS, NULL},
    {"points", field_points, METH_VARARGS, NULL},
    {"update", field_update, METH_VARARGS, NULL},
    {"coarser", field_coarser, METH_VARARGS, NULL},
    {"describe", field_describe, METH_NOARGS, NULL},
    {"scale", field_scale, METH_VARARGS, NULL},
    {"make", field_make, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot slots[] = {
    {Py_tp_new, (void *)field_new},
    {Py_tp_dealloc, (void *)field_dealloc},
    {Py_tp_methods, methods},
    {0, NULL},
};

PyType_Spec py_field_spec = {
    .name = "cellwalk._cellwalk.Field",
    .basicsize = sizeof(py_field),
    .flags = Py_TPFLAGS_DEFAULT,
    .slots = slots,
};
