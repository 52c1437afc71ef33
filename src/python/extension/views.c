/* SPDX-License-Identifier: Apache-2.0 */
/* Viewsheds and lines of sight. Places come as the map's. */
#include "field.h"
#include "viewshed.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct viewing {
    py_field *field;
    work *work;
    const double (*places)[3]; /* x, y, height of the eye */
    size_t count;
    viewshed_desc desc;
    uint16_t *seen;
    float *heights;
} viewing;

/* y of the caller's to that of the terrain, and back. */
static double northward(const py_field *f, double y) { return ground_northward(&f->ground, &f->terrain, y); }

/* The faults of a place, in the order of _places_wrong in cellwalk/_products.py. */
typedef enum finding { NO_GROUND, TOO_FAR, UNDER_GROUND, FOUND } finding;

/* So far under the ground a place may be: its height may come from decimals. As in the program. */
static const double least_depth = 0.001;

/* A place in field coordinates, height in the samples' numbers. */
static finding find_place(const py_field *f, const double place[3], bool absolute, double at[3]) {
    const terrain *t = &f->terrain;
    if (!terrain_find_place(t, place[0], northward(f, place[1]), at)) return TOO_FAR;
    const double level = terrain_height(t, at[0], at[1]), height = absolute ? place[2] : level + place[2];
    at[2] = height / terrain_metres_of_height(t);
    if (!absolute && isnan(level)) return NO_GROUND;
    if (height < level - least_depth) return UNDER_GROUND;
    return isfinite(at[2]) ? FOUND : TOO_FAR;
}

static cw_status view_from(const viewing *v, size_t number, const sight_bounds *bounds) {
    viewshed_desc d = v->desc;
    const terrain *t = &v->field->terrain;
    double eye[3];
    find_place(v->field, v->places[number], d.absolute, eye);
    d.place[0] = eye[0];
    d.place[1] = eye[1];
    d.height = eye[2] * terrain_metres_of_height(t);
    d.absolute = true;
    viewshed *shed;
    cw_status status = viewshed_create(t, bounds, &d, &shed);
    if (status != CW_OK) return status;
    bool done = work_part(v->work, (double)number / (double)v->count, 1 / (double)v->count);
    if (done)
        status = v->seen ? viewshed_count(shed, &v->work->run, v->seen, work_watch, v->work, &done)
                         : viewshed_heights(shed, &v->work->run, v->heights, work_watch, v->work, &done);
    viewshed_destroy(shed);
    return status == CW_OK && !done ? CW_ERROR_CANCELLED : status;
}

static cw_status view(const viewing *v) {
    sight_bounds *bounds;
    cw_status status = sight_bounds_create(&v->field->terrain, &bounds);
    for (size_t k = 0; k < v->count && status == CW_OK; k++) status = view_from(v, k, bounds);
    sight_bounds_destroy(bounds);
    return status;
}

/* False, with an exception, if no line of sight can leave from the place. */
static bool check_place(const py_field *f, const double place[3], bool absolute) {
    double at[3];
    char text[200];
    const finding found = find_place(f, place, absolute, at);
    if (found == FOUND) return true;
    if (found == UNDER_GROUND)
        snprintf(text, sizeof text, "%s: %.10g at (%.10g, %.10g) is under the ground",
                 absolute ? "observer_elevation" : "observer_height", place[2], place[0], place[1]);
    else
        snprintf(text, sizeof text, "x, y: (%.10g, %.10g) %s", place[0], place[1],
                 found == NO_GROUND ? "has no ground to stand on; give observer_elevation"
                                    : "is too far away from the terrain");
    PyErr_SetString(PyExc_ValueError, text);
    return false;
}

/* viewshed(places, absolute, target_height, max_distance, curvature, heights, out, threads, progress): out holds
 * floats if heights is true, else uint16, all zero. */
PyObject *field_viewshed(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer places = {0}, out = {0};
    int absolute, heights;
    viewshed_desc d = {0};
    unsigned threads;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "y*pdddpw*IO:viewshed", &places, &absolute, &d.target_height, &d.limits.farthest,
                          &d.curvature, &heights, &out, &threads, &progress))
        return NULL;
    d.absolute = absolute != 0;
    viewing v = {.field = f, .places = places.buf, .count = (size_t)places.len / sizeof *v.places, .desc = d};
    if (heights)
        v.heights = out.buf;
    else
        v.seen = out.buf;
    bool good = buffer_holds(&out, f->nx * f->ny * (heights ? sizeof(float) : sizeof(uint16_t)), "out") &&
                field_enter_ground(f);
    if (good) {
        for (size_t k = 0; k < v.count && good; k++) good = check_place(f, v.places[k], d.absolute);
        work w;
        if (good && (good = work_begin(&w, threads, NULL, progress))) {
            w.run.watch = work_look;
            v.work = &w;
            good = work_end(&w, view(&v), "viewshed");
        }
        field_leave(f);
    }
    PyBuffer_Release(&places);
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}

typedef struct lines_of_sight {
    const py_field *field;
    const double (*ends)[2][3]; /* x, y, height */
    double (*answers)[6]; /* 1 if visible, distance, x, y, z of the block, its distance; or NaN and 2 findings + end */
    double curvature;
    bool absolute[2];
    work *work;
    size_t n;
    atomic_size_t done;
} lines_of_sight;

/* As `cellwalk los` has it. */
static void look_along(const lines_of_sight *l, const double ends[2][3], double answer[6]) {
    const terrain *t = &l->field->terrain;
    double at[2][3], metres[2], xy[2][2];
    for (int k = 0; k < 2; k++) {
        const finding found = find_place(l->field, ends[k], l->absolute[k], at[k]);
        if (found == FOUND) continue;
        answer[0] = NAN;
        answer[1] = 2 * (int)found + k;
        return;
    }
    const double *eye = at[0], *target = at[1];
    sight s;
    sight_init(&s, t, NULL, eye, l->curvature);
    const double height = target[2] - s.eye[2] - sight_fall(&s, target[0], target[1]);
    const double block = sight_first_block(&s, target[0], target[1], target[2]);
    terrain_metres(t, eye[0], eye[1], metres);
    for (int k = 0; k < 2; k++) terrain_to_map(t, at[k][0], at[k][1], xy[k]);
    answer[0] = block < INFINITY ? 0 : 1;
    answer[1] = hypot((xy[1][0] - xy[0][0]) * metres[0], (xy[1][1] - xy[0][1]) * metres[1]);
    for (int c = 2; c < 6; c++) answer[c] = NAN;
    if (!(block < INFINITY)) return;
    for (int c = 0; c < 2; c++) answer[2 + c] = xy[0][c] + block * (xy[1][c] - xy[0][c]);
    answer[3] = northward(l->field, answer[3]);
    const double bend = sight_fall(&s, eye[0] + block * (target[0] - eye[0]), eye[1] + block * (target[1] - eye[1]));
    answer[4] = (eye[2] + block * height + bend) * terrain_metres_of_height(t);
    answer[5] = block * answer[1];
}

static void look_along_all(void *context, size_t begin, size_t end) {
    lines_of_sight *l = context;
    for (; begin < end; begin++) {
        look_along(l, l->ends[begin], l->answers[begin]);
        if (!work_watch(l->work, (double)(atomic_fetch_add(&l->done, 1) + 1) / (double)l->n)) return;
    }
}

/* line_of_sight(ends, absolute, absolute, curvature, out, threads, progress): six doubles a line, six an answer */
PyObject *field_line_of_sight(PyObject *self, PyObject *arguments) {
    py_field *f = (py_field *)self;
    Py_buffer ends = {0}, out = {0};
    int absolute[2];
    unsigned threads;
    double curvature;
    PyObject *progress;
    if (!PyArg_ParseTuple(arguments, "y*ppdw*IO:line_of_sight", &ends, &absolute[0], &absolute[1], &curvature, &out,
                          &threads, &progress))
        return NULL;
    lines_of_sight l = {.field = f,
                        .ends = ends.buf,
                        .answers = out.buf,
                        .curvature = curvature,
                        .absolute = {absolute[0] != 0, absolute[1] != 0},
                        .n = (size_t)ends.len / sizeof *l.ends};
    bool good = buffer_holds(&out, l.n * sizeof *l.answers, "out") && field_enter_ground(f);
    if (good) {
        work w;
        if ((good = work_begin(&w, threads, NULL, progress))) {
            w.run.watch = work_look;
            l.work = &w;
            cw_pool_run(w.run.pool, l.n, 64, look_along_all, &l);
            good = work_end(&w, CW_OK, "line_of_sight");
        }
        field_leave(f);
    }
    PyBuffer_Release(&ends);
    PyBuffer_Release(&out);
    if (!good) return NULL;
    Py_RETURN_NONE;
}
