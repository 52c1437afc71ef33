/* SPDX-License-Identifier: Apache-2.0 */
/* Terrains for tests: heights by a formula on 10 m cells with rows from north to south, or random ones on any map. */
#ifndef CELLWALK_TESTS_TERRAIN_GROUND_H
#define CELLWALK_TESTS_TERRAIN_GROUND_H

#include "cellwalk_terrain.h"
#include "check.h"
#include "sight.h"
#include "workload/random.h"

#include <math.h>
#include <stdlib.h>

enum { GROUND_CELL = 10 };

/* On the map x = 10 i, y = -10 j. */
static const double ground_map[3][4] = {{GROUND_CELL, 0, 0, 0}, {0, -GROUND_CELL, 0, 0}, {0, 0, 1, 0}};

static const double degree = 0.017453292519943295;

/* As usual; neither square nor in metres; turned; mirrored; in degrees. */
enum { GROUND_MAPS = 5 };
static const double ground_maps[GROUND_MAPS][3][4] = {
    {{10, 0, 0, 500}, {0, -10, 0, 900}, {0, 0, 1, 0}},      {{10, 0, 0, 0}, {0, -25, 0, 0}, {0, 0, 0.3048, 0}},
    {{8, 6, 0, 100}, {6, -8, 0, 100}, {0, 0, 1, 0}},        {{-5, 0, 0, 0}, {1, 5, 0, 0}, {0, 0, 1, 0}},
    {{0.0002, 0, 0, 7}, {0, -0.0001, 0, 47}, {0, 0, 1, 0}},
};

typedef struct ground {
    terrain terrain;
    float *z;
    cw_field *field;
    sight_bounds *bounds;
} ground;

/* Height in metres at x and y in metres of the map. */
typedef double ground_height(const double *shape, double x, double y);

static inline void ground_take(ground *g, size_t nx, size_t ny, float *z, const double map[3][4]) {
    cw_field_desc desc = {0};
    desc.samples = g->z = z;
    desc.nx = nx;
    desc.ny = ny;
    check_status(cw_field_create(&desc, NULL, &g->field), CW_OK);
    const bool in_degrees = map == ground_maps[GROUND_MAPS - 1];
    const terrain_desc t = {.field = g->field,
                            .nx = nx,
                            .ny = ny,
                            .z = z,
                            .map = map,
                            .geographic = in_degrees,
                            .unit = in_degrees ? degree : 0};
    assert_true(cw_terrain_init(&g->terrain, &t));
    check_status(cw_sight_bounds_create(&g->terrain, &g->bounds), CW_OK);
}

static inline void ground_make(ground *g, size_t nx, size_t ny, ground_height *height, const double *shape) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++)
            z[j * nx + i] = (float)height(shape, GROUND_CELL * (double)i, -GROUND_CELL * (double)j);
    ground_take(g, nx, ny, z, ground_map);
}

static inline void ground_leave(const ground *g) {
    cw_sight_bounds_destroy(g->bounds);
    cw_field_destroy(g->field);
}

/* After samples of z have changed; on the map of ground_make. */
static inline void ground_change(ground *g) {
    ground_leave(g);
    ground_take(g, g->terrain.nx, g->terrain.ny, g->z, ground_map);
}

static inline void ground_free(ground *g) {
    ground_leave(g);
    free(g->z);
}

/* ---- formulas -------------------------------------------------------------------------------------------------------- */

/* shape: rise eastward and northward, height in the south-west corner. */
static inline double plane(const double *shape, double x, double y) { return shape[0] * x + shape[1] * y + shape[2]; }

/* shape: y, height: a wall from west to east on level ground. */
static inline double wall(const double *shape, double x, double y) {
    (void)x;
    return y == shape[0] ? shape[1] : 0;
}

/* shape: a number; others give other land. */
static inline double land(const double *shape, double x, double y) {
    const double s = shape[0];
    return 200 * sin(x / 310 + s) * cos(y / 270) + 60 * sin(x / 57 + 2 * s) * sin(y / 71 + s) +
           9 * sin(x / 13 + y / 17);
}

/* ---- random land ----------------------------------------------------------------------------------------------------- */

/* WRONG: numbers for no data that are taken for heights. */
typedef enum roughness { SMOOTH, ROUGH, HOLES, SPIKES, WHOLE, WRONG, ROUGHNESSES } roughness;

static inline void ground_rough(ground *g, size_t nx, size_t ny, roughness rough, random_state *r,
                                const double map[3][4]) {
    float *z = malloc(nx * ny * sizeof *z);
    assert_non_null(z);
    const double a = random_between(r, 3, 9), b = random_between(r, 3, 9);
    for (size_t k = 0; k < nx * ny; k++) {
        const double x = (double)(k % nx), y = (double)(k / nx), wave = 20 * sin(x / a) * cos(y / b);
        z[k] = (float)(rough == SPIKES ? (random_below(r, 40) == 0 ? random_between(r, 0, 90) : 0)
                                       : wave + random_between(r, 0, rough == SMOOTH ? 1 : 15));
        if (rough == HOLES && random_below(r, 12) == 0) z[k] = NAN;
        if (rough == WHOLE) z[k] = rintf(0.2F * z[k]);
        if (rough == WRONG && random_below(r, 50) == 0) z[k] = random_below(r, 2) ? -32768 : -9999;
    }
    ground_take(g, nx, ny, z, map);
}

/* The azimuth of one of a horizon's directions, in degrees. */
static inline double azimuth_of(const ground *g, const cw_horizon *h, size_t number) {
    static double azimuths[360];
    assert_true(h->count <= 360);
    check_status(cw_horizon_azimuths(&g->terrain, h, azimuths), CW_OK);
    return azimuths[number];
}

#endif
