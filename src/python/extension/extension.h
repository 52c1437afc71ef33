/* SPDX-License-Identifier: Apache-2.0 */
/* Most of what Python asks: Field.make(name, numbers, window, inputs, outputs, pool, progress[, kernel[, text]]), a product of the table in
 * call.c. Python checks dtypes, shapes and values, and its messages name argument, shape and value; a product picks the numbers that
 * it has a use for, and only refuses arguments that would read or write out of bounds. */
#ifndef CELLWALK_PYTHON_EXTENSION_H
#define CELLWALK_PYTHON_EXTENSION_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include "sight.h"

#include <cellwalk_expert.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

/* Field: below. GeoTiff: written by windows, through the same code as the program's results: nothing has the name before all is on the
 * disk, and a disk that is full is an error. */
extern PyType_Spec py_field_spec, py_geotiff_spec;

/* Copies so many bytes, if a buffer holds them; else a ValueError. */
bool buffer_copy(const Py_buffer *buffer, void *to, size_t bytes, const char *name);

/* ---- how a call runs: without the GIL, on a pool, under a watch that looks for Ctrl-C and tells a progress callable -------- */

typedef struct work {
    cw_run run; /* pool, kernel and watch are set */
    PyObject *progress;
    PyThreadState *state;
    pthread_t caller;
    double next;         /* when the watch looks again, by the clock */
    double begin, share; /* the part of all work that is being done, for work_watch */
    atomic_bool stopped; /* an exception is set */
} work;

/* Makes w ready and releases the GIL. pool is None or a capsule that stays, progress None or a callable, kernel NULL or a name. False
 * with an exception set. */
bool work_begin(work *w, PyObject *pool, const char *kernel, PyObject *progress);

/* Takes the GIL back. False, with an exception that begins with the name, unless status is CW_OK and nothing stopped the work. */
bool work_end(work *w, cw_status status, const char *name);

/* A cw_watch_fn: context is the work. From threads other than the caller's it only says whether
 * the work is stopped, since Python handles signals on its own threads. */
bool work_watch(void *context, double done);

/* For work in parts: from here on the watch is told shares of [begin, begin + share]. False if the work is stopped. */
bool work_part(work *w, double begin, double share);

/* Around each use of GDAL's module, which is for one thread at a time: gives the GIL back, then waits for the others. In this order,
 * since who is inside may ask for the GIL, to warn or to tell progress. */
PyThreadState *raster_enter(void);
void raster_leave(PyThreadState *state);

/* ---- a field ---------------------------------------------------------------------------------------------------------- */

/* _cellwalk.Field: a height field over samples that a Python object holds, or the map of one without them. */
typedef struct py_field {
    PyObject_HEAD cw_field *field; /* NULL: there are no samples */
    Py_buffer samples;             /* borrowed by the field; contiguous float, ny × nx */
    size_t nx, ny;
    double map[3][4];               /* samples (column, row, z) to x, y, z */
    bool north_up;                  /* there is no map: products have the first row in the north, though y is the row */
    terrain terrain, whole;         /* whole: of a window */
    map_scale scale;                /* of the whole map, once it is set */
    bool identity;                  /* the map is */
    bool on_map;                    /* the map has a way back: terrain and whole are set */
    _Atomic(sight_bounds *) bounds; /* of the samples, once a call needs them */
    long users;                     /* queries that run; -1: an update. Guarded by the GIL */
    long process;                   /* in which users were counted: a fork forgets them */
} py_field;

/* The highest samples of blocks, for lines over the field. */
cw_status field_bounds(py_field *f, const sight_bounds **bounds);

/* y of the caller's to that of the terrain, and back. */
static inline double northward(const py_field *f, double y) {
    return f->north_up ? f->map[0][0] * (double)(terrain_whole(&f->terrain)->ny - 1) - y : y;
}

/* ---- a call ----------------------------------------------------------------------------------------------------------- */

/* What products take: doubles, 0 where the caller names none. */
/* clang-format off */
#define CALL_NUMBERS(NUMBER) \
    NUMBER(altitude) NUMBER(azimuth) NUMBER(azimuth_until) NUMBER(bands) NUMBER(below) NUMBER(curvature) NUMBER(days) \
    NUMBER(directions) NUMBER(disc) NUMBER(energy) NUMBER(every) NUMBER(facing) NUMBER(factor) NUMBER(filter) \
    NUMBER(first) NUMBER(frequency) NUMBER(has_azimuths) NUMBER(has_verticals) NUMBER(highest) NUMBER(hillshade) \
    NUMBER(hours) NUMBER(kind) NUMBER(latitude) NUMBER(lean) NUMBER(linke) NUMBER(longitude) NUMBER(lowest) \
    NUMBER(max_distance) NUMBER(metres) NUMBER(min_distance) NUMBER(observer_height) NUMBER(share) NUMBER(sky) \
    NUMBER(start) NUMBER(step) NUMBER(target_height) NUMBER(tilt) NUMBER(tilted) NUMBER(turned) NUMBER(x) NUMBER(y)
/* clang-format on */
typedef struct call_numbers {
#define MEMBER(name) double name;
    CALL_NUMBERS(MEMBER)
#undef MEMBER
} call_numbers;

enum { CALL_BUFFERS_MOST = 4 };

typedef struct call {
    py_field *field;
    work work;
    const char *text; /* what the product says, or NULL */
    call_numbers n;
    cw_rectangle at; /* of the field's samples */
    Py_buffer in[CALL_BUFFERS_MOST], out[CALL_BUFFERS_MOST];
    size_t in_count, out_count;
    char error[512]; /* the text of a ValueError; "": the status says what is wrong */
} call;

/* Runs without the GIL. A status other than CW_OK becomes an exception, and so does a Ctrl-C that a watch finds. */
typedef cw_status product(call *c);

/* Output number k, or NULL with an error unless it has so many bytes. */
void *call_output(call *c, size_t k, size_t bytes);

/* Input number k as records of so many bytes, and how many these are: none if it has gaps. */
const void *call_input(call *c, size_t k, size_t bytes, size_t *count);

/* Sets the error; returns CW_ERROR_ARGUMENT. */
__attribute__((format(printf, 2, 3))) cw_status call_fail(call *c, const char *format, ...);

/* By file: rays.c and field_object.c, products.c, views.c, raster_object.c. */
product make_closest, make_occluded, make_heights, make_points, make_coarser, make_scale, make_update;
product make_around, make_grown, make_horizon, make_insolation, make_openness, make_reach, make_shadow, make_sky;
product make_suns, make_visibility;
product make_along, make_found, make_lines, make_place_horizons, make_profile, make_sun_days, make_viewshed;
product make_place;

/* ---- functions of the module ------------------------------------------------------------------------------------------ */

PyObject *field_make(PyObject *self, PyObject *arguments);

/* make_pool(threads) -> a capsule, whose threads end with it */
PyObject *make_pool(PyObject *self, PyObject *arguments);

/* describe_crs(wkt) -> (wkt, geographic, unit, semi_major, inverse_flattening), or None */
PyObject *describe_crs(PyObject *self, PyObject *arguments);

/* find_scale(wkt, map, rows, columns, name) -> (bytes or None, warnings): the scale of a projected map */
PyObject *find_scale(PyObject *self, PyObject *arguments);

/* read_raster(path, band[, nodata, cellsize, zscale, (column, row, columns, rows), progress]) -> a dict that says all of the raster:
 * without a window of its header alone, if the format has windows */
PyObject *read_raster(PyObject *self, PyObject *arguments);

#endif
