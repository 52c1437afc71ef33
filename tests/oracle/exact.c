/* SPDX-License-Identifier: Apache-2.0 */
/* What doubles cannot decide, in GMP's floating-point numbers. Products of three floats and sums of some of them lie
 * between 2^-447 and 2^400 in size, so 1024 bits hold them: nothing but a quotient is rounded. */
#include "oracle_walk.h"

#include <limits.h>

enum { RIGHT, RISE, RUN, NUM, DEN, OTHER_NUM, OTHER_DEN, D0, D1, X = D0, Y = D1 };

void exact_init(oracle *o) {
    for (int k = 0; k < EXACT_NUMBERS; k++) mpf_init2(o->number[k], 1024);
}

void exact_clear(oracle *o) {
    for (int k = 0; k < EXACT_NUMBERS; k++) mpf_clear(o->number[k]);
}

/* to = a - b */
static void set_difference(oracle *o, mpf_ptr to, double a, double b) {
    mpf_set_d(to, a);
    mpf_set_d(o->number[RIGHT], b);
    mpf_sub(to, to, o->number[RIGHT]);
}

/* to -= (a - b) (c - d) */
static void subtract_product(oracle *o, mpf_ptr to, double a, double b, double c, double d) {
    mpf_ptr rise = o->number[RISE], run = o->number[RUN];
    set_difference(o, rise, a, b);
    set_difference(o, run, c, d);
    mpf_mul(rise, rise, run);
    mpf_sub(to, to, rise);
}

/* t = num / den, den > 0. */
static void ratio(oracle *o, const crossing *at, mpf_ptr num, mpf_ptr den) {
    const bool y = at->kind == CROSSING_Y, diagonal = at->kind == CROSSING_DIAGONAL;
    if (at->kind == CROSSING_CONSTANT) {
        mpf_set_d(num, (double)at->constant);
        mpf_set_ui(den, 1);
        return;
    }
    set_difference(o, num, (double)at->number, y ? o->oy : o->ox);
    if (diagonal) {
        mpf_set_d(den, o->oy);
        mpf_add(num, num, den);
    }
    set_difference(o, den, y ? o->dy : o->dx, diagonal ? o->dy : 0);
    if (mpf_sgn(den) > 0) return;
    mpf_neg(num, num);
    mpf_neg(den, den);
}

int exact_order(oracle *o, const crossing *a, const crossing *b) {
    mpf_ptr num = o->number[NUM], den = o->number[DEN];
    ratio(o, a, num, o->number[OTHER_DEN]);
    ratio(o, b, o->number[OTHER_NUM], den);
    mpf_mul(num, num, den);
    mpf_mul(den, o->number[OTHER_NUM], o->number[OTHER_DEN]);
    return mpf_cmp(num, den);
}

static double quotient(mpf_ptr num, mpf_ptr den) {
    mpf_div(num, num, den);
    return mpf_get_d(num);
}

double exact_value(oracle *o, const crossing *at) {
    if (at->error <= 0x1p-50 * fabs(at->t)) return at->t;
    ratio(o, at, o->number[NUM], o->number[DEN]);
    return quotient(o->number[NUM], o->number[DEN]);
}

/* d(t) = D0 + D1 t above a triangle's plane. */
static void set_height(oracle *o, const oracle_triangle *t) {
    const plane p = oracle_plane(o, t);
    mpf_ptr d0 = o->number[D0], d1 = o->number[D1];
    set_difference(o, d0, o->oz, p.h);
    subtract_product(o, d0, p.a1, p.a0, o->ox, t->i);
    subtract_product(o, d0, p.b1, p.b0, o->oy, t->j);
    mpf_set_d(d1, o->dz);
    subtract_product(o, d1, p.a1, p.a0, o->dx, 0);
    subtract_product(o, d1, p.b1, p.b0, o->dy, 0);
}

int exact_side(oracle *o, const crossing *at, const oracle_triangle *t) {
    mpf_ptr d0 = o->number[D0], d1 = o->number[D1];
    set_height(o, t);
    ratio(o, at, o->number[NUM], o->number[DEN]);
    mpf_mul(d0, d0, o->number[DEN]);
    mpf_mul(d1, d1, o->number[NUM]);
    mpf_add(d0, d0, d1);
    return mpf_sgn(d0);
}

double exact_meet(oracle *o, const oracle_triangle *t) {
    set_height(o, t);
    mpf_neg(o->number[D0], o->number[D0]);
    return quotient(o->number[D0], o->number[D1]);
}

bool exact_diagonal(oracle *o, int32_t *floor) {
    mpf_ptr x = o->number[X];
    set_difference(o, x, o->ox, o->oy);
    const bool whole = mpf_integer_p(x) != 0;
    mpf_floor(x, x);
    *floor = mpf_fits_sint_p(x) ? (int32_t)mpf_get_si(x) : INT_MIN;
    return whole;
}

bool exact_within(oracle *o, const oracle_triangle *t, double at, double height, double place) {
    mpf_ptr d = o->number[D0], x = o->number[X], y = o->number[Y], time = o->number[NUM];
    set_height(o, t);
    mpf_set_d(time, at);
    mpf_mul(o->number[D1], o->number[D1], time);
    mpf_add(d, d, o->number[D1]);
    mpf_abs(d, d);
    if (mpf_cmp_d(d, height) > 0) return false;
    /* 0 <= y <= x <= 1 in A, 0 <= x <= y <= 1 in B. */
    set_difference(o, x, o->ox, t->i);
    subtract_product(o, x, 0, o->dx, at, 0);
    set_difference(o, y, o->oy, t->j);
    subtract_product(o, y, 0, o->dy, at, 0);
    if (t->triangle == CW_TRIANGLE_B) mpf_swap(x, y);
    if (mpf_cmp_d(y, -place) < 0) return false;
    mpf_sub(y, x, y);
    mpf_sub_ui(x, x, 1);
    return mpf_cmp_d(y, -place) >= 0 && mpf_cmp_d(x, place) <= 0;
}
