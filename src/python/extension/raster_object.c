/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from files, and what is known of their coordinate systems. */
#include "extension.h"
#include "gdal/module.h"
#include "raster.h"
#include "scale.h"
#include "sun_place.h"
#include "work.h"

#include <string.h>

typedef struct py_raster {
    PyObject_HEAD io_raster raster;
} py_raster;

static int get_buffer(PyObject *self, Py_buffer *view, int flags) {
    const io_raster *r = &((py_raster *)self)->raster;
    return PyBuffer_FillInfo(view, self, r->memory, (Py_ssize_t)(r->nx * r->ny * sizeof(float)), 0, flags);
}

static void dealloc(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    io_raster_free(&((py_raster *)self)->raster);
    PyObject_Free(self);
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

static PyObject *crs_of(const io_georef *g) {
    return Py_BuildValue("(zNddd)", g->crs, PyBool_FromLong(g->geographic), g->unit, g->semi_major,
                         g->inverse_flattening);
}

static PyObject *describe(io_raster *raster, PyObject *module, PyObject *warnings) {
    PyObject *type = PyObject_GetAttrString(module, "Raster");
    if (type == NULL) return NULL;
    py_raster *r = (py_raster *)PyType_GenericAlloc((PyTypeObject *)type, 0);
    Py_DECREF(type);
    if (r == NULL) return NULL;
    r->raster = *raster;
    *raster = (io_raster){0};
    const io_georef *g = &r->raster.georef;
    PyObject *nodata = g->has_nodata ? PyFloat_FromDouble(g->nodata) : Py_NewRef(Py_None);
    return Py_BuildValue("{s:N,s:(nn),s:y#,s:N,s:N,s:N,s:O}", "samples", (PyObject *)r, "shape",
                         (Py_ssize_t)r->raster.ny, (Py_ssize_t)r->raster.nx, "map", (const char *)r->raster.map,
                         (Py_ssize_t)sizeof r->raster.map, "placed", PyBool_FromLong(g->placed), "crs", crs_of(g),
                         "nodata", nodata, "warnings", warnings);
}

PyObject *read_raster(PyObject *self, PyObject *arguments) {
    const char *path;
    Py_ssize_t column = 0, row = 0, columns = 0, rows = 0;
    PyObject *window = Py_None, *nodata = Py_None, *progress = Py_None;
    io_raster_options o = {0};
    double no_data;
    if (!PyArg_ParseTuple(arguments, "sI|OddOO:read_raster", &path, &o.band, &nodata, &o.cellsize, &o.zscale, &window,
                          &progress) ||
        (window != Py_None && !PyArg_ParseTuple(window, "nnnn:window", &column, &row, &columns, &rows)))
        return NULL;
    o.no_samples = window == Py_None;
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
    if (r.warnings != NULL && work_begin(&r.work, Py_None, NULL, progress)) {
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

PyObject *find_scale(PyObject *self, PyObject *arguments) {
    const char *wkt, *name;
    Py_buffer numbers = {0};
    Py_ssize_t rows, columns;
    double map[3][4];
    map_scale scale;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "sy*nns:find_scale", &wkt, &numbers, &rows, &columns, &name)) return NULL;
    bool good = buffer_copy(&numbers, map, sizeof map, "map");
    PyBuffer_Release(&numbers);
    if (!good) return NULL;
    io_georef georef = {0};
    PyObject *nodes = NULL;
    reading r = {.warnings = PyList_New(0)};
    if (r.warnings != NULL && work_begin(&r.work, Py_None, NULL, Py_None)) {
        pthread_mutex_lock(&door);
        georef.placed = io_georef_from_wkt(&georef, wkt);
        good = rows >= 2 && columns >= 2 &&
               io_scale_find(&georef, map, (size_t)columns, (size_t)rows, name, note_warning, &r, &scale);
        pthread_mutex_unlock(&door);
        io_georef_free(&georef);
        if (work_end(&r.work, CW_OK, "crs"))
            nodes = good ? PyBytes_FromStringAndSize((const char *)&scale, sizeof scale) : Py_NewRef(Py_None);
    }
    PyObject *answer = nodes ? Py_BuildValue("(NO)", nodes, r.warnings) : NULL;
    Py_XDECREF(r.warnings);
    return answer;
}

PyObject *describe_crs(PyObject *self, PyObject *arguments) {
    const char *wkt;
    io_georef g = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "s:describe_crs", &wkt)) return NULL;
    PyObject *answer = io_georef_from_wkt(&g, wkt) ? crs_of(&g) : Py_NewRef(Py_None);
    io_georef_free(&g);
    return answer;
}

PyObject *locate(PyObject *self, PyObject *arguments) {
    const char *wkt;
    double xy[2];
    io_georef g = {0};
    io_error error = {""};
    sun_place p;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "sdd:locate", &wkt, &xy[0], &xy[1])) return NULL;
    PyThreadState *state = raster_enter();
    io_georef_from_wkt(&g, wkt);
    const terrain t = {0};
    const bool good = sun_place_of(&t, &g, xy, "crs", NULL, &p, &error);
    raster_leave(state);
    io_georef_free(&g);
    if (good) return Py_BuildValue("(ddd)", p.longitude, p.latitude, p.turned);
    PyErr_SetString(PyExc_ValueError, error.text);
    return NULL;
}
