/* SPDX-License-Identifier: Apache-2.0 */
#include "sun_day.h"

#include "fpenv.h"

#include <math.h>

static const double degree = 0.017453292519943295, day = 86400;

/* A way from the eye, out of the terrain or so far. */
typedef struct way_out {
    double dir[2], to[2], steps, metres; /* metres: of a step */
} way_out;

static way_out look_toward(const sight *s, double azimuth, double max_distance) {
    const terrain *t = s->terrain;
    way_out w;
    w.metres = cw_terrain_direction(t, s->eye[0], s->eye[1], azimuth, w.dir);
    w.steps = cw_terrain_steps_out(t, s->eye, w.dir);
    if (max_distance > 0) w.steps = fmin(w.steps, max_distance / w.metres + SIGHT_END);
    for (int a = 0; a < 2; a++) w.to[a] = s->eye[a] + w.steps * w.dir[a];
    return w;
}

/* Degrees of the steepest rise on the way; NaN if there is no terrain. */
static double angle_along(sight *s, const way_out *w, sight_rise *r) {
    s->at_crossings = true;
    *r = cw_sight_steepest(s, w->to[0], w->to[1], -INFINITY);
    const double rise = r->steepest * terrain_metres_of_height(s->terrain) / (w->steps * w->metres);
    return r->steepest == -INFINITY ? NAN : atan(rise) / degree;
}

place_horizon cw_place_horizon(sight *s, double azimuth, double max_distance) {
    FPENV_HERE;
    const terrain *t = s->terrain;
    const way_out w = look_toward(s, azimuth, max_distance);
    sight_rise r;
    place_horizon h = {azimuth, angle_along(s, &w, &r), NAN, {NAN, NAN}};
    if (isnan(h.angle)) return h;
    const double cells = cw_sight_nearest(s, w.to[0], w.to[1], r) * w.steps;
    h.distance = cells * w.metres;
    terrain_to_map(t, s->eye[0] + cells * w.dir[0], s->eye[1] + cells * w.dir[1], h.at);
    return h;
}

/* The sky's light above a tangent of height, of a surface that rises by lean / up in that direction: see horizon.c. */
static double light_above(double tangent, double up, double lean) {
    const double square = 1 / (1 + tangent * tangent);
    return up * square - lean * (atan(1 / tangent) - tangent * square);
}

double cw_sun_day_sky(sight *s, const sun_day_desc *d) {
    FPENV_HERE;
    const double up = cos(d->tilt * degree), level = sin(d->tilt * degree);
    double sum = 0;
    for (unsigned k = 0; k < d->sky; k++) {
        const double azimuth = fmod(360.0 * k / d->sky, 360);
        const way_out w = look_toward(s, azimuth, d->max_distance);
        sight_rise r;
        const double angle = angle_along(s, &w, &r);
        const double lean = -level * cos((azimuth - d->facing) * degree);
        const double hidden = angle > 0 ? tan(angle * degree) : 0, edge = lean / up;
        if (up > 0)
            sum += light_above(fmax(hidden, edge), up, lean);
        else if (edge > hidden) /* an overhang, which sees the sky up to its own edge */
            sum += light_above(hidden, up, lean) - light_above(edge, up, lean);
    }
    return sum / d->sky;
}

void cw_sun_day_lean(const terrain *t, const double at[2], sun_day_desc *d) {
    FPENV_HERE;
    const size_t i = (size_t)fmin(fmax(nearbyint(at[0]), 0), (double)(t->nx - 1)),
                 j = (size_t)fmin(fmax(nearbyint(at[1]), 0), (double)(t->ny - 1));
    float slope[2];
    cw_terrain_slopes(t, NULL, NAN, (cw_rectangle){i, j, 1, 1}, &slope[0], &slope[1]);
    const double east = (double)slope[0], north = (double)slope[1];
    const bool known = isfinite(east) && isfinite(north);
    d->tilt = known ? atan(hypot(east, north)) / degree : 0;
    d->facing = known ? atan2(-east, -north) / degree : 0;
}

/* Nothing on the way to the terrain's end, or so far away, rises as steeply as the sun stands. */
static bool is_free(const sight *s, const sun_day_desc *d, const sun_position *p) {
    const way_out w = look_toward(s, p->azimuth, d->max_distance);
    const double rise = tan(p->altitude * degree) * w.steps * w.metres / terrain_metres_of_height(s->terrain);
    return cw_sight_steepest(s, w.to[0], w.to[1], rise).share == 0;
}

sun_day cw_sun_day(const sight *s, const sun_day_desc *d, double share, double midnight, const sun_position *suns,
                   const double *weights, size_t count) {
    FPENV_HERE;
    const double begin = midnight - d->place.longitude / 360 * day, up = cos(d->tilt * degree),
                 level = sin(d->tilt * degree), height = s->eye[2] * terrain_metres_of_height(s->terrain);
    const size_t steps = suns ? count : (size_t)nearbyint(day / d->step);
    double diffuse = 0;
    sun_day out = {.rise = NAN, .set = NAN};
    for (size_t k = 0; k < steps; k++) {
        const sun_position p = suns ? suns[k] : cw_sun_at_place(begin + ((double)k + 0.5) * d->step, &d->place);
        if (!(p.altitude > 0)) continue;
        const double hours = suns ? weights[k] : d->step / 3600, altitude = p.altitude * degree;
        const double light = suns ? 1 : cw_clear_sky_direct(d->linke, p.distance, p.altitude, height);
        const double facing = up * sin(altitude) + level * cos(altitude) * cos((p.azimuth - d->facing) * degree);
        const double direct = fmax(facing, 0) * (light * hours);
        if (!suns) diffuse += cw_clear_sky_diffuse(d->linke, p.distance, p.altitude - p.refraction) * hours;
        out.free_hours += hours;
        out.free_direct += direct;
        if (!is_free(s, d, &p)) continue;
        out.hours += hours;
        out.direct += direct;
        if (suns) continue;
        if (isnan(out.rise)) out.rise = begin + (double)k * d->step;
        out.set = begin + (double)(k + 1) * d->step;
    }
    out.diffuse = suns ? NAN : share * diffuse;
    out.free_diffuse = suns ? NAN : 0.5 * (1 + up) * diffuse;
    return out;
}
