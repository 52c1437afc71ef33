/* SPDX-License-Identifier: Apache-2.0 */
/* _cellwalk.Field: a height field over samples that a Python object holds, or the map of one without them. Checks of dtypes, shapes and values are
 * made in Python (cellwalk/_field.py), whose messages name argument, shape and value. This file only refuses
 * arguments that would read or write out of bounds. */
#ifndef CELLWALK_PYTHON_FIELD_OBJECT_H
#define CELLWALK_PYTHON_FIELD_OBJECT_H

#include "site.h"
#include "work.h"

typedef struct py_field {
    PyObject_HEAD cw_field *field; /* NULL: there are no samples */
    Py_buffer samples;             /* borrowed by the field; contiguous float, ny × nx */
    size_t nx, ny;
    site site;
    terrain terrain, whole; /* whole: of a window */
    map_scale scale;        /* of the whole map, once it is set */
    bool identity;          /* the map is */
    bool on_map;            /* the map has a way back: terrain and whole are set */
    long users;             /* queries that run; -1: an update. Guarded by the GIL */
    long process;           /* in which users were counted: a fork forgets them */
} py_field;

extern PyType_Spec py_field_spec;

/* Whether a buffer holds at least so many bytes; else a ValueError. */
bool buffer_holds(const Py_buffer *buffer, size_t bytes, const char *name);

#endif
