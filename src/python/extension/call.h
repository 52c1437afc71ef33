/* SPDX-License-Identifier: Apache-2.0 */
/* All that a field is asked: Field.make(name, numbers, window, inputs, outputs, threads, progress[, kernel]). Python checks and names
 * the numbers; a product here picks those that it has a use for. */
#ifndef CELLWALK_PYTHON_CALL_H
#define CELLWALK_PYTHON_CALL_H

#include "field_object.h"

/* What products take: doubles, 0 where the caller names none. */
/* clang-format off */
#define CALL_NUMBERS(NUMBER) \
    NUMBER(altitude) NUMBER(azimuth) NUMBER(azimuth_until) NUMBER(bands) NUMBER(below) NUMBER(curvature) NUMBER(days) \
    NUMBER(directions) NUMBER(disc) NUMBER(every) NUMBER(facing) NUMBER(factor) NUMBER(filter) NUMBER(first) \
    NUMBER(frequency) NUMBER(has_azimuths) NUMBER(has_verticals) NUMBER(highest) NUMBER(hillshade) NUMBER(hours) \
    NUMBER(kind) NUMBER(latitude) NUMBER(lean) NUMBER(linke) NUMBER(longitude) NUMBER(lowest) NUMBER(max_distance) \
    NUMBER(min_distance) NUMBER(more) NUMBER(observer_height) NUMBER(share) NUMBER(sky) NUMBER(start) NUMBER(step) \
    NUMBER(table) NUMBER(target_height) NUMBER(tilt) NUMBER(turned) NUMBER(within) NUMBER(x) NUMBER(y)
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
product make_angles, make_distances, make_hours, make_irradiance, make_openness, make_shadow, make_sky, make_tilted_sky,
    make_visibility;
product make_along, make_found, make_lines, make_place_horizons, make_profile, make_sun_days, make_viewshed;
product make_around, make_beside, make_grown, make_sunward;

PyObject *field_make(PyObject *self, PyObject *arguments);

#endif
