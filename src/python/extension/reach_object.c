/* SPDX-License-Identifier: Apache-2.0 */
#include "reach_object.h"

#include "field_object.h"
#include "ground_plan.h"

#include <math.h>
#include <stdlib.h>

typedef struct py_reach {
    PyObject_HEAD site site;
    terrain whole;
    map_scale scale;
} py_reach;

/* Reach(rows, columns, map, geographic, north_up, unit, semi_major, inverse_flattening, scale or None) */
static PyObject *reach_new(PyTypeObject *type, PyObject *arguments, PyObject *keywords) {
    Py_buffer map = {0}, scale = {0};
    Py_ssize_t rows, columns;
    int geographic, north_up;
    site g = {0};
    (void)keywords;
    if (!PyArg_ParseTuple(arguments, "nny*ppdddz*:Reach", &rows, &columns, &map, &geographic, &north_up, &g.unit,
                          &g.semi_major, &g.inverse_flattening, &scale))
        return NULL;
    g.geographic = geographic != 0;
    g.north_up = north_up != 0;
    const bool good = site_take_map(&map, g.map);
    PyBuffer_Release(&map);
    allocfunc allocate = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    py_reach *r = good ? (py_reach *)allocate(type, 0) : NULL;
    if (r != NULL) r->site = g;
    const bool made = r != NULL && rows >= 2 && columns >= 2 &&
                      site_init(&r->whole, &g, NULL, (size_t)columns, (size_t)rows, NULL) &&
                      site_take_scale(&scale, &r->scale, &r->whole);
    PyBuffer_Release(&scale);
    if (made) return (PyObject *)r;
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, rows < 2 || columns < 2 ? "source: expected at least 2 rows and 2 columns"
                                                                  : "transform: cannot be inverted");
    Py_XDECREF((PyObject *)r);
    return NULL;
}

static void reach_dealloc(PyObject *self) {
    PyTypeObject *type = Py_TYPE(self);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(self);
    Py_DECREF(type);
}

/* Rectangles come and go as (row, column, rows, columns). */
static int to_rectangle(PyObject *object, void *to) {
    Py_ssize_t row, column, rows, columns;
    if (!PyArg_ParseTuple(object, "nnnn:window", &row, &column, &rows, &columns)) return 0;
    /* So the number of its samples and their bytes are a size_t. */
    if (row >= 0 && column >= 0 && rows > 0 && columns > 0 && rows <= CW_SIDE_MAX && columns <= CW_SIDE_MAX) {
        *(cw_rectangle *)to = (cw_rectangle){(size_t)column, (size_t)row, (size_t)columns, (size_t)rows};
        return 1;
    }
    PyErr_SetString(PyExc_ValueError, "window: no rectangle");
    return 0;
}

static PyObject *from_rectangle(cw_rectangle r) {
    if (r.nx == 0 || r.ny == 0) Py_RETURN_NONE;
    return Py_BuildValue("(nnnn)", (Py_ssize_t)r.j, (Py_ssize_t)r.i, (Py_ssize_t)r.ny, (Py_ssize_t)r.nx);
}

/* A window that is to be asked about lies in the raster. */
static bool is_part(const py_reach *r, cw_rectangle part) {
    if (part.i + part.nx <= r->whole.nx && part.j + part.ny <= r->whole.ny) return true;
    PyErr_SetString(PyExc_ValueError, "window: no part of the raster");
    return false;
}

/* beside(window, metres): the window and all so near to it. */
static PyObject *beside(PyObject *self, PyObject *arguments) {
    const py_reach *r = (const py_reach *)self;
    cw_rectangle part;
    double metres;
    if (!PyArg_ParseTuple(arguments, "O&d:beside", to_rectangle, &part, &metres) || !is_part(r, part)) return NULL;
    ground_plan plan = {.by = {.distance = metres}, .whole = &r->whole};
    ground_plan_around(&plan, part, &part);
    return from_rectangle(part);
}

/* grown(window, more): with so many rows and columns more, and at least 2 of each. */
static PyObject *grown(PyObject *self, PyObject *arguments) {
    const py_reach *r = (const py_reach *)self;
    cw_rectangle part;
    double more;
    if (!PyArg_ParseTuple(arguments, "O&d:grown", to_rectangle, &part, &more) || !is_part(r, part)) return NULL;
    return from_rectangle(cw_reach_grow(&r->whole, part, more));
}

/* around(x, y, metres): the part that a viewshed from a place of the map examines, or None. */
static PyObject *around(PyObject *self, PyObject *arguments) {
    const py_reach *r = (const py_reach *)self;
    double x, y, metres, at[2];
    if (!PyArg_ParseTuple(arguments, "ddd:around", &x, &y, &metres)) return NULL;
    if (!cw_terrain_find_place(&r->whole, x, site_northward(&r->site, &r->whole, y), at)) {
        PyErr_SetString(PyExc_ValueError, "x, y: an observer is too far away from the terrain");
        return NULL;
    }
    return from_rectangle(cw_reach_around(&r->whole, at, metres));
}

static size_t blocks_along(size_t samples) { return (samples + REACH_BLOCK - 1) / REACH_BLOCK; }

/* sunward(low, high, highest, lights, window): the window and all that can throw a shadow on it; low and high of all blocks, row by
 * row; azimuth, altitude, radius and curvature of each light. */
static PyObject *sunward(PyObject *self, PyObject *arguments) {
    const py_reach *r = (const py_reach *)self;
    enum { NUMBERS = 4 };
    Py_buffer low = {0}, high = {0}, given = {0};
    float highest;
    cw_rectangle part;
    if (!PyArg_ParseTuple(arguments, "y*y*fy*O&:sunward", &low, &high, &highest, &given, to_rectangle, &part))
        return NULL;
    const size_t count = (size_t)given.len / (NUMBERS * sizeof(double));
    cw_light *lights = calloc(count + 1, sizeof *lights);
    const double *n = given.buf;
    for (size_t k = 0; k < count && lights != NULL; k++, n += NUMBERS)
        lights[k] = (cw_light){.azimuth = n[0], .altitude = n[1], .radius = n[2], .curvature = n[3]};
    ground_plan plan = {.by = {.suns = lights, .sun_count = count},
                        .whole = &r->whole,
                        .blocks = {.whole = &r->whole,
                                   .across = blocks_along(r->whole.nx),
                                   .down = blocks_along(r->whole.ny),
                                   .low = low.buf,
                                   .high = high.buf,
                                   .highest = highest}};
    const size_t bytes = plan.blocks.across * plan.blocks.down * sizeof(float);
    PyObject *answer = NULL;
    if (lights == NULL)
        PyErr_NoMemory();
    else if (buffer_holds(&low, bytes, "low") && buffer_holds(&high, bytes, "high") && is_part(r, part)) {
        ground_plan_around(&plan, part, &part);
        answer = from_rectangle(part);
    }
    free(lights);
    PyBuffer_Release(&given);
    PyBuffer_Release(&low);
    PyBuffer_Release(&high);
    return answer;
}

PyObject *block_ranges(PyObject *self, PyObject *arguments) {
    Py_buffer samples = {0}, low = {0}, high = {0};
    cw_rectangle part;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "y*O&w*w*:block_ranges", &samples, to_rectangle, &part, &low, &high)) return NULL;
    /* The blocks that the rectangle touches are a raster to themselves. */
    part.i %= REACH_BLOCK;
    part.j %= REACH_BLOCK;
    const terrain touched = {.nx = part.i + part.nx, .ny = part.j + part.ny};
    reach_blocks blocks = {.whole = &touched,
                           .across = blocks_along(touched.nx),
                           .down = blocks_along(touched.ny),
                           .low = low.buf,
                           .high = high.buf};
    const size_t n = blocks.across * blocks.down;
    const bool good = buffer_holds(&samples, part.nx * part.ny * sizeof(float), "samples") &&
                      buffer_holds(&low, n * sizeof(float), "low") && buffer_holds(&high, n * sizeof(float), "high");
    if (good) {
        Py_BEGIN_ALLOW_THREADS;
        for (size_t k = 0; k < n; k++) {
            blocks.low[k] = INFINITY;
            blocks.high[k] = -INFINITY;
        }
        cw_reach_blocks_take(&blocks, part, samples.buf);
        Py_END_ALLOW_THREADS;
    }
    PyBuffer_Release(&samples);
    PyBuffer_Release(&low);
    PyBuffer_Release(&high);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

static PyMethodDef methods[] = {
    {"beside", beside, METH_VARARGS, NULL},
    {"grown", grown, METH_VARARGS, NULL},
    {"around", around, METH_VARARGS, NULL},
    {"sunward", sunward, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

static PyType_Slot slots[] = {
    {Py_tp_new, (void *)reach_new},
    {Py_tp_dealloc, (void *)reach_dealloc},
    {Py_tp_methods, methods},
    {0, NULL},
};

PyType_Spec py_reach_spec = {
    .name = "cellwalk._cellwalk.Reach",
    .basicsize = sizeof(py_reach),
    .flags = Py_TPFLAGS_DEFAULT,
    .slots = slots,
};
