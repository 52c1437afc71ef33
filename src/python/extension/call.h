/* SPDX-License-Identifier: Apache-2.0 */
/* All that a field is asked: Field.make(name, numbers, window, inputs, outputs, pool, progress[, kernel]). Python checks and names
 * the numbers; a product here picks those that it has a use for. */
#ifndef CELLWALK_PYTHON_CALL_H
#define CELLWALK_PYTHON_CALL_H

#include "extension.h"
#include "sight.h"
#include "work.h"

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
    call_numbers n;
    cw_rectangle at; /* of the field's samples */
    Py_buffer in[CALL_BUFFERS_MOST], out[CALL_BUFFERS_MOST];
    size_t in_count, out_count;
    char error[256]; /* the text of a ValueError; "": the status says what is wrong */
} call;

/* Runs without the GIL. A status other than CW_OK becomes an exception, and so does a Ctrl-C that a watch finds. */
typedef cw_status product(call *c);

/* Output number k, or NULL with an error unless it has so many bytes. */
void *call_output(call *c, size_t k, size_t bytes);

/* Input number k as records of so many bytes, and how many these are: none if it has gaps. */
const void *call_input(call *c, size_t k, size_t bytes, size_t *count);

/* Sets the error; returns CW_ERROR_ARGUMENT. */
__attribute__((format(printf, 2, 3))) cw_status call_fail(call *c, const char *format, ...);

/* By file: rays.c and field_object.c, products.c, views.c, pieces.c. */
product make_closest, make_occluded, make_heights, make_points, make_coarser, make_update;
product make_horizon, make_insolation, make_openness, make_shadow, make_sky, make_visibility;
product make_along, make_found, make_lines, make_place_horizons, make_profile, make_sun_days, make_viewshed;
product make_around, make_beside, make_grown, make_sunward;

PyObject *field_make(PyObject *self, PyObject *arguments);

#endif
