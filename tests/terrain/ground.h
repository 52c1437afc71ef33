/* SPDX-License-Identifier: Apache-2.0 */
/* Terrains for tests: heights by a formula, 10 m cells, rows from north to south. */
#ifndef CELLWALK_TESTS_TERRAIN_GROUND_H
#define CELLWALK_TESTS_TERRAIN_GROUND_H

#include "check.h"
#include "sight.h"

#include <math.h>
#include <stdlib.h>

enum { GROUND_CELL = 10 };

/* On the map x = 10 i, y = -10 j. */
static const double ground_map[3][4] = {{GROUND_CELL, 0, 0, 0}, {0, -GROUND_CELL, 0, 0}, {0, 0, 1, 0}};

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
    const terrain_desc t = {.field = g->field, .nx = nx, .ny = ny, .z = z, .map = map};
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

#endif
