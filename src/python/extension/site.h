/* SPDX-License-Identifier: Apache-2.0 */
/* How the samples of an array lie on the earth, as Python says it. */
#ifndef CELLWALK_PYTHON_SITE_H
#define CELLWALK_PYTHON_SITE_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "terrain.h"

typedef struct site {
    double map[3][4]; /* samples (column, row, z) to x, y, z */
    bool geographic;
    bool north_up; /* there is no map: products have the first row in the north, though y is the row */
    double unit, semi_major, inverse_flattening;
} site;

/* Gives the terrain the scale that find_scale returned, copied to where it stays; none if the buffer has no object. False
 * with an exception if the buffer is of another size. */
bool site_take_scale(const Py_buffer *buffer, map_scale *to, terrain *t);

/* A buffer of 12 doubles. False with an exception if it is shorter. */
bool site_take_map(const Py_buffer *buffer, double map[3][4]);

/* False if the map cannot be inverted. field and z may be NULL, for a terrain that only its map and size are used of. */
bool site_init(terrain *t, const site *g, const cw_field *field, size_t nx, size_t ny, const float *z);

/* y of the caller's to that of the terrain, and back. */
double site_northward(const site *g, const terrain *t, double y);

#endif
