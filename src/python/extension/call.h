/* SPDX-License-Identifier: Apache-2.0 */
/* A call of one of the products of src/terrain: Field.make(name, numbers, window, inputs, outputs, threads, progress). Python checks
 * and names the numbers; a product here picks those that it has a use for. */
#ifndef CELLWALK_PYTHON_CALL_H
#define CELLWALK_PYTHON_CALL_H

#include "field_object.h"

/* What products take: 0 where the caller names none. */
typedef struct call_numbers {
    double altitude, azimuth, azimuth_until, bands, below, curvature, days, directions, disc, every, facing, first,
        frequency, has_azimuths, has_verticals, highest, hillshade, hours, kind, latitude, lean, linke, longitude,
        lowest, max_distance, min_distance, observer_height, share, sky, start, step, table, target_height, tilt,
        turned, within;
} call_numbers;

enum { CALL_BUFFERS_MOST = 3 };

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

/* Input number k as records of so many bytes, and how many these are. */
const void *call_input(call *c, size_t k, size_t bytes, size_t *count);

/* Sets the error; returns CW_ERROR_ARGUMENT. */
__attribute__((format(printf, 2, 3))) cw_status call_fail(call *c, const char *format, ...);

/* Products by file. */
product make_along, make_angles, make_distances, make_found, make_hours, make_irradiance, make_lines, make_openness,
    make_place_horizons, make_profile, make_shadow, make_sky, make_sun_days, make_tilted_sky, make_visibility,
    make_viewshed;

PyObject *field_make(PyObject *self, PyObject *arguments);

#endif
