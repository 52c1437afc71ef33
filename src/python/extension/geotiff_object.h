/* SPDX-License-Identifier: Apache-2.0 */
/* GeoTIFFs written by windows, through the same code as the program's results: nothing has the name before all is on the
 * disk, and a disk that is full is an error. */
#ifndef CELLWALK_PYTHON_GEOTIFF_OBJECT_H
#define CELLWALK_PYTHON_GEOTIFF_OBJECT_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

extern PyType_Spec py_geotiff_spec;

#endif
