/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of cellwalk_terrain.h for library.c, and those inside of src/terrain that tests call. */
#ifndef CELLWALK_TESTS_LIBRARY_TERRAIN_H
#define CELLWALK_TESTS_LIBRARY_TERRAIN_H

#include "cellwalk_terrain.h"
#include "compass.h"
#include "insolation.h"
#include "profile.h"
#include "skyline.h"
#include "visible.h"

/* ---- of a row of numbers, a row of others ------------------------------------------------------------------------ */

typedef void look(const terrain *t, const double *row, double *to);

static void look_at_each(look *at, const terrain *t, size_t in, const double *rows, size_t n, size_t out, double *to) {
    for (size_t k = 0; k < n; k++) at(t, rows + k * in, to + k * out);
}

/* Column, row, azimuth: metres in one of x and y there, a step that way and its length, sine, cosine, height. */
static void look_at_place(const terrain *t, const double *d, double *to) {
    cw_terrain_metres(t, d[0], d[1], to);
    to[4] = cw_terrain_direction(t, d[0], d[1], d[2], to + 2);
    cw_terrain_sine_cosine(d[2], to + 5, to + 6);
    to[7] = cw_terrain_height(t, d[0], d[1]);
}
static void look_at_sun(const terrain *t, const double *d, double *to) { /* seconds, longitude, latitude */
    const sun_position p = cw_sun_at(d[0], d[1], d[2]);
    memcpy(to, &p, sizeof p);
}
static void look_at_sky(const terrain *t, const double *d, double *to) { /* linke, distance, altitude, height */
    to[0] = cw_clear_sky_air_mass(d[2], d[3]);
    to[1] = cw_clear_sky_direct(d[0], d[1], d[2], d[3]);
    to[2] = cw_clear_sky_diffuse(d[0], d[1], d[2]);
}
static void look_up(const terrain *t, const double *d, double *to) { *to = (double)cw_horizon_degrees((float)*d); }
/* Eye, curvature, place of the target, its height, more over that: the first block, whether it is seen, what is needed,
 * the steepest rise. */
static void look_along(const terrain *t, const double *d, double *to) {
    const sight_bounds *bounds;
    sight s;
    stop_unless(cw_terrain_bounds(t, &bounds) == CW_OK, "bounds");
    cw_sight_init(&s, t, bounds, d, d[3]);
    to[0] = cw_sight_first_block(&s, d[4], d[5], d[6]);
    to[1] = cw_sight_sees(&s, d[4], d[5], d[6], d[7], (sight_parts){INFINITY, true});
    to[2] = cw_sight_need(&s, d[4], d[5], d[6], -INFINITY);
    to[3] = cw_sight_steepest(&s, d[4], d[5], -INFINITY).steepest;
    cw_terrain_bounds_release(t, bounds);
}
/* 0: a new skyline; says of how many pieces the one before was. 1: an edge from (u, w) to (u, w) is added, from the
 * last piece on that begins before a place, sought from the last such piece on or anew; says whether who has found a
 * piece behind the edge finds on from it. 2: looks in a direction, from the last look on or anew. 3: the least between
 * two directions. 4: looks closely in a direction; infinite where that is not enough. */
static void look_at_skyline(const terrain *t, const double *d, double *to) {
    static skyline line;
    static uint32_t at, before;
    if (d[0] == 0) {
        to[0] = line.count;
        cw_skyline_free(&line);
        stop_unless(cw_skyline_init(&line, -1, 1), "skyline");
    } else if (d[0] == 1) {
        const double far = fmax(d[1], d[3]) + 0.05;
        before = skyline_find(&line, d[5] != 0 ? before : SKYLINE_FIRST, d[6]);
        const uint32_t behind = skyline_find(&line, before, far);
        cw_skyline_add(&line, before, d + 1, d + 3);
        stop_unless(!line.failed, "skyline");
        to[0] = line.pieces[behind].from > far ||
                skyline_find(&line, behind, far) == skyline_find(&line, SKYLINE_FIRST, far);
    } else if (d[0] == 2) {
        at = d[2] != 0 ? at : SKYLINE_FIRST;
        skyline_at(&line, &at, d[1], to, to + 1);
    } else if (d[0] == 3) {
        to[0] = cw_skyline_least(&line, SKYLINE_FIRST, d[1], d[2]);
    } else {
        double doubt;
        at = skyline_find(&line, SKYLINE_FIRST, d[1] - SKYLINE_BLUR);
        if (!skyline_at_closely(&line, at, d[1], to, to + 1, &doubt)) doubt = INFINITY;
        to[0] = doubt < INFINITY ? to[0] - doubt : -INFINITY;
        to[1] = doubt < INFINITY ? to[1] + doubt : INFINITY;
    }
}

/* ---- functions --------------------------------------------------------------------------------------------------- */

#define D(k)                      v[k].d
#define AREA(k)                   *(const cw_area *)v[k].p
#define PRODUCT(NAME)             X(NAME, status(NAME(P(0), P(1), P(2), AREA(3), P(4))))
#define LOOKS(NAME, LOOK, IN, TO) X(NAME, look_at_each(LOOK, P(0), IN, P(1), N(2), TO, P(3)))
#define TERRAIN_FUNCTIONS                                                                                              \
    X(cw_field_coarser, status(cw_field_coarser(P(0), P(1), N(2), (int32_t)N(3), P(4), P(5), N(6))))                   \
    X(cw_terrain_create, status(cw_terrain_create(P(0), P(1), P(2))))                                                  \
    X(cw_terrain_destroy, cw_terrain_destroy(P(0)))                                                                    \
    PRODUCT(cw_shadow)                                                                                                 \
    PRODUCT(cw_sunlight)                                                                                               \
    X(cw_horizon_azimuths, status(cw_horizon_azimuths(P(0), P(1), P(2))))                                              \
    X(cw_horizon_angles, status(cw_horizon_angles(P(0), P(1), P(2), U(3), AREA(4), P(5), P(6))))                       \
    PRODUCT(cw_sky_view)                                                                                               \
    PRODUCT(cw_openness)                                                                                               \
    PRODUCT(cw_viewshed)                                                                                               \
    PRODUCT(cw_visibility)                                                                                             \
    X(cw_lines_of_sight, status(cw_lines_of_sight(P(0), P(1), D(2), P(3), N(4), P(5))))                                \
    X(cw_insolation_create, status(cw_insolation_create(P(0), P(1), P(2))))                                            \
    X(cw_insolation_destroy, cw_insolation_destroy(P(0)))                                                              \
    X(cw_insolation_hours, status(cw_insolation_hours(P(0), P(1), AREA(2), P(3))))                                     \
    X(cw_insolation_direct, status(cw_insolation_direct(P(0), P(1), AREA(2), P(3))))                                   \
    X(cw_insolation_diffuse, fprintf(answer, "%a", cw_insolation_diffuse(P(0))))                                       \
    X(cw_sun_parse_time, number(cw_sun_parse_time(P(0), P(1))))                                                        \
    X(cw_visible_create, status(cw_visible_create(P(0), AT(1), N(2), P(3))))                                           \
    X(cw_visible_destroy, cw_visible_destroy(P(0)))                                                                    \
    X(cw_visible_add, status(cw_visible_add(P(0), P(1), P(2), N(3), N(4), (cw_visible_sums){P(5), P(6), P(7)})))       \
    X(cw_terrain_bounds, status(cw_terrain_bounds(P(0), P(1))))                                                        \
    X(cw_terrain_bounds_release, cw_terrain_bounds_release(P(0), P(1)))                                                \
    X(cw_viewshed_from, status(cw_viewshed_from(P(0), P(1), P(2), AREA(3), P(4))))                                     \
    X(cw_sight_init, cw_sight_init(P(0), P(1), P(2), P(3), D(4)))                                                      \
    X(cw_profile_make, status(cw_profile_make(P(0), P(1), D(2), D(3), D(4))))                                          \
    X(cw_profile_free, cw_profile_free(P(0)))                                                                          \
    LOOKS(places, look_at_place, 3, 8)                                                                                 \
    LOOKS(suns, look_at_sun, 3, 5)                                                                                     \
    LOOKS(skies, look_at_sky, 4, 3)                                                                                    \
    LOOKS(degrees, look_up, 1, 1)                                                                                      \
    LOOKS(sights, look_along, 8, 4)                                                                                    \
    LOOKS(skyline, look_at_skyline, 7, 2)

#endif
