/* SPDX-License-Identifier: Apache-2.0 */
#include "place_sky.h"

#include "normal.h"
#include "sun.h"

#include <math.h>
#include <stdlib.h>

static const double degree = 0.017453292519943295, day = 86400;

place_horizon place_horizon_toward(sight *s, double azimuth, double max_distance) {
    const terrain *t = s->terrain;
    place_horizon h = {azimuth, NAN, NAN, {NAN, NAN}};
    double dir[2];
    s->at_crossings = true;
    const double length = cw_terrain_direction(t, s->eye[0], s->eye[1], azimuth, dir);
    double far = cw_terrain_steps_out(t, s->eye, dir);
    if (max_distance > 0) far = fmin(far, max_distance / length);
    const double to[2] = {s->eye[0] + far * dir[0], s->eye[1] + far * dir[1]};
    const sight_rise r = cw_sight_steepest(s, to[0], to[1], -INFINITY);
    if (r.steepest == -INFINITY) return h;
    const double cells = cw_sight_nearest(s, to[0], to[1], r) * far;
    h.angle = atan(r.steepest * terrain_metres_of_height(t) / (far * length)) / (3.141592653589793 / 180);
    h.distance = cells * length;
    terrain_to_map(t, s->eye[0] + cells * dir[0], s->eye[1] + cells * dir[1], h.at);
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
    const terrain *t = s->terrain;
    double dir[2];
    const double length = cw_terrain_direction(t, s->eye[0], s->eye[1], p->azimuth, dir);
    double far = cw_terrain_steps_out(t, s->eye, dir);
    if (d->max_distance > 0) far = fmin(far, d->max_distance / length);
    const double rise = tan(p->altitude * degree) * far * length / terrain_metres_of_height(t);
    return cw_sight_steepest(s, s->eye[0] + far * dir[0], s->eye[1] + far * dir[1], rise).share == 0;
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
