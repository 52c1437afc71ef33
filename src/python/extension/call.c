/* SPDX-License-Identifier: Apache-2.0 */
#include "extension.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* What a call needs of its field. */
typedef enum call_needs {
    TERRAIN, /* samples on a map that has a way back */
    MAP,     /* such a map alone */
    SAMPLES, /* on any map */
    ALL      /* of the samples, and no other call at work */
} call_needs;

typedef struct entry {
    const char *name; /* messages begin with it */
    product *make;
    call_needs needs;
} entry;

static const entry products[] = {
    {"closest", make_closest, SAMPLES},
    {"occluded", make_occluded, SAMPLES},
    {"at", make_heights, SAMPLES},
    {"points", make_points, SAMPLES},
    {"normals", make_points, SAMPLES},
    {"coarser", make_coarser, SAMPLES},
    {"block", make_update, ALL},
    {"horizon", make_horizon, TERRAIN},
    {"shadow", make_shadow, TERRAIN},
    {"insolation", make_insolation, TERRAIN},
    {"sky_view", make_sky, TERRAIN},
    {"visibility", make_visibility, TERRAIN},
    {"found", make_found, TERRAIN},
    {"along", make_along, TERRAIN},
    {"viewshed", make_viewshed, TERRAIN},
    {"line_of_sight", make_lines, TERRAIN},
    {"profile", make_profile, TERRAIN},
    {"openness", make_openness, TERRAIN},
    {"sun_days", make_sun_days, TERRAIN},
    {"place_horizon", make_place_horizons, TERRAIN},
    {"beside", make_reach, MAP},
    {"sunward", make_reach, MAP},
    {"around", make_around, MAP},
    {"grown", make_grown, MAP},
    {"suns", make_suns, MAP},
    {"crs", make_place, MAP},
    {"scale", make_scale, MAP},
};

#define NAME(number) #number,
static const char *const numbers[] = {CALL_NUMBERS(NAME)};
#undef NAME
_Static_assert(sizeof(call_numbers) == sizeof numbers / sizeof *numbers * sizeof(double), "one double a name");

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
    const bool dense = k < c->in_count && PyBuffer_IsContiguous(&c->in[k], 'C');
    *count = dense ? (size_t)c->in[k].len / bytes : 0;
    return *count > 0 ? c->in[k].buf : NULL;
}

/* ---- the field ------------------------------------------------------------------------------------------------------- */

static bool refuse(PyObject *kind, const char *why) {
    PyErr_SetString(kind, why);
    return false;
}

static void forget_other_process(py_field *f) {
    const long process = (long)getpid();
    if (f->process != process) f->users = 0;
    f->process = process;
}

/* The field is not to be changed from here to leave, nor touched by others if the call needs all of it. */
static bool enter(py_field *f, call_needs needs) {
    if (needs != MAP && f->field == NULL) return refuse(PyExc_ValueError, "the field has no samples");
    if (needs <= MAP && !f->on_map) return refuse(PyExc_ValueError, "transform: cannot be inverted");
    if (needs == ALL && f->users != 0)
        return refuse(PyExc_RuntimeError, "update: queries or another update are running on the field");
    if (needs == ALL && f->samples.readonly) return refuse(PyExc_RuntimeError, "update: the samples are read-only");
    if (f->users < 0) return refuse(PyExc_RuntimeError, "the field is being changed by another thread");
    f->users += needs == ALL ? -1 : 1;
    return true;
}

static void leave(py_field *f, call_needs needs) { f->users += needs == ALL ? 1 : -1; }

/* Builds the structure of a kernel if the field lacks it. Must not run beside queries. */
static bool make_ready(py_field *f, PyObject *pool, const char *kernel, PyObject *progress) {
    const cw_run run = {.expert.kernel = cw_kernel_find(kernel)};
    work w;
    if (f->field == NULL || f->users < 0 || cw_run_check(f->field, &run) != CW_ERROR_NOT_BUILT) return true;
    if (f->users != 0) {
        PyErr_Format(PyExc_RuntimeError, "kernel: %s is to be built first, but other queries are running", kernel);
        return false;
    }
    f->users = -1;
    const bool good =
        work_begin(&w, pool, kernel, progress) && work_end(&w, cw_field_build(f->field, &w.run), "kernel");
    f->users = 0;
    return good;
}

/* ---- the call -------------------------------------------------------------------------------------------------------- */

static bool take_numbers(PyObject *given, call_numbers *to) {
    for (size_t k = 0; PyDict_Size(given) > 0 && k < sizeof numbers / sizeof *numbers; k++) {
        PyObject *value = PyDict_GetItemString(given, numbers[k]); /* borrowed */
        if (value) ((double *)to)[k] = PyFloat_AsDouble(value);
        if (PyErr_Occurred()) return false;
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
    return refuse(PyExc_ValueError, "window: no part of the field");
}

static const entry *find_product(const char *name) {
    for (size_t k = 0; k < sizeof products / sizeof *products; k++)
        if (strcmp(products[k].name, name) == 0) return &products[k];
    PyErr_Format(PyExc_ValueError, "make: no product '%s'", name);
    return NULL;
}

static bool run(call *c, const entry *e, PyObject *pool, const char *kernel, PyObject *progress) {
    if (!work_begin(&c->work, pool, kernel, progress)) return false;
    const cw_status status = e->make(c);
    if (!work_end(&c->work, c->error[0] ? CW_OK : status, e->name)) return false;
    return !c->error[0] || refuse(PyExc_ValueError, c->error);
}

PyObject *field_make(PyObject *self, PyObject *arguments) {
    call c = {.field = (py_field *)self};
    const char *name, *kernel = NULL;
    PyObject *given, *inputs, *outputs, *pool, *progress;
    Py_ssize_t window[4];
    if (!PyArg_ParseTuple(arguments, "sO!(nnnn)O!O!OO|zz:make", &name, &PyDict_Type, &given, &window[0], &window[1],
                          &window[2], &window[3], &PyTuple_Type, &inputs, &PyTuple_Type, &outputs, &pool, &progress,
                          &kernel, &c.text))
        return NULL;
    forget_other_process(c.field);
    const entry *e = find_product(name);
    bool good = e != NULL && take_numbers(given, &c.n) && take_window(c.field, window, &c.at) &&
                take_buffers(inputs, PyBUF_STRIDED_RO, c.in, &c.in_count) &&
                take_buffers(outputs, PyBUF_WRITABLE, c.out, &c.out_count) &&
                (kernel == NULL || make_ready(c.field, pool, kernel, progress));
    if (good && (good = enter(c.field, e->needs))) {
        good = run(&c, e, pool, kernel, progress);
        leave(c.field, e->needs);
    }
    while (c.in_count > 0) PyBuffer_Release(&c.in[--c.in_count]);
    while (c.out_count > 0) PyBuffer_Release(&c.out[--c.out_count]);
    if (!good) return NULL;
    Py_RETURN_NONE;
}
