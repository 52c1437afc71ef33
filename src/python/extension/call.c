/* SPDX-License-Identifier: Apache-2.0 */
#include "call.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    product *make;
} products[] = {
    {"horizon", make_angles},
    {"horizon_distance", make_distances},
    {"hours", make_hours},
    {"shadow", make_shadow},
    {"irradiance", make_irradiance},
    {"sky_view", make_sky},
    {"sky_view_tilted", make_tilted_sky},
    {"visibility", make_visibility},
    {"found", make_found},
    {"along", make_along},
    {"viewshed", make_viewshed},
    {"line_of_sight", make_lines},
    {"profile", make_profile},
    {"openness", make_openness},
    {"sun_days", make_sun_days},
    {"place_horizon", make_place_horizons},
};

#define NUMBER(name)                                                                                                   \
    { #name, offsetof(call_numbers, name) }
static const struct {
    const char *name;
    size_t at;
} numbers[] = {
    NUMBER(altitude),     NUMBER(azimuth),      NUMBER(azimuth_until),
    NUMBER(bands),        NUMBER(below),        NUMBER(curvature),
    NUMBER(days),         NUMBER(directions),   NUMBER(disc),
    NUMBER(every),        NUMBER(facing),       NUMBER(first),
    NUMBER(frequency),    NUMBER(has_azimuths), NUMBER(has_verticals),
    NUMBER(highest),      NUMBER(hillshade),    NUMBER(hours),
    NUMBER(kind),         NUMBER(latitude),     NUMBER(lean),
    NUMBER(linke),        NUMBER(longitude),    NUMBER(lowest),
    NUMBER(max_distance), NUMBER(min_distance), NUMBER(observer_height),
    NUMBER(share),        NUMBER(sky),          NUMBER(start),
    NUMBER(step),         NUMBER(table),        NUMBER(target_height),
    NUMBER(tilt),         NUMBER(turned),       NUMBER(within),
};
#undef NUMBER

cw_status call_fail(call *c, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(c->error, sizeof c->error, format, list);
    va_end(list);
    return CW_ERROR_ARGUMENT;
}

void *call_output(call *c, size_t k, size_t bytes) {
    if (k < c->out_count && (size_t)c->out[k].len >= bytes) return c->out[k].buf;
    call_fail(c, "output %zu: fewer than %zu bytes", k, bytes);
    return NULL;
}

const void *call_input(call *c, size_t k, size_t bytes, size_t *count) {
    *count = k < c->in_count ? (size_t)c->in[k].len / bytes : 0;
    return *count > 0 ? c->in[k].buf : NULL;
}

/* ---- the call -------------------------------------------------------------------------------------------------------- */

static bool take_numbers(PyObject *given, call_numbers *to) {
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        PyObject *value = PyDict_GetItemString(given, numbers[k].name); /* borrowed */
        const double number = value ? PyFloat_AsDouble(value) : 0;
        if (PyErr_Occurred()) return false;
        memcpy((char *)to + numbers[k].at, &number, sizeof number);
    }
    return true;
}

static bool take_buffers(PyObject *tuple, int flags, Py_buffer to[CALL_BUFFERS_MOST], size_t *count) {
    const Py_ssize_t n = PyTuple_Size(tuple);
    if (n > CALL_BUFFERS_MOST) PyErr_SetString(PyExc_ValueError, "make: too many buffers");
    for (; !PyErr_Occurred() && (Py_ssize_t)*count < n; ++*count)
        if (PyObject_GetBuffer(PyTuple_GetItem(tuple, (Py_ssize_t)*count), &to[*count], flags) != 0) return false;
    return !PyErr_Occurred();
}

static bool take_window(const py_field *f, const Py_ssize_t w[4], cw_rectangle *at) {
    *at = (cw_rectangle){(size_t)w[1], (size_t)w[0], (size_t)w[3], (size_t)w[2]};
    if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && w[3] >= 0 && at->nx <= f->nx && at->ny <= f->ny &&
        at->i <= f->nx - at->nx && at->j <= f->ny - at->ny)
        return true;
    PyErr_SetString(PyExc_ValueError, "window: no part of the field");
    return false;
}

static product *find_product(const char *name) {
    for (size_t k = 0; k < sizeof products / sizeof *products; k++)
        if (strcmp(products[k].name, name) == 0) return products[k].make;
    PyErr_Format(PyExc_ValueError, "make: no product '%s'", name);
    return NULL;
}

static bool run(call *c, product *make, const char *name, unsigned threads, PyObject *progress) {
    if (!work_begin(&c->work, threads, NULL, progress)) return false;
    const cw_status status = make(c);
    if (!work_end(&c->work, c->error[0] ? CW_OK : status, name)) return false;
    if (c->error[0]) PyErr_SetString(PyExc_ValueError, c->error);
    return !c->error[0];
}

PyObject *field_make(PyObject *self, PyObject *arguments) {
    call c = {.field = (py_field *)self};
    const char *name;
    PyObject *given, *inputs, *outputs, *progress;
    Py_ssize_t window[4];
    unsigned threads;
    if (!PyArg_ParseTuple(arguments, "sO!(nnnn)O!O!IO:make", &name, &PyDict_Type, &given, &window[0], &window[1],
                          &window[2], &window[3], &PyTuple_Type, &inputs, &PyTuple_Type, &outputs, &threads, &progress))
        return NULL;
    product *make = find_product(name);
    bool good = make != NULL && take_numbers(given, &c.n) && take_window(c.field, window, &c.at) &&
                take_buffers(inputs, PyBUF_SIMPLE, c.in, &c.in_count) &&
                take_buffers(outputs, PyBUF_WRITABLE, c.out, &c.out_count);
    if (good && (good = field_enter_site(c.field))) {
        good = run(&c, make, name, threads, progress);
        field_leave(c.field);
    }
    while (c.in_count > 0) PyBuffer_Release(&c.in[--c.in_count]);
    while (c.out_count > 0) PyBuffer_Release(&c.out[--c.out_count]);
    if (!good) return NULL;
    Py_RETURN_NONE;
}
