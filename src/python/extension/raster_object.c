/* SPDX-License-Identifier: Apache-2.0 */
#include "raster_object.h"

#include "gdal/module.h"
#include "raster.h"
#include "scale.h"
#include "site.h"
#include "work.h"

#include <string.h>

typedef struct py_raster {
    PyObject_HEAD io_raster raster;
    Py_ssize_t shape[2], strides[2];
} py_raster;

static int get_buffer(PyObject *self, Py_buffer *view, int flags) {
    py_raster *r = (py_raster *)self;
    static char format[] = "f";
    view->buf = r->raster.memory;
    view->len = r->shape[0] * r->shape[1] * (Py_ssize_t)sizeof(float);
    view->itemsize = sizeof(float);
    view->readonly = 0;
    view->format = (flags & PyBUF_FORMAT) ? format : NULL;
    view->ndim = (flags & PyBUF_ND) ? 2 : 1;
    view->shape = (flags & PyBUF_ND) ? r->shape : NULL;
    view->strides = (flags & PyBUF_STRIDES) == PyBUF_STRIDES ? r->strides : NULL;
    view->suboffsets = NULL;
    view->internal = NULL;
    Py_INCREF(self);
    view->obj = self;
    return 0;
}

static void dealloc(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    io_raster_free(&((py_raster *)self)->raster);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DECREF(type);
}

static PyType_Slot slots[] = {
    {Py_bf_getbuffer, (void *)get_buffer},
    {Py_tp_dealloc, (void *)dealloc},
    {0, NULL},
};

PyType_Spec py_raster_spec = {
    .name = "cellwalk._cellwalk.Raster",
    .basicsize = sizeof(py_raster),
    .flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_DISALLOW_INSTANTIATION,
    .slots = slots,
};

static pthread_mutex_t door = PTHREAD_MUTEX_INITIALIZER;

PyThreadState *raster_enter(void) {
    PyThreadState *state = PyEval_SaveThread();
    pthread_mutex_lock(&door);
    return state;
}

void raster_leave(PyThreadState *state) {
    pthread_mutex_unlock(&door);
    PyEval_RestoreThread(state);
}

typedef struct reading {
    work work;
    PyObject *warnings; /* a list of sentences */
} reading;

static void note_warning(void *context, const char *text) {
    reading *r = context;
    PyEval_RestoreThread(r->work.state);
    PyObject *sentence = PyUnicode_DecodeUTF8(text, (Py_ssize_t)strlen(text), "replace");
    if (sentence == NULL || PyList_Append(r->warnings, sentence) != 0) PyErr_Clear();
    Py_XDECREF(sentence);
    r->work.state = PyEval_SaveThread();
}

static bool tell(void *context, double share) { return work_watch(&((reading *)context)->work, share); }

static PyObject *describe(io_raster *raster, PyObject *module, PyObject *warnings) {
    PyObject *type = PyObject_GetAttrString(module, "Raster");
    if (type == NULL) return NULL;
    allocfunc allocate = (allocfunc)PyType_GetSlot((PyTypeObject *)type, Py_tp_alloc);
    py_raster *r = (py_raster *)allocate((PyTypeObject *)type, 0);
    Py_DECREF(type);
    if (r == NULL) return NULL;
    r->raster = *raster;
    *raster = (io_raster){0};
    r->shape[0] = (Py_ssize_t)r->raster.ny;
    r->shape[1] = (Py_ssize_t)r->raster.nx;
    r->strides[0] = r->shape[1] * (Py_ssize_t)sizeof(float);
    r->strides[1] = sizeof(float);
    const io_georef *g = &r->raster.georef;
    const double(*m)[4] = (const double(*)[4])r->raster.map;
    PyObject *nodata = g->has_nodata ? PyFloat_FromDouble(g->nodata) : Py_NewRef(Py_None);
    return Py_BuildValue("{s:N,s:((dddd)(dddd)(dddd)),s:N,s:N,s:d,s:d,s:d,s:z,s:N,s:O}", "samples", (PyObject *)r,
                         "map", m[0][0], m[0][1], m[0][2], m[0][3], m[1][0], m[1][1], m[1][2], m[1][3], m[2][0],
                         m[2][1], m[2][2], m[2][3], "placed", PyBool_FromLong(g->placed), "geographic",
                         PyBool_FromLong(g->geographic), "unit", g->unit, "semi_major", g->semi_major,
                         "inverse_flattening", g->inverse_flattening, "crs", g->crs, "nodata", nodata, "warnings",
                         warnings);
}

PyObject *read_raster(PyObject *self, PyObject *arguments) {
    const char *path;
    Py_ssize_t column = 0, row = 0, columns = 0, rows = 0;
    PyObject *nodata, *progress;
    io_raster_options o = {0};
    double no_data;
    if (!PyArg_ParseTuple(arguments, "sIOdd(nnnn)O:read_raster", &path, &o.band, &nodata, &o.cellsize, &o.zscale,
                          &column, &row, &columns, &rows, &progress))
        return NULL;
    if (nodata != Py_None) {
        no_data = PyFloat_AsDouble(nodata);
        o.nodata = &no_data;
        o.nodata_count = 1;
        if (PyErr_Occurred()) return NULL;
    }
    o.window.i = (size_t)column;
    o.window.j = (size_t)row;
    o.window.nx = (size_t)columns;
    o.window.ny = (size_t)rows;
    reading r = {.warnings = PyList_New(0)};
    o.warn = note_warning;
    o.progress = tell;
    o.context = &r;
    io_raster raster;
    io_error error = {""};
    PyObject *answer = NULL;
    if (r.warnings != NULL && work_begin(&r.work, 1, NULL, progress)) {
        pthread_mutex_lock(&door);
        const bool good = io_raster_read(path, &o, &raster, &error);
        pthread_mutex_unlock(&door);
        if (!work_end(&r.work, CW_OK, path)) {
            if (good) io_raster_free(&raster);
        } else if (!good) {
            PyErr_SetString(PyExc_OSError, error.text);
        } else {
            answer = describe(&raster, self, r.warnings);
        }
    }
    Py_XDECREF(r.warnings);
    return answer;
}

enum { SENTENCES = 3, SENTENCE = 1024 };

typedef struct sentences {
    size_t count;
    char text[SENTENCES][SENTENCE];
} sentences;

static void keep(void *context, const char *text) {
    sentences *s = context;
    if (s->count < SENTENCES) snprintf(s->text[s->count++], SENTENCE, "%s", text);
}

PyObject *find_scale(PyObject *self, PyObject *arguments) {
    const char *wkt, *name;
    Py_buffer numbers = {0};
    Py_ssize_t rows, columns;
    double map[3][4];
    map_scale scale;
    sentences said = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "sy*nns:find_scale", &wkt, &numbers, &rows, &columns, &name)) return NULL;
    bool good = site_take_map(&numbers, map);
    PyBuffer_Release(&numbers);
    if (!good) return NULL;
    io_georef georef = {0};
    PyThreadState *state = raster_enter();
    georef.placed = io_georef_from_wkt(&georef, wkt);
    good = rows >= 2 && columns >= 2 &&
           io_scale_find(&georef, map, (size_t)columns, (size_t)rows, name, keep, &said, &scale);
    raster_leave(state);
    io_georef_free(&georef);
    PyObject *warnings = PyList_New(0);
    for (size_t k = 0; k < said.count && warnings != NULL; k++) {
        PyObject *text = PyUnicode_DecodeUTF8(said.text[k], (Py_ssize_t)strlen(said.text[k]), "replace");
        if (text == NULL || PyList_Append(warnings, text) != 0) Py_CLEAR(warnings);
        Py_XDECREF(text);
    }
    if (warnings == NULL) return NULL;
    PyObject *nodes = good ? PyBytes_FromStringAndSize((const char *)&scale, sizeof scale) : Py_NewRef(Py_None);
    return Py_BuildValue("(NN)", nodes, warnings);
}

static bool find_size(const char *path, const io_raster_options *o, size_t size[2], io_error *error) {
    io_raster raster;
    if (!io_raster_read(path, o, &raster, error)) return false;
    size[0] = raster.nx;
    size[1] = raster.ny;
    io_raster_free(&raster);
    return true;
}

PyObject *raster_size(PyObject *self, PyObject *arguments) {
    const char *path;
    io_raster_options o = {.no_samples = true};
    io_error error = {""};
    size_t size[2];
    (void)self;
    if (!PyArg_ParseTuple(arguments, "sI:raster_size", &path, &o.band)) return NULL;
    PyThreadState *state = raster_enter();
    const bool good = find_size(path, &o, size, &error);
    raster_leave(state);
    if (good) return Py_BuildValue("(nn)", (Py_ssize_t)size[0], (Py_ssize_t)size[1]);
    PyErr_SetString(PyExc_OSError, error.text);
    return NULL;
}
