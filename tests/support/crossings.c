/* SPDX-License-Identifier: Apache-2.0 */
#include "crossings.h"

#include "check.h"

#include <string.h>

typedef struct line {
    const test_field *field;
    const double *start, *dir;
    double drop, on_line; /* what beside() takes for 0 */
    crossing *to;
    size_t count;
} line;

static void add(line *l, double t, double rise, double most) {
    if (!(t > 1e-9)) return;
    check(l->count < CROSSINGS_MAX, "too many crossings");
    l->to[l->count++] = (crossing){t, rise / t - l->drop * t, most / t};
}

/* How far beside the line a place is, times the direction's length. With coordinates below 1024 rounding is below 2^-42 of that length, a
 * twentieth of on_line; a direction that is 2^-30 off a border is 90 times on_line beside it after a cell. */
static double beside(const line *l, double x, double y) {
    const double side = l->dir[0] * (y - l->start[1]) - l->dir[1] * (x - l->start[0]);
    return fabs(side) < l->on_line ? 0 : side;
}

static double along(const line *l, double x, double y) {
    const double *d = l->dir;
    return ((x - l->start[0]) * d[0] + (y - l->start[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
}

static double rise_to(const line *l, size_t x, size_t y) {
    return (double)l->field->z[y * l->field->nx + x] - l->start[2];
}

static void cross_edge(line *l, size_t x, size_t y, size_t u, size_t v) {
    const double ax = (double)x, ay = (double)y, bx = (double)u, by = (double)v;
    const double a = beside(l, ax, ay), b = beside(l, bx, by);
    if (u >= l->field->nx || v >= l->field->ny || a * b >= 0) return;
    const double f = a / (a - b), rise = rise_to(l, x, y), other = rise_to(l, u, v);
    add(l, along(l, ax + f * (bx - ax), ay + f * (by - ay)), rise + f * (other - rise), fmax(fabs(rise), fabs(other)));
}

static int by_distance(const void *a, const void *b) {
    const double s = ((const crossing *)a)->t, t = ((const crossing *)b)->t;
    return (s > t) - (s < t);
}

size_t crossings_find(const test_field *f, const double start[3], const double dir[2], double drop,
                      crossing to[CROSSINGS_MAX]) {
    line l = {f, start, dir, drop, 1e-11 * hypot(dir[0], dir[1]), to, 0};
    for (size_t y = 0; y < f->ny; y++) {
        size_t x = 0, until = f->nx;
        columns_near_line(start, dir, y, &x, &until);
        for (; x < until; x++) {
            const double rise = rise_to(&l, x, y);
            if (beside(&l, (double)x, (double)y) == 0) add(&l, along(&l, (double)x, (double)y), rise, fabs(rise));
            cross_edge(&l, x, y, x + 1, y);
            cross_edge(&l, x, y, x, y + 1);
            cross_edge(&l, x, y, x + 1, y + 1);
        }
    }
    qsort(to, l.count, sizeof *to, by_distance);
    return l.count;
}

void line_direction(random_state *r, size_t n, double dir[2]) {
    static const double exact[][2] = {
        {1, 0},   {0, 1},  {-1, 0},      {0, -1},       {1, 1},  {-1, -1}, {1, -1},  {-1, 1}, {2, 1},          {-1, 3},
        {-3, -1}, {3, -2}, {1, 0x1p-30}, {-0x1p-30, 1}, {-2, 1}, {1, -3},  {10, -9}, {-7, 8}, {1, 1 + 0x1p-30}};
    enum { EXACT = sizeof exact / sizeof exact[0] };
    if (n < EXACT) {
        memcpy(dir, exact[n], sizeof exact[0]);
        return;
    }
    const double angle = random_between(r, 0, 6.283185307179586), length = n % 2 ? 1 : random_between(r, 0.01, 100);
    dir[0] = length * cos(angle);
    dir[1] = length * sin(angle);
}
