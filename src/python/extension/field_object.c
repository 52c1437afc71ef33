/* SPDX-License-Identifier: Apache-2.0 */
#include "extension.h"

#include "cellwalk_terrain.h"

#include <string.h>

static bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name) {
    if (buffer->len >= 0 && (size_t)buffer->len >= bytes) return true;
    PyErr_Format(PyExc_ValueError, "%s: a buffer of %zd bytes, where %zu are needed", name, buffer->len, bytes);
    return false;
}

bool buffer_copy(const Py_buffer *buffer, void *to, size_t bytes, const char *name) {
    if (!buffer_holds(buffer, bytes, name)) return false;
    memcpy(to, buffer->buf, bytes);
    return true;
}

static bool is_identity(double m[3][4]) {
    for (int k = 0; k < 12; k++)
        if (m[k / 4][k % 4] != (k / 4 == k % 4 ? 1 : 0)) return false;
    return true;
}

static cw_status make(py_field *f, work *w) {
    cw_field_desc desc = {.samples = f->samples.buf, .nx = f->nx, .ny = f->ny, .storage = CW_BORROW};
    memcpy(desc.map, f->map, sizeof desc.map);
    return cw_field_create(&desc, &w->run, &f->field);
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

/* False if the map cannot be inverted. */
static bool place(const py_field *f, terrain *t, const double map[3][4], terrain_desc d) {
    /* Without a map, a picture's: the first row is in the north. A coarser field's samples stand more than 1 apart. */
    const double apart = map[0][0];
    const double picture[3][4] = {{apart, 0, 0, 0}, {0, -apart, 0, apart * (double)(d.ny - 1)}, {0, 0, map[2][2], 0}};
    d.field = f->field;
    d.z = f->samples.buf;
    d.map = f->north_up ? picture : map;
    return cw_terrain_init(t, &d);
}

/* Field(samples or None, nx, ny, map, geographic, north_up, unit, semi_major, inverse_flattening, pool, progress[,
 * (columns, rows, column, row, map) of the raster that the samples are a window of]) */
static PyObject *field_new(PyTypeObject *type, PyObject *arguments, PyObject *keywords) {
    PyObject *samples, *pool, *progress;
    Py_buffer map = {0}, whole_map = {0};
    Py_ssize_t nx, ny, columns = 0, rows = 0, column = 0, row = 0;
    int geographic, north_up;
    double whole[3][4];
    terrain_desc d = {0};
    work w;
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "Onny*ppdddOO|(nnnny*):Field", &samples, &nx, &ny, &map, &geographic, &north_up,
                          &d.unit, &d.semi_major, &d.inverse_flattening, &pool, &progress, &columns, &rows, &column,
                          &row, &whole_map))
        return NULL;
    py_field *f = (py_field *)PyType_GenericAlloc(type, 0);
    bool good = f != NULL && buffer_copy(&map, f->map, sizeof f->map, "map") &&
                (columns == 0 || buffer_copy(&whole_map, whole, sizeof whole, "map"));
    PyBuffer_Release(&map);
    PyBuffer_Release(&whole_map);
    if (good) {
        d.geographic = geographic != 0;
        f->north_up = north_up != 0;
        f->nx = d.nx = (size_t)nx;
        f->ny = d.ny = (size_t)ny;
        f->identity = is_identity(f->map);
        good = take_samples(f, samples);
    }
    if (good && samples != Py_None) good = work_begin(&w, pool, NULL, progress) && work_end(&w, make(f, &w), "z");
    if (!good) {
        Py_XDECREF((PyObject *)f);
        return NULL;
    }
    f->on_map = place(f, &f->terrain, (const double(*)[4])f->map, d);
    if (columns > 0) {
        d.nx = (size_t)columns;
        d.ny = (size_t)rows;
        f->on_map = f->on_map && place(f, &f->whole, (const double(*)[4])whole, d);
        f->terrain.whole = &f->whole;
        f->terrain.column = (size_t)column;
        f->terrain.row = (size_t)row;
    }
    return (PyObject *)f;
}

/* Calls that find none at once make them twice, and the first that is done stays. */
cw_status field_bounds(py_field *f, const sight_bounds **bounds) {
    sight_bounds *there = atomic_load(&f->bounds), *made;
    if (there == NULL) {
        const cw_status status = cw_sight_bounds_create(&f->terrain, &made);
        if (status != CW_OK) return status;
        if (atomic_compare_exchange_strong(&f->bounds, &there, made))
            there = made;
        else
            cw_sight_bounds_destroy(made);
    }
    *bounds = there;
    return CW_OK;
}

static void drop_bounds(py_field *f) { cw_sight_bounds_destroy(atomic_exchange(&f->bounds, NULL)); }

static void field_dealloc(PyObject *self) {
    py_field *f = (py_field *)self;
    PyTypeObject *type = Py_TYPE(self);
    drop_bounds(f);
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
    drop_bounds(c->field);
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

/* Input: how long the map's unit is on the ground, as find_scale has it. Before the first product. */
cw_status make_scale(call *c) {
    py_field *f = c->field;
    size_t n;
    const map_scale *given = call_input(c, 0, sizeof *given, &n);
    if (n == 0) return call_fail(c, "scale: too few bytes");
    f->scale = *given;
    if (!f->terrain.geographic) f->terrain.scale = f->whole.scale = &f->scale;
    return CW_OK;
}

/* describe() -> lowest and highest sample, number of holes */
static PyObject *field_describe(PyObject *self, PyObject *unused) {
    const py_field *f = (const py_field *)self;
    (void)unused;
    const cw_field_info info = cw_field_describe(f->field);
    return Py_BuildValue("(ddn)", (double)info.low, (double)info.high, (Py_ssize_t)info.holes);
}

static PyMethodDef methods[] = {
    {"describe", field_describe, METH_NOARGS, NULL},
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
