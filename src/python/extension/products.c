/* SPDX-License-Identifier: Apache-2.0 */
/* Sunlight and horizons, row by row into the caller's arrays. Messages name arguments as cellwalk/_products.py calls them. */
#include "field.h"
#include "horizon.h"
#include "shadow.h"
#include "visibility.h"

#include <math.h>
#include <stdlib.h>

/* So many angles are computed between two looks for Ctrl-C: 0.1 s on one thread. */
enum { ANGLES_AT_ONCE = 1 << 20 };

static size_t rows_at_once(const py_field *f, double passes) {
    const double rows = ANGLES_AT_ONCE / (passes * (double)f->nx);
    return rows < 1 ? 1 : (size_t)rows;
}

/* ---- the sun ----------------------------------------------------------------------------------------------------- */

static cw_status light_rows(py_field *f, work *w, const sunlight_desc *d, size_t row, size_t rows, uint8_t *lit,
                            float *share) {
    sunlight *light;
    cw_status status = sunlight_create(&f->terrain, d, &light);
    if (status != CW_OK) return status;
    const size_t most = rows_at_once(f, d->radius > 0 ? 16 : 1);
    for (size_t k = 0, count; k < rows && status == CW_OK; k += count) {
        count = rows - k < most ? rows - k : most;
        if (!work_watch(w, (double)k / (double)rows))
            status = CW_ERROR_CANCELLED;
        else if (share)
            status = sunlight_share(light, &w->run, row + k, count, share + k * f->nx);
        else
            status = sunlight_lit(light, &w->run, row + k, count, lit + k * f->nx);
    }
    sunlight_destroy(light);
    return status;
}

static bool check_rows(const py_field *f, Py_ssize_t row, Py_ssize_t rows) {
    if (row >= 0 && rows >= 0 && (size_t)rows <= f->ny && (size_t)row <= f->ny - (size_t)rows) return true;
    PyErr_SetString(PyExc_ValueError, "rows: no part of the field");
    return false;
}

/* shadow(azimuth, altitude, radius, curvature, hillshade, row, rows, as_share, out, threads, progress) */
PyObject *field_shadow(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    sunlight_desc d = {0};
    Py_buffer out = {0};
    Py_ssize_t row, rows;
    int hillshade, share;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "ddddpnnpw*IO:shadow", &d.azimuth, &d.altitude, &d.radius, &d.curvature,
                          &hillshade, &row, &rows, &share, &out, &threads, &progress))
        return NULL;
    d.hillshade = hillshade != 0;
    bool good = check_rows(f, row, rows) &&
                buffer_holds(&out, (size_t)rows * f->nx * (share ? sizeof(float) : 1), "out") && field_enter_ground(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            w.run.watch = work_look;
            const cw_status status =
                light_rows(f, &w, &d, (size_t)row, (size_t)rows, share ? NULL : out.buf, share ? out.buf : NULL);
            good = work_end(&w, status, "shadow");
        }
        field_leave(f);
    }
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

/* ---- horizons ---------------------------------------------------------------------------------------------------- */

static cw_status angle_rows(py_field *f, work *w, const horizon_desc *desc, size_t row, size_t rows, float *out,
                            double *azimuths) {
    horizon *h;
    cw_status status = horizon_create(&f->terrain, desc, &h);
    const size_t most = rows_at_once(f, 1);
    for (size_t k = 0; k < desc->count && status == CW_OK; k++) {
        azimuths[k] = horizon_azimuth(h, k);
        for (size_t r = 0, some; r < rows && status == CW_OK; r += some) {
            some = rows - r < most ? rows - r : most;
            const double done = ((double)k + (double)r / (double)rows) / (double)desc->count;
            float *angles = out + (k * rows + r) * f->nx;
            status = work_watch(w, done) ? horizon_angles(h, &w->run, k, row + r, some, angles) : CW_ERROR_CANCELLED;
            for (size_t n = 0; n < some * f->nx && status == CW_OK; n++)
                if (angles[n] == -90) angles[n] = NAN; /* nothing is there: no horizon */
        }
    }
    horizon_destroy(h);
    return status;
}

/* horizon(start, directions, max_distance, curvature, grid, row, rows, out, azimuths, threads, progress): out holds directions ×
 * rows × nx floats, azimuths a double a direction. */
PyObject *field_horizon(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    horizon_desc d = {0};
    Py_buffer out = {0}, azimuths = {0};
    Py_ssize_t count, row, rows;
    int grid;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "dnddpnnw*w*IO:horizon", &d.start, &count, &d.max_distance, &d.curvature, &grid,
                          &row, &rows, &out, &azimuths, &threads, &progress))
        return NULL;
    d.count = (size_t)count;
    d.grid = grid != 0;
    bool good = count > 0 && check_rows(f, row, rows) &&
                buffer_holds(&out, d.count * (size_t)rows * f->nx * sizeof(float), "out") &&
                buffer_holds(&azimuths, d.count * sizeof(double), "azimuths") && field_enter_ground(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            w.run.watch = work_look;
            good = work_end(&w, angle_rows(f, &w, &d, (size_t)row, (size_t)rows, out.buf, azimuths.buf), "horizon");
        }
        field_leave(f);
    }
    PyBuffer_Release(&out);
    PyBuffer_Release(&azimuths);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

static cw_status sky_rows(py_field *f, work *w, const horizon_desc *desc, bool tilted, size_t row, size_t rows,
                          float *out) {
    horizon *h;
    cw_status status = horizon_create(&f->terrain, desc, &h);
    const size_t most = rows_at_once(f, 1);
    for (size_t r = 0, some; r < rows && status == CW_OK; r += some) {
        some = rows - r < most ? rows - r : most;
        bool done = work_part(w, (double)r / (double)rows, (double)some / (double)rows);
        if (done)
            status = (tilted ? horizon_sky_view_tilted : horizon_sky_view)(h, &w->run, row + r, some, out + r * f->nx,
                                                                           work_watch, w, &done);
        if (!done && status == CW_OK) status = CW_ERROR_CANCELLED;
    }
    horizon_destroy(h);
    return status;
}

/* sky_view(directions, max_distance, curvature, grid, tilted, row, rows, out, threads, progress) */
PyObject *field_sky_view(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    horizon_desc d = {0};
    Py_buffer out = {0};
    Py_ssize_t count, row, rows;
    int grid, tilted;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "nddppnnw*IO:sky_view", &count, &d.max_distance, &d.curvature, &grid, &tilted,
                          &row, &rows, &out, &threads, &progress))
        return NULL;
    d.count = (size_t)count;
    d.grid = grid != 0;
    bool good = count > 0 && check_rows(f, row, rows) &&
                buffer_holds(&out, (size_t)rows * f->nx * sizeof(float), "out") && field_enter_ground(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            w.run.watch = work_look;
            const cw_status status = sky_rows(f, &w, &d, tilted != 0, (size_t)row, (size_t)rows, out.buf);
            good = work_end(&w, status, "sky_view");
        }
        field_leave(f);
    }
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

/* ---- the ground in sight ------------------------------------------------------------------------------------------- */

/* visibility(directions, max_distance, eye, target, curvature, every, kind, row, column, rows, columns, out, threads, progress):
 * kind: a for the area, s for its share, l for the longest line of sight, z for that one's azimuth. */
PyObject *field_visibility(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    visibility_desc d = {0};
    Py_buffer out = {0};
    Py_ssize_t directions, every, row, column, rows, columns;
    int kind;
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "nddddnCnnnnw*IO:visibility", &directions, &d.max_distance, &d.eye_height,
                          &d.target_height, &d.curvature, &every, &kind, &row, &column, &rows, &columns, &out, &threads,
                          &progress))
        return NULL;
    const size_t wide = every > 0 ? (size_t)((columns + every - 1) / every) : 0,
                 high = every > 0 ? (size_t)((rows + every - 1) / every) : 0, eyes = wide * high;
    d.directions = (size_t)directions;
    d.every = (size_t)every;
    bool good = directions > 0 && every > 0 && column >= 0 && columns >= 0 && check_rows(f, row, rows) &&
                buffer_holds(&out, eyes * sizeof(float), "out") && field_enter_ground(f);
    if (good) {
        work w;
        float *other = kind == 'l' || kind == 'z' ? malloc(eyes * sizeof *other + 1) : NULL;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            visibility_answers to = {.area = kind == 'a' ? out.buf : NULL, .share = kind == 's' ? out.buf : NULL};
            if (other != NULL) {
                to.farthest = kind == 'l' ? out.buf : other;
                to.azimuth = kind == 'l' ? other : out.buf;
            }
            const cw_rectangle at = {(size_t)column, (size_t)row, (size_t)columns, (size_t)rows};
            bool done = false;
            cw_status status = other == NULL && (kind == 'l' || kind == 'z')
                                   ? CW_ERROR_MEMORY
                                   : visibility_find(&f->terrain, &d, &w.run, at, &to, work_watch, &w, &done);
            if (status == CW_OK && !done) status = CW_ERROR_CANCELLED;
            good = work_end(&w, status, "visibility");
        }
        free(other);
        field_leave(f);
    }
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}
