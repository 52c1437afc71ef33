/* SPDX-License-Identifier: Apache-2.0 */
#include "view_limits.h"

#include <math.h>

static const double degree = 3.141592653589793 / 180;

/* What is clockwise of one direction by less than half of the round, seen from above, is to the right of it. */
static double to_the_right(const double from[2], const double to[2]) { return from[1] * to[0] - from[0] * to[1]; }

static bool init_sector(view_limits *l) {
    const double *a = l->given.azimuths;
    if (!(isfinite(a[0]) && isfinite(a[1]))) return false;
    double width = a[1] - a[0];
    if (width < 0) width = fmod(width, 360) + 360;
    if (width >= 360) l->has_sector = a[1] < a[0]; /* a whole number of rounds back is no width */
    l->narrow = width < 180 || width >= 360;
    for (int k = 0; k < 2; k++) cw_terrain_sine_cosine(a[k], &l->sector[k][0], &l->sector[k][1]);
    return true;
}

static bool init_verticals(view_limits *l) {
    const double *v = l->given.verticals;
    if (!(v[0] >= -90 && v[0] <= v[1] && v[1] <= 90)) return false;
    for (int k = 0; k < 2; k++) {
        double sine, cosine;
        cw_terrain_sine_cosine(v[k], &sine, &cosine);
        l->tangents[k] = v[k] == -90 ? -INFINITY : v[k] == 90 ? INFINITY : sine / cosine;
    }
    return true;
}

bool cw_view_limits_init(view_limits *l, const sight *s, const cw_observer *given) {
    *l = (view_limits){.sight = s,
                       .given = *given,
                       .has_sector = (given->limits & CW_OBSERVER_AZIMUTHS) != 0,
                       .has_verticals = (given->limits & CW_OBSERVER_VERTICALS) != 0};
    cw_terrain_metres(s->terrain, s->eye[0], s->eye[1], l->metres);
    if (l->has_sector && !init_sector(l)) return false;
    if (l->has_verticals && !init_verticals(l)) return false;
    l->any = given->nearest > 0 || given->farthest > 0 || l->has_sector || l->has_verticals;
    return true;
}

static void turn_to_metres(const view_limits *l, double x, double y, double step[2]) {
    const double(*m)[4] = (const double(*)[4])l->sight->terrain->map;
    for (int k = 0; k < 2; k++) step[k] = (m[k][0] * x + m[k][1] * y) * l->metres[k];
}

/* slack: the sector and what is beside it by less than that share of the step. */
static bool is_in_sector(const view_limits *l, const double step[2], double slack) {
    const double room = slack * (fabs(step[0]) + fabs(step[1]));
    const bool after = to_the_right(l->sector[0], step) >= -room, before = to_the_right(l->sector[1], step) <= room;
    if (!l->narrow) return after || before;
    /* Right of one line and left of the other is the sector, or all of a line if the two are the same. */
    const double(*s)[2] = l->sector;
    const bool ahead = s[0][0] * step[0] + s[0][1] * step[1] > 0 || s[1][0] * step[0] + s[1][1] * step[1] > 0;
    return after && before && ahead;
}

double cw_view_limits_angle(const view_limits *l, double i, double j, double rise) {
    double step[2];
    turn_to_metres(l, i - l->sight->eye[0], j - l->sight->eye[1], step);
    const double height = rise * terrain_metres_of_height(l->sight->terrain);
    return atan2(height, sqrt(step[0] * step[0] + step[1] * step[1])) / degree;
}

bool cw_view_limits_have(const view_limits *l, double i, double j, double rise) {
    if (!l->any) return true;
    const cw_observer *g = &l->given;
    double step[2];
    turn_to_metres(l, i - l->sight->eye[0], j - l->sight->eye[1], step);
    const double square = step[0] * step[0] + step[1] * step[1];
    if (g->farthest > 0 && !(square <= g->farthest * g->farthest)) return false;
    if (!(square >= g->nearest * g->nearest)) return false;
    if (l->has_sector && square > 0 && !is_in_sector(l, step, 0)) return false;
    if (!l->has_verticals) return true;
    if (square == 0) {
        const double angle = cw_view_limits_angle(l, i, j, rise);
        return angle >= g->verticals[0] && angle <= g->verticals[1];
    }
    const double distance = sqrt(square), height = rise * terrain_metres_of_height(l->sight->terrain);
    return height >= l->tangents[0] * distance && height <= l->tangents[1] * distance;
}

bool cw_view_limits_meet(const view_limits *l, const double a[2], const double b[2]) {
    /* Directions are rounded by less than 2^-50 of them. */
    const double slack = 0x1p-40;
    double ends[2][2];
    if (!l->has_sector) return true;
    turn_to_metres(l, a[0], a[1], ends[0]);
    turn_to_metres(l, b[0], b[1], ends[1]);
    if (is_in_sector(l, ends[0], slack) || is_in_sector(l, ends[1], slack)) return true;
    /* Else the sector is between the two, or beside them. */
    const double *first = l->sector[0], turn = to_the_right(ends[0], ends[1]) < 0 ? -1 : 1;
    const double ahead = (ends[0][0] + ends[1][0]) * first[0] + (ends[0][1] + ends[1][1]) * first[1];
    return turn * to_the_right(ends[0], first) >= 0 && turn * to_the_right(ends[1], first) <= 0 && ahead > 0;
}
