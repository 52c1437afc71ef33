/* SPDX-License-Identifier: Apache-2.0 */
/* Products of places of the map: viewsheds, lines of sight, horizons. */
#include "extension.h"
#include "line.h"
#include "place.h"
#include "place_sky.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A place as Python hands it in. z is above the ground, or absolute if that is not 0. */
typedef struct spot {
    double x, y, z, absolute, weight;
} spot;

static ground_place place_of(const call *c, const spot *s) {
    return (ground_place){"", s->x, northward(c->field, s->y), s->z, s->absolute != 0, s->weight};
}

/* Field coordinates of a spot that one can look from; else false with an error. name: the argument's. */
static bool find_spot(call *c, const char *name, const spot *s, double at[3]) {
    const terrain *t = &c->field->terrain;
    const ground_place p = place_of(c, s);
    double level;
    io_error unused;
    if (ground_find_place(t, &p, at, &level, &unused)) return true;
    const char *why = !cw_terrain_find_place(t, p.x, p.y, at) ? "is too far away from the terrain"
                      : isnan(level) ? "has no ground under it; give the height itself, absolute"
                      : p.z < level  ? "is under the ground"
                                     : "is too high";
    call_fail(c, "%s: (%.10g, %.10g, %.10g) %s", name, s->x, s->y, s->z, why);
    return false;
}

/* Inputs: spots. Output: a byte for each, 1 where one can look from it. */
cw_status make_found(call *c) {
    size_t n;
    const spot *spots = call_input(c, 0, sizeof *spots, &n);
    uint8_t *out = call_output(c, 0, n);
    double at[3];
    if (out == NULL) return CW_ERROR_ARGUMENT;
    for (size_t k = 0; k < n; k++) out[k] = find_spot(c, "", &spots[k], at);
    c->error[0] = '\0';
    return CW_OK;
}

/* Inputs: corners of a line. Outputs: spots along it, as many as there is room for, and how many there are. */
cw_status make_along(call *c) {
    size_t n;
    const spot *corners = call_input(c, 0, sizeof *corners, &n);
    spot *out = call_output(c, 0, 0);
    double *count = call_output(c, 1, sizeof *count);
    if (out == NULL || count == NULL) return CW_ERROR_ARGUMENT;
    ground_place *places = malloc((n + 1) * sizeof *places);
    if (places == NULL) return CW_ERROR_MEMORY;
    for (size_t k = 0; k < n; k++) places[k] = place_of(c, &corners[k]);
    const observers_from from = {.places = places, .place_count = n, .every = c->n.every};
    const size_t room = (size_t)c->out[0].len / sizeof *out;
    const ground g = {.whole = c->field->terrain};
    observers all;
    io_error error;
    if (observers_find(&all, &from, &g, &error)) {
        for (size_t k = 0; k < all.count && k < room; k++) {
            const observer *o = &all.list[k];
            out[k] = (spot){o->x, northward(c->field, o->y), o->z, o->absolute, o->weight};
        }
        *count = (double)all.count;
        observers_free(&all);
    } else {
        call_fail(c, "every: %s", error.text);
    }
    free(places);
    return CW_OK;
}

/* ---- viewsheds ----------------------------------------------------------------------------------------------------------- */

enum { SEEN, WEIGHT, ANGLE, NEEDED };

static cw_status look(call *c, const terrain *t, const spot *at, const double eye[3], int kind, void *to) {
    const call_numbers *n = &c->n;
    const cw_observer from = {.x = at->x,
                              .y = northward(c->field, at->y),
                              .height = eye[2] * terrain_metres_of_height(t),
                              .absolute = 1,
                              .target = n->target_height,
                              .curvature = n->curvature,
                              .nearest = n->min_distance,
                              .farthest = n->max_distance,
                              .azimuths = {n->azimuth, n->azimuth_until},
                              .verticals = {n->lowest, n->highest},
                              .limits = (n->has_azimuths != 0 ? 1u * CW_OBSERVER_AZIMUTHS : 0) +
                                        (n->has_verticals != 0 ? 1u * CW_OBSERVER_VERTICALS : 0)};
    const cw_view view = {.seen = kind == SEEN ? to : NULL,
                          .sum = kind == WEIGHT && at->weight != 0 ? to : NULL, /* a weight of 0 adds nothing */
                          .weight = at->weight,
                          .angle = kind == ANGLE ? to : NULL,
                          .needed = kind == NEEDED ? to : NULL};
    return cw_viewshed(t, &c->work.run, &from, (cw_area){0}, &view);
}

/* Inputs: observers, and a byte for each sample that counts in the table, or none. Outputs: of each sample a uint16 that grows by 1 for
 * each observer that sees it, a double that grows by the observer's weight, or a float; with bands a plane of them for each observer. If
 * there is a second output, a view_sum of each observer, and the first one is that of the last. */
cw_status make_viewshed(call *c) {
    static const size_t sizes[] = {sizeof(uint16_t), sizeof(double), sizeof(float), sizeof(float)};
    terrain t = c->field->terrain; /* with bounds for all observers */
    const int kind = c->n.kind < NEEDED ? (int)c->n.kind : NEEDED;
    const size_t plane = t.nx * t.ny * sizes[kind];
    size_t count, bytes;
    const spot *spots = call_input(c, 0, sizeof *spots, &count);
    const uint8_t *within = call_input(c, 1, 1, &bytes);
    view_sum *table = c->out_count > 1 ? call_output(c, 1, count * sizeof *table) : NULL;
    char *to = call_output(c, 0, c->n.bands != 0 ? count * plane : plane);
    if (to == NULL || (c->out_count > 1 && table == NULL) || (within && bytes < t.nx * t.ny)) return CW_ERROR_ARGUMENT;
    cw_status status = field_bounds(c->field, &t.bounds);
    for (size_t k = 0; k < count && status == CW_OK; k++) {
        double eye[3];
        if (!find_spot(c, "x, y", &spots[k], eye)) return CW_ERROR_ARGUMENT;
        if (!work_part(&c->work, (double)k / (double)count, 1 / (double)count)) return CW_ERROR_CANCELLED;
        if (table) memset(to, 0, plane);
        status = look(c, &t, &spots[k], eye, kind, to);
        if (c->n.bands != 0) to += plane;
        if (table == NULL || status != CW_OK) continue;
        table[k] = view_sum_of(&t, c->at, (const uint16_t *)(void *)to, within, eye);
        table[k].farthest_at[1] = northward(c->field, table[k].farthest_at[1]);
    }
    return status;
}

/* ---- lines of sight ------------------------------------------------------------------------------------------------------ */

typedef struct answer {
    double visible, distance, block[3], block_distance;
    clearance clearance; /* with a frequency */
} answer;

typedef struct lines {
    call *call;
    const spot (*ends)[2];
    answer *answers;
    size_t n;
    atomic_size_t done;
    atomic_bool failed;
} lines;

static bool find_line(const call *c, line *l, const spot ends[2]) {
    const ground_place places[2] = {place_of(c, &ends[0]), place_of(c, &ends[1])};
    io_error unused;
    return line_find(l, &c->field->terrain, places, c->n.curvature, &unused);
}

static bool look_along(const lines *all, size_t k, profile *p) {
    const call *c = all->call;
    answer *a = &all->answers[k];
    line l;
    io_error unused;
    if (!find_line(c, &l, all->ends[k])) return false;
    *a = (answer){!l.blocked, l.length, {NAN, NAN, NAN}, NAN, {NAN, NAN, NAN}};
    if (l.blocked) {
        a->block[0] = l.block[0];
        a->block[1] = northward(c->field, l.block[1]);
        a->block[2] = l.block_height;
        a->block_distance = l.block_distance;
    }
    if (!(c->n.frequency > 0)) return true;
    if (!line_profile(&l, p, &unused)) return false;
    line_clearance(&l, c->n.frequency, p, &a->clearance);
    return true;
}

static void look_along_some(void *context, size_t begin, size_t end) {
    lines *l = context;
    profile p = {0};
    for (; begin < end; begin++) {
        if (!look_along(l, begin, &p)) atomic_store(&l->failed, true);
        if (!work_watch(&l->call->work, (double)(atomic_fetch_add(&l->done, 1) + 1) / (double)l->n)) break;
    }
    cw_profile_free(&p);
}

static bool check_ends(call *c, const spot (*ends)[2], size_t n) {
    double at[3];
    for (size_t k = 0; k < 2 * n; k++)
        if (!find_spot(c, k % 2 ? "b" : "a", &ends[k / 2][k % 2], at)) return false;
    return true;
}

cw_status make_lines(call *c) {
    lines l = {.call = c};
    l.ends = call_input(c, 0, sizeof *l.ends, &l.n);
    l.answers = call_output(c, 0, l.n * sizeof *l.answers);
    if (l.answers == NULL || !check_ends(c, l.ends, l.n)) return CW_ERROR_ARGUMENT;
    cw_pool_run(c->work.run.pool, l.n, 64, look_along_some, &l);
    return atomic_load(&l.failed) ? CW_ERROR_MEMORY : CW_OK;
}

/* Along one line: rows of numbers as far as the first output has room, and how many there are in the second. */
cw_status make_profile(call *c) {
    size_t n;
    const spot(*ends)[2] = call_input(c, 0, sizeof *ends, &n);
    line_row *rows = call_output(c, 0, 0);
    double *count = call_output(c, 1, sizeof *count);
    line l;
    profile p = {0};
    if (rows == NULL || count == NULL || !check_ends(c, ends, n) || !find_line(c, &l, *ends)) return CW_ERROR_ARGUMENT;
    const cw_status status = cw_profile_make(&p, &l.sight, l.target[0], l.target[1], l.target[2]);
    const size_t room = (size_t)c->out[0].len / sizeof *rows;
    for (size_t k = 0; k < p.count && k < room && status == CW_OK; k++) {
        rows[k] = line_row_of(&l, c->n.frequency, &p.points[k]);
        rows[k].y = northward(c->field, rows[k].y);
    }
    *count = (double)p.count;
    cw_profile_free(&p);
    return status;
}

/* ---- horizons of places -------------------------------------------------------------------------------------------------- */

/* Input: places. Output: a place_horizon for each of the directions from each of them. */
cw_status make_place_horizons(call *c) {
    const terrain *t = &c->field->terrain;
    const size_t directions = (size_t)c->n.directions;
    size_t count;
    const spot *spots = call_input(c, 0, sizeof *spots, &count);
    place_horizon *out = call_output(c, 0, count * directions * sizeof *out);
    const sight_bounds *bounds;
    if (out == NULL) return CW_ERROR_ARGUMENT;
    const cw_status status = field_bounds(c->field, &bounds);
    for (size_t k = 0; k < count && status == CW_OK && work_watch(&c->work, (double)k / (double)count); k++) {
        double eye[3];
        sight s;
        if (!find_spot(c, "x, y", &spots[k], eye)) break;
        if (isnan(cw_terrain_height(t, eye[0], eye[1]))) {
            call_fail(c, "x, y: (%.10g, %.10g) is not on the terrain, where the horizon is found", spots[k].x,
                      spots[k].y);
            break;
        }
        cw_sight_init(&s, t, bounds, eye, c->n.curvature);
        for (size_t d = 0; d < directions; d++, out++) {
            *out = place_horizon_toward(&s, fmod(c->n.start + 360.0 * (double)d / (double)directions, 360),
                                        c->n.max_distance);
            out->at[1] = northward(c->field, out->at[1]);
        }
    }
    return status;
}

/* Inputs: one place; places of the sun and their weights, or none. Output: a sun_day for each day, or one. lean: the surface is the
 * ground's. */
cw_status make_sun_days(call *c) {
    const terrain *t = &c->field->terrain;
    const call_numbers *n = &c->n;
    const size_t days = (size_t)n->days;
    size_t count, suns, weights;
    const spot *at = call_input(c, 0, sizeof *at, &count);
    const sun_position *list = call_input(c, 1, sizeof *list, &suns);
    const double *weight = call_input(c, 2, sizeof *weight, &weights);
    sun_day *out = call_output(c, 0, days * sizeof *out);
    sun_day_desc d = {.place = {n->longitude, n->latitude, n->turned},
                      .step = n->step,
                      .linke = n->linke,
                      .sky = (unsigned)n->sky,
                      .tilt = n->tilt,
                      .facing = n->facing,
                      .max_distance = n->max_distance};
    double eye[3];
    sight s;
    const sight_bounds *bounds;
    if (out == NULL || at == NULL || !find_spot(c, "x, y", at, eye)) return CW_ERROR_ARGUMENT;
    if (n->lean != 0 && !sun_ground_lean(t, eye, &d.tilt, &d.facing)) return CW_ERROR_MEMORY;
    const cw_status status = field_bounds(c->field, &bounds);
    if (status != CW_OK) return status;
    cw_sight_init(&s, t, bounds, eye, n->curvature);
    const double share = weight ? 0 : sun_sky_share(&s, &d);
    if (weight) *out = sun_day_of_list(&s, &d, list, weight, suns < weights ? suns : weights);
    for (size_t k = 0; k < days && !weight && work_watch(&c->work, (double)k / (double)days); k++)
        out[k] = sun_day_find(&s, &d, share, n->first + 86400 * (double)k);
    return CW_OK;
}
