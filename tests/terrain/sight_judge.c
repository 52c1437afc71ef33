/* SPDX-License-Identifier: Apache-2.0 */
#include "crossings.h"
#include "sight_cases.h"

#include <gmp.h>

/* One line of sight, as rational numbers from the eye. */
typedef struct judge {
    const sight *sight;
    mpq_t x, y, top;              /* the target */
    mpq_t ax, ay, az, bx, by, bz; /* samples */
    mpq_t side, other, a, b, c, d;
    double place[2], rise; /* of the target, and how high it is over the eye */
    int highest;           /* 1: something is above the line, 0: something touches it, -1: neither */
} judge;

static void judge_each(judge *q, void (*each)(mpq_t)) {
    mpq_t *const all[] = {&q->x,  &q->y,    &q->top,   &q->ax, &q->ay, &q->az, &q->bx, &q->by,
                          &q->bz, &q->side, &q->other, &q->a,  &q->b,  &q->c,  &q->d};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) each(*all[k]);
}
static void each_init(mpq_t number) { mpq_init(number); }
static void each_clear(mpq_t number) { mpq_clear(number); }

static void set_difference(mpq_t out, double a, double b) {
    mpq_t second;
    mpq_init(second);
    mpq_set_d(out, a);
    mpq_set_d(second, b);
    mpq_sub(out, out, second);
    mpq_clear(second);
}

static void cross(judge *q, mpq_t out, mpq_t ax, mpq_t ay, mpq_t bx, mpq_t by) {
    mpq_mul(q->c, ax, by);
    mpq_mul(q->d, ay, bx);
    mpq_sub(out, q->c, q->d);
}

static void set_sample(judge *q, size_t i, size_t j, mpq_t x, mpq_t y, mpq_t z) {
    const sight *s = q->sight;
    set_difference(x, (double)i, s->eye[0]);
    set_difference(y, (double)j, s->eye[1]);
    set_difference(z, (double)s->terrain->z[j * s->terrain->nx + i], s->eye[2]);
    mpq_set_d(q->c, sight_fall(s, (double)i, (double)j));
    mpq_sub(z, z, q->c);
}

static void note(judge *q, int side) { q->highest = side > q->highest ? side : q->highest; }

/* The crossing at the place (a, b), of height c: if it is between the ends, on which side of the line it is. */
static void judge_place(judge *q) {
    const bool by_x = mpq_sgn(q->x) != 0;
    mpq_div(q->d, by_x ? q->a : q->b, by_x ? q->x : q->y);
    if (mpq_sgn(q->d) <= 0 || mpq_cmp_ui(q->d, 1, 1) >= 0) return;
    mpq_mul(q->d, q->d, q->top);
    const int side = mpq_cmp(q->c, q->d);
    note(q, (side > 0) - (side < 0));
}

static void judge_edge(judge *q, size_t i, size_t j, size_t di, size_t dj) {
    const terrain *t = q->sight->terrain;
    const double *e = q->sight->eye;
    if (i + di >= t->nx || j + dj >= t->ny) return;
    if (!isfinite(t->z[j * t->nx + i]) || !isfinite(t->z[(j + dj) * t->nx + i + di])) return;
    /* Most are on one side by far. */
    const double x = q->place[0] - e[0], y = q->place[1] - e[1];
    const double one = x * ((double)j - e[1]) - y * ((double)i - e[0]), two = one + x * (double)dj - y * (double)di;
    if ((one > 1e-3 && two > 1e-3) || (one < -1e-3 && two < -1e-3)) return;
    if (fabs(one) > 1e-3 &&
        fabs(two) > 1e-3) { /* heights are below 10^5: what is that far off the line is so for doubles too */
        const double f = one / (one - two), a = (double)i + f * (double)di - e[0],
                     b = (double)j + f * (double)dj - e[1];
        const double low = cw_sight_sample(q->sight, i, j), high = cw_sight_sample(q->sight, i + di, j + dj);
        const double way = (a * x + b * y) / (x * x + y * y), off = low + f * (high - low) - way * q->rise;
        if (way > 1e-3 && way < 1 - 1e-3 && fabs(off) > 1e-3) {
            note(q, off > 0 ? 1 : -1);
            return;
        }
    }
    set_sample(q, i, j, q->ax, q->ay, q->az);
    set_sample(q, i + di, j + dj, q->bx, q->by, q->bz);
    cross(q, q->side, q->x, q->y, q->ax, q->ay);
    cross(q, q->other, q->x, q->y, q->bx, q->by);
    if (mpq_sgn(q->side) * mpq_sgn(q->other) >= 0) return; /* samples are judged by themselves */
    mpq_sub(q->c, q->side, q->other);
    mpq_div(q->d, q->side, q->c); /* how far from a to b */
    mpq_t *const from[3] = {&q->ax, &q->ay, &q->az}, *const to[3] = {&q->bx, &q->by, &q->bz};
    for (int k = 0; k < 3; k++) {
        mpq_sub(*to[k], *to[k], *from[k]);
        mpq_mul(*to[k], *to[k], q->d);
        mpq_add(*to[k], *to[k], *from[k]);
    }
    mpq_set(q->a, q->bx);
    mpq_set(q->b, q->by);
    mpq_set(q->c, q->bz);
    judge_place(q);
}

static void judge_sample(judge *q, size_t i, size_t j) {
    const terrain *t = q->sight->terrain;
    const double *e = q->sight->eye, x = q->place[0] - e[0], y = q->place[1] - e[1];
    if (!isfinite(t->z[j * t->nx + i])) return;
    if (fabs(x * ((double)j - e[1]) - y * ((double)i - e[0])) > 1e-3) return;
    set_sample(q, i, j, q->ax, q->ay, q->az);
    cross(q, q->side, q->x, q->y, q->ax, q->ay);
    if (mpq_sgn(q->side) != 0) return;
    mpq_set(q->a, q->ax);
    mpq_set(q->b, q->ay);
    mpq_set(q->c, q->az);
    judge_place(q);
}

int judge_line(const sight *s, double i, double j, double z, double above) {
    judge q = {.sight = s, .place = {i, j}, .highest = -1};
    judge_each(&q, each_init);
    set_difference(q.x, i, s->eye[0]);
    set_difference(q.y, j, s->eye[1]);
    set_difference(q.top, z, s->eye[2]);
    mpq_set_d(q.c, above);
    mpq_add(q.top, q.top, q.c);
    mpq_set_d(q.c, sight_fall(s, i, j));
    mpq_sub(q.top, q.top, q.c);
    q.rise = mpq_get_d(q.top);
    const double line[2] = {i - s->eye[0], j - s->eye[1]};
    for (size_t y = 0; y < s->terrain->ny && q.highest < 1; y++) {
        size_t x = 0, until = s->terrain->nx;
        columns_near_line(s->eye, line, y, &x, &until);
        for (; x < until; x++) {
            judge_sample(&q, x, y);
            judge_edge(&q, x, y, 1, 0);
            judge_edge(&q, x, y, 0, 1);
            judge_edge(&q, x, y, 1, 1);
        }
    }
    judge_each(&q, each_clear);
    return q.highest;
}
