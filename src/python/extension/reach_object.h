/* SPDX-License-Identifier: Apache-2.0 */
/* _cellwalk.Reach: how much of a raster matters to a part of it, by src/ground/ground_plan.h, without its samples. */
#ifndef CELLWALK_PYTHON_REACH_OBJECT_H
#define CELLWALK_PYTHON_REACH_OBJECT_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

extern PyType_Spec py_reach_spec;

/* block_ranges(samples, row, column, rows, columns, low, high): lowest and highest of each block of the raster that the
 * rectangle, which is not empty, has samples of; low and high hold a float for each. */
PyObject *block_ranges(PyObject *self, PyObject *arguments);

#endif
