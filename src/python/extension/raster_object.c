/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from files, and what is known of their coordinate systems. */
#include "extension.h"
#include "place_sky.h"
#include "raster.h"

#include <stdlib.h>
#include <string.h>

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

static const char raster_name[] = "io_raster";

static void destroy_raster(PyObject *capsule) {
    io_raster *r = PyCapsule_GetPointer(capsule, raster_name);
    io_raster_free(r);
    free(r);
}

/* samples: where they are, and what holds them. */
static PyObject *describe(io_raster *raster, PyObject *warnings) {
    io_raster *r = malloc(sizeof *r);
    PyObject *holder = r ? PyCapsule_New(r, raster_name, destroy_raster) : PyErr_NoMemory();
    if (holder == NULL) {
        io_raster_free(raster);
        free(r);
        return NULL;
    }
    *r = *raster;
    const io_georef *g = &r->georef;
    PyObject *nodata = g->has_nodata ? PyFloat_FromDouble(g->nodata) : Py_NewRef(Py_None);
    return Py_BuildValue("{s:(NN),s:(nn),s:y#,s:N,s:N,s:N,s:O}", "samples", PyLong_FromVoidPtr(r->memory), holder,
                         "shape", (Py_ssize_t)r->ny, (Py_ssize_t)r->nx, "map", (const char *)r->map,
                         (Py_ssize_t)sizeof r->map, "placed", PyBool_FromLong(g->placed), "crs", crs_of(g), "nodata",
                         nodata, "warnings", warnings);
}

PyObject *read_raster(PyObject *self, PyObject *arguments) {
    const char *path;
    Py_ssize_t w[4] = {0}; /* column, row, columns, rows */
    PyObject *window = Py_None, *nodata = Py_None, *progress = Py_None;
    io_raster_options o = {0};
    double no_data;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "sI|OddOO:read_raster", &path, &o.band, &nodata, &o.cellsize, &o.zscale, &window,
                          &progress) ||
        (window != Py_None && !PyArg_ParseTuple(window, "nnnn:window", &w[0], &w[1], &w[2], &w[3])))
        return NULL;
    o.no_samples = window == Py_None;
    if (nodata != Py_None) {
        no_data = PyFloat_AsDouble(nodata);
        o.nodata = &no_data;
        o.nodata_count = 1;
        if (PyErr_Occurred()) return NULL;
    }
    o.window.i = (size_t)w[0];
    o.window.j = (size_t)w[1];
    o.window.nx = (size_t)w[2];
    o.window.ny = (size_t)w[3];
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
            answer = describe(&raster, r.warnings);
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

/* Of a place of a projected map: longitude, latitude, and how far the map's north is turned there from the true one. */
cw_status make_place(call *c) {
    const double xy[2] = {c->n.x, c->n.y};
    io_georef g = {0};
    io_error error = {""};
    sun_place *out = call_output(c, 0, sizeof *out);
    if (out == NULL || c->text == NULL) return CW_ERROR_ARGUMENT;
    pthread_mutex_lock(&door);
    io_georef_from_wkt(&g, c->text);
    const bool good = sun_place_of(&(terrain){0}, &g, xy, "crs", NULL, out, &error);
    pthread_mutex_unlock(&door);
    io_georef_free(&g);
    return good ? CW_OK : call_fail(c, "%s", error.text);
}
