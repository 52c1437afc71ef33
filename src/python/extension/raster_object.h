/* SPDX-License-Identifier: Apache-2.0 */
/* Rasters from files, as objects that NumPy reads in place. */
#ifndef CELLWALK_PYTHON_RASTER_OBJECT_H
#define CELLWALK_PYTHON_RASTER_OBJECT_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

extern PyType_Spec py_raster_spec;

/* Around each use of GDAL's module, which is for one thread at a time: gives the GIL back, then waits for the others. In
 * this order, since who is inside may ask for the GIL, to warn or to tell progress. */
PyThreadState *raster_enter(void);
void raster_leave(PyThreadState *state);

/* read_raster(path, band, nodata or None, cellsize, zscale, (column, row, columns, rows) or None, progress) -> a dict that says all of
 * the raster: without a window of its header alone, if the format has windows */
PyObject *read_raster(PyObject *self, PyObject *arguments);

/* find_scale(wkt, map, rows, columns, name) -> (bytes or None, warnings): the scale of a projected map */
PyObject *find_scale(PyObject *self, PyObject *arguments);

#endif
