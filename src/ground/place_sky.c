/* SPDX-License-Identifier: Apache-2.0 */
#include "place_sky.h"

#include "gdal/module.h"
#include "inputs.h"
#include "normal.h"
#include "table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degrees = 180 / 3.141592653589793, degree = 0.017453292519943295, day = 86400;

bool sun_place_of(const terrain *t, const io_georef *georef, const double at[2], const char *path, const char *instead,
                  sun_place *place, io_error *error) {
    const terrain *whole = terrain_whole(t);
    double xy[2];
    *place = (sun_place){0, 0, 0};
    if (at)
        memcpy(xy, at, sizeof xy);
    else
        terrain_to_map(whole, 0.5 * (double)(whole->nx - 1), 0.5 * (double)(whole->ny - 1), xy);
    if (t->geographic) {
        place->longitude = xy[0] * t->unit * degrees;
        place->latitude = xy[1] * t->unit * degrees;
        return true;
    }
    if (georef->crs == NULL)
        return io_fail(error, "%s: names no coordinate system, so the sun's place at a time is not known%s%s", path,
                       instead ? "; " : "", instead ? instead : "");
    const io_gdal *gdal = io_gdal_load(error);
    double x[2] = {xy[0]}, y[2] = {xy[1]};
    if (gdal == NULL || !gdal->lon_lat(georef->crs, false, 1, x, y, error)) return false;
    place->longitude = x[0];
    place->latitude = y[0];
    /* Two places, one 20 m north of the other. */
    x[1] = x[0];
    y[0] -= 1e-4;
    y[1] = y[0] + 2e-4;
    if (!gdal->lon_lat(georef->crs, true, 2, x, y, error)) return false;
    place->turned = atan2(x[1] - x[0], y[1] - y[0]) * degrees;
    return true;
}

sun_position sun_place_at(const sun_place *place, double seconds) {
    sun_position p = cw_sun_at(seconds, place->longitude, place->latitude);
    p.azimuth = fmod(p.azimuth + place->turned + 360, 360);
    return p;
}

enum { AZIMUTH, ALTITUDE, WEIGHT, NAMES };

static bool take_sun(const io_table *t, size_t row, const size_t columns[NAMES], sun_list *list, io_error *error) {
    sun_position *p = &list->suns[row];
    double *weight = &list->weights[row];
    *p = (sun_position){.distance = 1};
    *weight = 1;
    if (!io_table_number(t, row, columns[AZIMUTH], &p->azimuth, error) ||
        !io_table_number(t, row, columns[ALTITUDE], &p->altitude, error) ||
        (columns[WEIGHT] < t->columns && !io_table_number(t, row, columns[WEIGHT], weight, error)))
        return false;
    return fabs(p->altitude) <= 90 ||
           io_table_fail(t, row, columns[ALTITUDE], "an angle from -90 to 90 degrees", error);
}

bool sun_list_read(const char *path, const ground_watch *w, sun_list *list, io_error *error) {
    static const char *const names[NAMES] = {"azimuth", "altitude", "weight"};
    size_t columns[NAMES];
    io_table t;
    *list = (sun_list){0};
    if (!io_inputs_note_path(path)) return io_fail(error, "out of memory");
    if (!io_table_read(path, &t, error)) return false;
    bool good = io_table_columns(&t, names, NAMES, WEIGHT, columns, w->warn, w->context, error);
    if (good && t.rows == 0) good = io_fail(error, "%s: holds no places of the sun", path);
    list->suns = calloc(t.rows + 1, sizeof *list->suns);
    list->weights = calloc(t.rows + 1, sizeof *list->weights);
    if (good && !(list->suns && list->weights)) good = io_fail(error, "out of memory");
    for (size_t row = 0; good && row < t.rows; row++) good = take_sun(&t, row, columns, list, error);
    list->count = t.rows;
    io_table_free(&t);
    return good;
}

void sun_list_free(sun_list *list) {
    free(list->suns);
    free(list->weights);
    *list = (sun_list){0};
}

/* A way from the eye, out of the terrain or so far. */
typedef struct way_out {
    double dir[2], to[2], steps, metres; /* metres: of a step */
} way_out;

static way_out look_toward(const sight *s, double azimuth, double max_distance) {
    const terrain *t = s->terrain;
    way_out w;
    w.metres = cw_terrain_direction(t, s->eye[0], s->eye[1], azimuth, w.dir);
    w.steps = cw_terrain_steps_out(t, s->eye, w.dir);
    if (max_distance > 0) w.steps = fmin(w.steps, max_distance / w.metres);
    for (int a = 0; a < 2; a++) w.to[a] = s->eye[a] + w.steps * w.dir[a];
    return w;
}

place_horizon place_horizon_toward(sight *s, double azimuth, double max_distance) {
    const terrain *t = s->terrain;
    place_horizon h = {azimuth, NAN, NAN, {NAN, NAN}};
    s->at_crossings = true;
    const way_out w = look_toward(s, azimuth, max_distance);
    const sight_rise r = cw_sight_steepest(s, w.to[0], w.to[1], -INFINITY);
    if (r.steepest == -INFINITY) return h;
    const double cells = cw_sight_nearest(s, w.to[0], w.to[1], r) * w.steps;
    h.angle = atan(r.steepest * terrain_metres_of_height(t) / (w.steps * w.metres)) / (3.141592653589793 / 180);
    h.distance = cells * w.metres;
    terrain_to_map(t, s->eye[0] + cells * w.dir[0], s->eye[1] + cells * w.dir[1], h.at);
    return h;
}

/* ---- the sun ---------------------------------------------------------------------------------------------------------- */

/* The light of the sky above a tangent of height, of a surface that rises by lean / up in that direction: horizon.c has the formula. */
static double light_above(double tangent, double up, double lean) {
    const double square = 1 / (1 + tangent * tangent);
    return up * square - lean * (atan(1 / tangent) - tangent * square);
}

double sun_sky_share(sight *s, const sun_day_desc *d) {
    const double up = cos(d->tilt * degree), level = sin(d->tilt * degree);
    double sum = 0;
    for (unsigned k = 0; k < d->sky; k++) {
        const double azimuth = fmod(360.0 * k / d->sky, 360);
        const place_horizon h = place_horizon_toward(s, azimuth, d->max_distance);
        const double lean = -level * cos((azimuth - d->facing) * degree);
        const double hidden = h.angle > 0 ? tan(h.angle * degree) : 0, edge = lean / up;
        if (up > 0)
            sum += light_above(fmax(hidden, edge), up, lean);
        else if (edge > hidden) /* an overhang, which sees the sky up to its own edge */
            sum += light_above(hidden, up, lean) - light_above(edge, up, lean);
    }
    return sum / d->sky;
}

bool sun_ground_lean(const terrain *t, const double at[2], double *tilt, double *facing) {
    const size_t i = (size_t)fmin(fmax(nearbyint(at[0]), 0), (double)(t->nx - 1)),
                 j = (size_t)fmin(fmax(nearbyint(at[1]), 0), (double)(t->ny - 1));
    float *east = malloc(2 * t->nx * sizeof *east);
    if (east == NULL) return false;
    cw_terrain_slope_row(t, j, 0, t->nx, east, east + t->nx);
    const double slope[2] = {(double)east[i], (double)east[t->nx + i]};
    free(east);
    const bool known = isfinite(slope[0]) && isfinite(slope[1]);
    *tilt = known ? atan(hypot(slope[0], slope[1])) / degree : 0;
    *facing = known ? atan2(-slope[0], -slope[1]) / degree : 0;
    return true;
}

/* Nothing on the way to the terrain's end, or so far away, rises as steeply as the sun stands. */
static bool is_free(const sight *s, const sun_day_desc *d, const sun_position *p) {
    const way_out w = look_toward(s, p->azimuth, d->max_distance);
    const double rise = tan(p->altitude * degree) * w.steps * w.metres / terrain_metres_of_height(s->terrain);
    return cw_sight_steepest(s, w.to[0], w.to[1], rise).share == 0;
}

/* Adds a sun above the level that shines for so long, with so much light on a surface that faces it. Whether it is seen. */
static bool add_sun(sun_day *out, const sight *s, const sun_day_desc *d, const sun_position *p, double hours,
                    double light) {
    const double up = cos(d->tilt * degree), level = sin(d->tilt * degree), altitude = p->altitude * degree;
    const double facing = up * sin(altitude) + level * cos(altitude) * cos((p->azimuth - d->facing) * degree);
    const double direct = fmax(facing, 0) * light;
    out->free_hours += hours;
    out->free_direct += direct;
    if (!is_free(s, d, p)) return false;
    out->hours += hours;
    out->direct += direct;
    return true;
}

sun_day sun_day_of_list(const sight *s, const sun_day_desc *d, const sun_position *suns, const double *weights,
                        size_t count) {
    sun_day out = {.rise = NAN, .set = NAN, .diffuse = NAN, .free_diffuse = NAN};
    for (size_t k = 0; k < count; k++)
        if (suns[k].altitude > 0) add_sun(&out, s, d, &suns[k], weights[k], weights[k]);
    return out;
}

sun_day sun_day_find(const sight *s, const sun_day_desc *d, double share, double midnight) {
    const double begin = midnight - d->place.longitude / 360 * day, hours = d->step / 3600;
    const double height = s->eye[2] * terrain_metres_of_height(s->terrain);
    sun_day out = {.rise = NAN, .set = NAN};
    const size_t steps = (size_t)nearbyint(day / d->step);
    double diffuse = 0;
    for (size_t k = 0; k < steps; k++) {
        const double time = begin + ((double)k + 0.5) * d->step;
        const sun_position p = sun_place_at(&d->place, time);
        if (!(p.altitude > 0)) continue;
        diffuse += cw_clear_sky_diffuse(d->linke, p.distance, p.altitude - p.refraction) * hours;
        if (!add_sun(&out, s, d, &p, hours, cw_clear_sky_direct(d->linke, p.distance, p.altitude, height) * hours))
            continue;
        if (isnan(out.rise)) out.rise = begin + (double)k * d->step;
        out.set = begin + (double)(k + 1) * d->step;
    }
    out.diffuse = share * diffuse;
    out.free_diffuse = 0.5 * (1 + cos(d->tilt * degree)) * diffuse;
    return out;
}
