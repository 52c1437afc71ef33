/* SPDX-License-Identifier: Apache-2.0 */
#include "call.h"

#include "cellwalk_terrain.h"

#include <math.h>
#include <string.h>

bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name) {
    if (buffer->len >= 0 && (size_t)buffer->len >= bytes) return true;
    PyErr_Format(PyExc_ValueError, "%s: a buffer of %zd bytes, where %zu are needed", name, buffer->len, bytes);
    return false;
}

static bool is_identity(double m[3][4]) {
    for (int k = 0; k < 12; k++)
        if (m[k / 4][k % 4] != (k / 4 == k % 4 ? 1 : 0)) return false;
    return true;
}

static cw_status make(py_field *f, work *w) {
    cw_field_desc desc = {.samples = f->samples.buf, .nx = f->nx, .ny = f->ny, .storage = CW_BORROW};
    memcpy(desc.map, f->site.map, sizeof desc.map);
    return cw_field_create(&desc, &w->run, &f->field);
}

static bool has_infinity(const py_field *f) {
    const float *z = f->samples.buf;
    for (size_t k = 0; k < f->nx * f->ny; k++)
        if (isinf(z[k])) return true;
    return false;
}

/* Samples, if there are any, of f->nx columns and f->ny rows. */
static bool take_samples(py_field *f, PyObject *samples) {
    if (f->nx > CW_SIDE_MAX || f->ny > CW_SIDE_MAX) {
        PyErr_SetString(PyExc_ValueError, "samples: too many");
        return false;
    }
    return samples == Py_None || (PyObject_GetBuffer(samples, &f->samples, PyBUF_SIMPLE) == 0 &&
                                  buffer_holds(&f->samples, f->nx * f->ny * sizeof(float), "samples"));
}

/* Where the samples lie, and those of the raster that they are a window of if that has columns. */
static void place(py_field *f, const site *raster, size_t columns, size_t rows, size_t column, size_t row) {
    const float *z = f->samples.buf;
    f->on_map = site_init(&f->terrain, &f->site, f->field, f->nx, f->ny, z);
    if (columns == 0) return;
    f->on_map = f->on_map && site_init(&f->whole, raster, f->field, columns, rows, z);
    f->terrain.whole = &f->whole;
    f->terrain.column = column;
    f->terrain.row = row;
}

/* Field(samples or None, nx, ny, map, geographic, north_up, unit, semi_major, inverse_flattening, threads, progress[,
 * (columns, rows, column, row, map) of the raster that the samples are a window of]). Returns None in place of a
 * field whose samples hold an infinity, which borrowed samples must not. */
static PyObject *field_new(PyTypeObject *type, PyObject *arguments, PyObject *keywords) {
    PyObject *samples, *progress;
    Py_buffer map = {0}, whole_map = {0};
    Py_ssize_t nx, ny, columns = 0, rows = 0, column = 0, row = 0;
    int geographic, north_up;
    unsigned threads;
    site g = {0};
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "Onny*ppdddIO|(nnnny*):Field", &samples, &nx, &ny, &map, &geographic, &north_up,
                          &g.unit, &g.semi_major, &g.inverse_flattening, &threads, &progress, &columns, &rows, &column,
                          &row, &whole_map))
        return NULL;
    g.geographic = geographic != 0;
    g.north_up = north_up != 0;
    site raster = g;
    bool good = site_take_map(&map, g.map) && (columns == 0 || site_take_map(&whole_map, raster.map));
    PyBuffer_Release(&map);
    PyBuffer_Release(&whole_map);
    py_field *f = good ? (py_field *)PyType_GenericAlloc(type, 0) : NULL;
    if (f == NULL) return NULL;
    f->site = g;
    f->nx = (size_t)nx;
    f->ny = (size_t)ny;
    f->identity = is_identity(f->site.map);
    work w;
    bool infinite = false;
    good = take_samples(f, samples);
    if (good && samples != Py_None && (good = work_begin(&w, threads, NULL, progress))) {
        const cw_status status = make(f, &w);
        infinite = status == CW_ERROR_SAMPLE && has_infinity(f);
        good = work_end(&w, infinite ? CW_OK : status, "z");
    }
    if (good && !infinite) {
        place(f, &raster, (size_t)columns, (size_t)rows, (size_t)column, (size_t)row);
        return (PyObject *)f;
    }
    Py_DECREF((PyObject *)f);
    return good ? Py_NewRef(Py_None) : NULL;
}

static void field_dealloc(PyObject *self) {
    py_field *f = (py_field *)self;
    PyTypeObject *type = Py_TYPE(self);
    cw_field_destroy(f->field);
    if (f->samples.obj != NULL) PyBuffer_Release(&f->samples);
    PyObject_Free(self);
    Py_DECREF(type);
}

/* ---- methods ----------------------------------------------------------------------------------------------------------- */

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

/* Input: samples of the window. Output: room for as many. */
cw_status make_update(call *c) {
    const cw_update u = {.at = c->at};
    size_t n;
    const float *block = call_input(c, 0, sizeof *block, &n);
    float *before = call_output(c, 0, c->at.nx * c->at.ny * sizeof *before);
    if (before == NULL || n < c->at.nx * c->at.ny) return CW_ERROR_ARGUMENT;
    return put(c->field, &u, &c->work.run, block, before);
}

/* Outputs: the heights, and above, below, rms, lost, made. */
cw_status make_coarser(call *c) {
    double *about = call_output(c, 1, 5 * sizeof *about);
    cw_difference d = {0};
    cw_field *coarser;
    if (about == NULL) return CW_ERROR_ARGUMENT;
    const cw_status status =
        cw_field_coarser(c->field->field, &c->work.run, (size_t)c->n.factor, (int)c->n.filter, &coarser, &d, sizeof d);
    if (status != CW_OK) return status;
    const cw_field_info info = cw_field_describe(coarser);
    float *out = call_output(c, 0, info.nx * info.ny * sizeof *out);
    for (size_t j = 0; out != NULL && j < info.ny; j++)
        memcpy(out + j * info.nx, cw_field_row(coarser, j), info.nx * sizeof *out);
    const double numbers[5] = {d.above, d.below, d.rms, (double)d.lost, (double)d.made};
    memcpy(about, numbers, sizeof numbers);
    cw_field_destroy(coarser);
    return out ? CW_OK : CW_ERROR_ARGUMENT;
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
