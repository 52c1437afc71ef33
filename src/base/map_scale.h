/* SPDX-License-Identifier: Apache-2.0 */
/* Metres of ground in one of a map's x and y, over a raster on a projected map: the projection's point scale.
 *
 * Nodes stand at equal distances over the raster, the first and the last ones at its corner samples. Between them the
 * scale is interpolated by cubics. With h the distance of two nodes, that is off by at most h^4 / 24 of the fourth
 * derivative. For Mercator's 1 / cosh(y / R), whose fourth derivative is at most 5 / R^4, it is 2e-5 for a raster of
 * the whole world and 1e-8 for one of 5000 km. */
#ifndef CELLWALK_BASE_MAP_SCALE_H
#define CELLWALK_BASE_MAP_SCALE_H

#include <stddef.h>

enum { MAP_SCALE_ROWS = 65, MAP_SCALE_COLUMNS = 9 };

typedef struct map_scale {
    double metres[MAP_SCALE_ROWS][MAP_SCALE_COLUMNS][2];
} map_scale;

/* Number of the first of the four nodes around the place `at`, of 0 to last, and their weights. */
static inline size_t map_scale_nodes(double at, double last, size_t nodes, double weights[4]) {
    const double place = (at > 0 ? at < last ? at : last : 0) / last * (double)(nodes - 1);
    size_t first = place > 1 ? (size_t)place - 1 : 0;
    if (first > nodes - 4) first = nodes - 4;
    const double x = place - (double)first, a = x - 1, b = x - 2, c = x - 3;
    weights[0] = -a * b * c / 6;
    weights[1] = x * b * c / 2;
    weights[2] = -x * a * c / 2;
    weights[3] = x * a * b / 6;
    return first;
}

/* At sample (i, j) of nx × ny; beyond the raster as at its edge. */
static inline void map_scale_at(const map_scale *s, size_t nx, size_t ny, double i, double j, double metres[2]) {
    double along[4], down[4];
    const size_t u = map_scale_nodes(i, (double)(nx - 1), MAP_SCALE_COLUMNS, along);
    const size_t v = map_scale_nodes(j, (double)(ny - 1), MAP_SCALE_ROWS, down);
    metres[0] = metres[1] = 0;
    for (size_t y = 0; y < 4; y++)
        for (size_t x = 0; x < 4; x++)
            for (int k = 0; k < 2; k++) metres[k] += down[y] * along[x] * s->metres[v + y][u + x][k];
}

#endif
