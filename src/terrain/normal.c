/* SPDX-License-Identifier: Apache-2.0 */
#include "terrain.h"

#include "cellwalk_expert.h"

#include <math.h>

/* Each triangle of the grid covers the same half cell, so the area-weighted mean of normals (-x, -y, 1) is the mean of
 * the leans. */
static void find_lean(const terrain *t, size_t i, size_t j, double lean[2]) {
    /* The six triangles, each by the sample that it has beside (i, j) and the next one round the clock. */
    static const int around[7][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, 0}};
    double sum[2] = {0, 0}, count = 0;
    for (int k = 0; k < 6; k++) {
        double h[2];
        for (int m = 0; m < 2; m++) {
            const size_t x = i + (size_t)around[k + m][0], y = j + (size_t)around[k + m][1]; /* below 0 wraps */
            h[m] = x < t->nx && y < t->ny ? (double)terrain_row(t, y)[x] - (double)terrain_row(t, j)[i] : NAN;
        }
        if (!isfinite(h[0] + h[1])) continue;
        /* (x, y) with x a + y b = h for both of the sides (a, b), whose determinant is 1. */
        const double a0 = around[k][0], b0 = around[k][1], a1 = around[k + 1][0], b1 = around[k + 1][1];
        sum[0] += h[0] * b1 - h[1] * b0;
        sum[1] += a0 * h[1] - a1 * h[0];
        count++;
    }
    lean[0] = count > 0 ? sum[0] / count : NAN;
    lean[1] = count > 0 ? sum[1] / count : NAN;
}

/* Rise of the surface in a cell along i and j, in the samples' numbers. */
static void find_leans(const terrain *t, size_t j, size_t from, size_t count, float *restrict x, float *restrict y) {
    const size_t end = from + count;
    const bool inside = j > 0 && j + 1 < t->ny;
    if (inside) {
        /* The same with all six there: sums of differences along the hexagon around the sample. */
        const float *restrict here = terrain_row(t, j), *restrict below = terrain_row(t, j - 1),
                              *restrict above = terrain_row(t, j + 1);
        for (size_t i = from > 0 ? from : 1; i < end && i + 1 < t->nx; i++) {
            const float east = here[i + 1], west = here[i - 1], ahead = above[i + 1], back = below[i - 1];
            x[i - from] = (2 * (east - west) + (ahead - above[i]) + (below[i] - back)) / 6;
            y[i - from] = (2 * (above[i] - below[i]) + (ahead - east) + (west - back)) / 6;
        }
    }
    for (size_t i = from; i < end; i++) {
        if (inside && i > 0 && i + 1 < t->nx && isfinite(x[i - from] + y[i - from])) continue;
        double lean[2];
        find_lean(t, i, j, lean);
        x[i - from] = (float)lean[0];
        y[i - from] = (float)lean[1];
    }
}

typedef struct slopes {
    const terrain *terrain;
    double row;
    cw_rectangle at;
    float *east, *north;
} slopes;

static void find_rows(void *context, size_t begin, size_t end) {
    const slopes *s = context;
    const terrain *t = s->terrain, *whole = terrain_whole(t);
    const size_t nx = s->at.nx;
    for (size_t y = begin; y < end; y++) {
        const size_t j = s->at.j + y;
        float *restrict east = s->east + y * nx, *restrict north = s->north + y * nx;
        double metres[2];
        cw_terrain_metres(whole, 0.5 * (double)(whole->nx - 1), isnan(s->row) ? (double)(j + t->row) : s->row, metres);
        float to_east[2], to_north[2];
        for (int k = 0; k < 2; k++) {
            to_east[k] = (float)(t->back[k][0] * t->map[2][2] / metres[0]);
            to_north[k] = (float)(t->back[k][1] * t->map[2][2] / metres[1]);
        }
        find_leans(t, j, s->at.i, nx, east, north);
        for (size_t i = 0; i < nx; i++) {
            const float a = east[i], b = north[i];
            east[i] = a * to_east[0] + b * to_east[1];
            north[i] = a * to_north[0] + b * to_north[1];
        }
    }
}

void cw_terrain_slopes(const terrain *t, cw_pool *pool, double row, cw_rectangle at, float *east, float *north) {
    enum { ROWS = 4 };
    slopes s = {t, row, at, east, north};
    cw_pool_run(pool, at.ny, ROWS, find_rows, &s);
}
