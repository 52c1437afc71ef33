/* SPDX-License-Identifier: Apache-2.0 */
#include "extension.h"
#include "raster_out.h"

#include <string.h>
#include <unistd.h>

typedef struct py_geotiff {
    PyObject_HEAD io_raster_writer writer; /* all zero once it is committed or discarded */
    pid_t process;
    double map[3][4];
    io_georef georef;
} py_geotiff;

/* Tiles end where aligned chunks do. */
static const char *const tiles[] = {"BLOCKXSIZE=256", "BLOCKYSIZE=256"};

static bool take_cell(const char *dtype, io_cell *cell) {
    static const char *const names[] = {"uint8", "uint16", "float32", "int16"};
    for (int k = 0; k < 4; k++)
        if (strcmp(dtype, names[k]) == 0) {
            *cell = (io_cell)k;
            return true;
        }
    PyErr_Format(PyExc_TypeError, "result: dtype %s, expected uint8, uint16, int16 or float32; astype converts", dtype);
    return false;
}

static bool create(py_geotiff *t, const char *path, io_raster_product *p) {
    io_error error = {""};
    PyThreadState *state = raster_enter();
    const bool good = io_raster_is_tif(path) ? io_raster_create(&t->writer, path, p, &error)
                                             : io_fail(&error, "path: '%s', expected a name that ends in .tif", path);
    raster_leave(state);
    if (!good) PyErr_SetString(strncmp(error.text, "path: ", 6) == 0 ? PyExc_ValueError : PyExc_OSError, error.text);
    return good;
}

/* GeoTiff(path, bands, rows, columns, dtype, nodata, map or None, wkt or None, compress) */
static PyObject *geotiff_new(PyTypeObject *type, PyObject *arguments, PyObject *keywords) {
    PyObject *path = NULL;
    Py_ssize_t bands, rows, columns;
    const char *dtype, *wkt;
    Py_buffer map = {0};
    int compress;
    io_raster_product p = {.has_nodata = true, .creation = tiles, .creation_count = 2};
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "O&nnnsdz*zp:GeoTiff", PyUnicode_FSConverter, &path, &bands, &rows, &columns,
                          &dtype, &p.nodata, &map, &wkt, &compress))
        return NULL;
    py_geotiff *t = (py_geotiff *)PyType_GenericAlloc(type, 0);
    bool good =
        t != NULL && take_cell(dtype, &p.cell) && (map.obj == NULL || buffer_copy(&map, t->map, sizeof t->map, "map"));
    if (good) {
        t->process = getpid();
        t->georef.placed = map.obj != NULL;
        if (wkt != NULL) io_georef_from_wkt(&t->georef, wkt);
        p.bands = (size_t)bands;
        p.ny = (size_t)rows;
        p.nx = (size_t)columns;
        p.map = (const double(*)[4])t->map;
        p.georef = &t->georef;
        p.uncompressed = !compress;
        good = create(t, PyBytes_AsString(path), &p);
    }
    PyBuffer_Release(&map);
    Py_DECREF(path);
    if (!good) Py_CLEAR(t);
    return (PyObject *)t;
}

/* GDAL's unwritten tiles and the file belong to the process that opened it: a child that was forked touches neither. */
static bool is_open(const py_geotiff *t) { return t->writer.sink != NULL && t->process == getpid(); }

static bool check_open(const py_geotiff *t) {
    if (is_open(t)) return true;
    PyErr_SetString(PyExc_ValueError, "the GeoTIFF is closed, or was opened by another process");
    return false;
}

/* write(band, row, column, rows, columns, block): each cell once, in any order. */
static PyObject *write_block(PyObject *self, PyObject *arguments) {
    py_geotiff *t = (py_geotiff *)self;
    Py_ssize_t band, row, column, rows, columns;
    Py_buffer block = {0};
    io_error error = {""};
    if (!check_open(t)) return NULL;
    if (!PyArg_ParseTuple(arguments, "nnnnny*:write", &band, &row, &column, &rows, &columns, &block)) return NULL;
    const io_raster_product *p = &t->writer.product;
    const io_raster_window w = {(size_t)column, (size_t)row, (size_t)columns, (size_t)rows};
    const bool inside = band >= 0 && row >= 0 && column >= 0 && rows > 0 && columns > 0 && (size_t)band < p->bands &&
                        w.ny <= p->ny && w.j <= p->ny - w.ny && w.nx <= p->nx && w.i <= p->nx - w.nx &&
                        (size_t)block.len == w.nx * w.ny * io_cell_bytes(p->cell);
    bool good = false;
    if (inside) {
        PyThreadState *state = raster_enter();
        good = io_raster_write_window(&t->writer, (size_t)band, &w, block.buf, &error);
        raster_leave(state);
    }
    PyBuffer_Release(&block);
    if (good) Py_RETURN_NONE;
    if (inside)
        PyErr_SetString(PyExc_OSError, error.text);
    else
        PyErr_SetString(PyExc_ValueError, "block: not of the size of its window, or beyond the raster");
    return NULL;
}

/* commit(): the file gets its name, if every cell was written. */
static PyObject *commit(PyObject *self, PyObject *unused) {
    py_geotiff *t = (py_geotiff *)self;
    io_error error = {""};
    (void)unused;
    if (!check_open(t)) return NULL;
    PyThreadState *state = raster_enter();
    const bool good = io_raster_commit(&t->writer, &error);
    raster_leave(state);
    if (good) Py_RETURN_NONE;
    PyErr_SetString(PyExc_OSError, error.text);
    return NULL;
}

static void close_file(py_geotiff *t) {
    if (!is_open(t)) return;
    PyThreadState *state = raster_enter();
    io_raster_discard(&t->writer);
    raster_leave(state);
}

/* discard(): nothing remains; does nothing after commit. */
static PyObject *discard(PyObject *self, PyObject *unused) {
    (void)unused;
    close_file((py_geotiff *)self);
    Py_RETURN_NONE;
}

static void dealloc(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    close_file((py_geotiff *)self);
    io_georef_free(&((py_geotiff *)self)->georef);
    PyObject_Free(self);
    Py_DECREF(type);
}

static PyMethodDef methods[] = {
    {"write", write_block, METH_VARARGS, NULL},
    {"commit", commit, METH_NOARGS, NULL},
    {"discard", discard, METH_NOARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot slots[] = {
    {Py_tp_new, (void *)geotiff_new},
    {Py_tp_dealloc, (void *)dealloc},
    {Py_tp_methods, methods},
    {0, NULL},
};

PyType_Spec py_geotiff_spec = {
    .name = "cellwalk._cellwalk.GeoTiff",
    .basicsize = sizeof(py_geotiff),
    .flags = Py_TPFLAGS_DEFAULT,
    .slots = slots,
};
