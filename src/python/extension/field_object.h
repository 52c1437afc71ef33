/* SPDX-License-Identifier: Apache-2.0 */
/* _cellwalk.Field: a height field over samples that a Python object holds. Checks of dtypes, shapes and values are
 * made in Python (cellwalk/_field.py), whose messages name argument, shape and value. This file only refuses
 * arguments that would read or write out of bounds. */
#ifndef CELLWALK_PYTHON_FIELD_OBJECT_H
#define CELLWALK_PYTHON_FIELD_OBJECT_H

#include "site.h"
#include "work.h"

typedef struct py_field {
    PyObject_HEAD cw_field *field;
    Py_buffer samples; /* borrowed by the field; contiguous float, ny × nx */
    size_t nx, ny;
    site site;
    terrain terrain, whole; /* whole: of a window */
    map_scale scale;        /* of the whole map, once it is set */
    bool identity;          /* the map is */
    long users;             /* queries that run; -1: an update. Guarded by the GIL */
    long process;           /* in which users were counted: a fork forgets them */
} py_field;

/* The field is not to be changed from here to field_leave. False with an exception set while an update runs. */
bool field_enter(py_field *f);
bool field_is_idle(py_field *f);    /* the same, but nothing is begun */
bool field_enter_site(py_field *f); /* the same for products, which need a map with a way back */
void field_leave(py_field *f);

extern PyType_Spec py_field_spec;

/* Methods by file. */
PyObject *field_trace(PyObject *self, PyObject *arguments);
PyObject *field_at(PyObject *self, PyObject *arguments);
PyObject *field_points(PyObject *self, PyObject *arguments);

/* Whether a buffer holds at least so many bytes; else a ValueError. */
bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name);

#endif
