/* SPDX-License-Identifier: Apache-2.0 */
/* Lines of sight by brute force, in double: for tests. */
#ifndef CELLWALK_TESTS_TERRAIN_BRUTE_SIGHT_H
#define CELLWALK_TESTS_TERRAIN_BRUTE_SIGHT_H

#include "columns.h"
#include "sight.h"

#include <math.h>

typedef struct brute_way {
    const sight *sight;
    double target[2];
    double steepest;
} brute_way;

static inline void brute_see(brute_way *w, double share, double height) {
    if (share > 1e-9 && share < 1 - 1e-9 && height / share > w->steepest) w->steepest = height / share;
}

static inline double brute_side(const brute_way *w, double x, double y) {
    const double *e = w->sight->eye;
    return (w->target[0] - e[0]) * (y - e[1]) - (w->target[1] - e[1]) * (x - e[0]);
}

static inline double brute_share(const brute_way *w, double x, double y) {
    const double *e = w->sight->eye, dx = w->target[0] - e[0], dy = w->target[1] - e[1];
    return ((x - e[0]) * dx + (y - e[1]) * dy) / (dx * dx + dy * dy);
}

static inline void brute_edge(brute_way *w, size_t i, size_t j, size_t di, size_t dj) {
    const terrain *t = w->sight->terrain;
    const double x = (double)i, y = (double)j;
    if (isnan(t->z[j * t->nx + i])) return;
    const double a = brute_side(w, x, y), height = cw_sight_sample(w->sight, i, j), close = 1e-9;
    if (fabs(a) < close) brute_see(w, brute_share(w, x, y), height);
    if (i + di >= t->nx || j + dj >= t->ny || isnan(t->z[(j + dj) * t->nx + i + di])) return;
    const double b = brute_side(w, x + (double)di, y + (double)dj), other = cw_sight_sample(w->sight, i + di, j + dj);
    if (a * b >= 0 || fabs(a) < close || fabs(b) < close) return;
    const double f = a / (a - b);
    brute_see(w, brute_share(w, x + f * (double)di, y + f * (double)dj), height + f * (other - height));
}

/* The steepest rise on the way from the eye to (i, j), both ends left out, by looking at every edge of the columns near the line. */
static inline double brute_steepest(const sight *s, double i, double j) {
    brute_way w = {s, {i, j}, -INFINITY};
    const double line[2] = {i - s->eye[0], j - s->eye[1]};
    for (size_t y = 0; y < s->terrain->ny; y++) {
        size_t x = 0, until = s->terrain->nx;
        columns_near_line(s->eye, line, y, &x, &until);
        for (; x < until; x++) {
            brute_edge(&w, x, y, 1, 0);
            brute_edge(&w, x, y, 0, 1);
            brute_edge(&w, x, y, 1, 1);
        }
    }
    return w.steepest;
}

#endif
