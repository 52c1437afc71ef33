/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the extension declare for module.c and each other, beside call.h. Checks of dtypes, shapes and values are made in
 * Python, whose messages name argument, shape and value. The extension only refuses arguments that would read or write out of
 * bounds. */
#ifndef CELLWALK_PYTHON_EXTENSION_H
#define CELLWALK_PYTHON_EXTENSION_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <stdbool.h>

/* Field: call.h. Raster: samples from a file, as bytes that NumPy reads in place. GeoTiff: written by windows, through the same code as
 * the program's results: nothing has the name before all is on the disk, and a disk that is full is an error. */
extern PyType_Spec py_field_spec, py_raster_spec, py_geotiff_spec;

/* Whether a buffer holds at least so many bytes; else a ValueError. */
bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name);
/* The same, and copies them. */
bool buffer_copy(const Py_buffer *buffer, void *to, size_t bytes, const char *name);

/* Around each use of GDAL's module, which is for one thread at a time: gives the GIL back, then waits for the others. In
 * this order, since who is inside may ask for the GIL, to warn or to tell progress. */
PyThreadState *raster_enter(void);
void raster_leave(PyThreadState *state);

/* describe_crs(wkt) -> (wkt, geographic, unit, semi_major, inverse_flattening), or None */
PyObject *describe_crs(PyObject *self, PyObject *arguments);

/* locate(wkt, x, y) -> longitude and latitude of a place of a projected map, and how far its north is turned there from
 * the true one */
PyObject *locate(PyObject *self, PyObject *arguments);

/* find_scale(wkt, map, rows, columns, name) -> (bytes or None, warnings): the scale of a projected map */
PyObject *find_scale(PyObject *self, PyObject *arguments);

/* read_raster(path, band[, nodata, cellsize, zscale, (column, row, columns, rows), progress]) -> a dict that says all of the raster:
 * without a window of its header alone, if the format has windows */
PyObject *read_raster(PyObject *self, PyObject *arguments);

#endif
