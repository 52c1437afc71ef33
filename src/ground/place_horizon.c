/* SPDX-License-Identifier: Apache-2.0 */
#include "place_horizon.h"

#include <math.h>

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
