/* SPDX-License-Identifier: Apache-2.0 */
#include "exact.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* value = whole · 2^exponent, whole odd or at most 24 bits long; false for zero. */
static bool split(float value, long *whole, int *exponent) {
    if (value == 0) return false;
    *whole = (long)ldexpf(frexpf(value, exponent), 24);
    *exponent -= 24;
    while (*whole % 2 == 0) {
        *whole /= 2;
        ++*exponent;
    }
    return true;
}

static void lower_exponent(float value, int *lowest) {
    long whole;
    int exponent;
    if (isfinite(value) && split(value, &whole, &exponent) && exponent < *lowest) *lowest = exponent;
}

/* value / 2^scale, which is whole. */
static void load(mpz_t to, float value, long scale) {
    long whole;
    int exponent;
    mpz_set_si(to, 0);
    if (!split(value, &whole, &exponent)) return;
    mpz_set_si(to, whole);
    mpz_mul_2exp(to, to, (unsigned long)(exponent - scale));
}

void exact_init(exact *e, const float *samples, size_t n) {
    e->ready = false;
    e->field_exponent = 0;
    for (size_t k = 0; k < n; k++) lower_exponent(samples[k], &e->field_exponent);
    mpz_inits(e->ox, e->oy, e->dx, e->dy, e->oz, e->dz, e->num_a, e->den_a, e->num_b, e->den_b, e->h, e->ha, e->hb,
              e->x, e->y, e->z, e->sum, (mpz_ptr)NULL);
}

void exact_clear(exact *e) {
    mpz_clears(e->ox, e->oy, e->dx, e->dy, e->oz, e->dz, e->num_a, e->den_a, e->num_b, e->den_b, e->h, e->ha, e->hb,
               e->x, e->y, e->z, e->sum, (mpz_ptr)NULL);
}

void exact_ray(exact *e, const cw_ray *ray) {
    e->ray = ray;
    e->ready = false;
}

/* Most rays never need this. */
static void make_ready(exact *e) {
    if (e->ready) return;
    const cw_ray *r = e->ray;
    int plane = 0, height = e->field_exponent;
    for (int c = 0; c < 2; c++) {
        lower_exponent(r->org[c], &plane);
        lower_exponent(r->dir[c], &plane);
    }
    lower_exponent(r->org[2], &height);
    lower_exponent(r->dir[2], &height);
    e->plane_scale = plane;
    e->height_scale = height;
    load(e->ox, r->org[0], plane);
    load(e->oy, r->org[1], plane);
    load(e->dx, r->dir[0], plane);
    load(e->dy, r->dir[1], plane);
    load(e->oz, r->org[2], height);
    load(e->dz, r->dir[2], height);
    e->ready = true;
}

/* to += number cells, in units of the plane. */
static void add_cells(exact *e, mpz_t to, long number) {
    mpz_set_si(e->sum, number);
    mpz_mul_2exp(e->sum, e->sum, (unsigned long)-e->plane_scale);
    mpz_add(to, to, e->sum);
}

/* t = num / den, den > 0. */
static void ratio(exact *e, const crossing *at, mpz_t num, mpz_t den) {
    long whole = 0;
    int exponent = 0;
    switch (at->kind) {
    case CROSSING_X:
        mpz_neg(num, e->ox);
        mpz_set(den, e->dx);
        break;
    case CROSSING_Y:
        mpz_neg(num, e->oy);
        mpz_set(den, e->dy);
        break;
    case CROSSING_DIAGONAL:
        mpz_sub(num, e->oy, e->ox);
        mpz_sub(den, e->dx, e->dy);
        break;
    case CROSSING_CONSTANT:
        split(at->constant, &whole, &exponent);
        mpz_set_si(num, whole);
        mpz_set_si(den, 1);
        mpz_mul_2exp(exponent > 0 ? num : den, exponent > 0 ? num : den, (unsigned long)labs((long)exponent));
        return;
    }
    add_cells(e, num, at->number);
    if (mpz_sgn(den) < 0) {
        mpz_neg(num, num);
        mpz_neg(den, den);
    }
}

int exact_order(exact *e, const crossing *a, const crossing *b) {
    make_ready(e);
    ratio(e, a, e->num_a, e->den_a);
    ratio(e, b, e->num_b, e->den_b);
    mpz_mul(e->num_a, e->num_a, e->den_b);
    mpz_mul(e->num_b, e->num_b, e->den_a);
    return mpz_cmp(e->num_a, e->num_b);
}

static double quotient(const mpz_t num, const mpz_t den) {
    long num_exponent, den_exponent;
    const double n = mpz_get_d_2exp(&num_exponent, num), d = mpz_get_d_2exp(&den_exponent, den);
    return ldexp(n / d, (int)(num_exponent - den_exponent));
}

double exact_value(exact *e, const crossing *at) {
    if (at->error <= 0x1p-50 * fabs(at->t)) return at->t;
    make_ready(e);
    ratio(e, at, e->num_a, e->den_a);
    return quotient(e->num_a, e->den_a);
}

static void load_plane(exact *e, const exact_plane *p) {
    load(e->h, p->h, e->height_scale);
    load(e->ha, p->a1, e->height_scale);
    load(e->sum, p->a0, e->height_scale);
    mpz_sub(e->ha, e->ha, e->sum);
    load(e->hb, p->b1, e->height_scale);
    load(e->sum, p->b0, e->height_scale);
    mpz_sub(e->hb, e->hb, e->sum);
}

int exact_side(exact *e, const crossing *at, const exact_plane *p) {
    make_ready(e);
    load_plane(e, p);
    ratio(e, at, e->num_a, e->den_a);
    /* All times den: place within the cell, height above h. */
    mpz_set(e->x, e->ox);
    add_cells(e, e->x, -(long)p->i);
    mpz_mul(e->x, e->x, e->den_a);
    mpz_addmul(e->x, e->num_a, e->dx);
    mpz_set(e->y, e->oy);
    add_cells(e, e->y, -(long)p->j);
    mpz_mul(e->y, e->y, e->den_a);
    mpz_addmul(e->y, e->num_a, e->dy);
    mpz_sub(e->z, e->oz, e->h);
    mpz_mul(e->z, e->z, e->den_a);
    mpz_addmul(e->z, e->num_a, e->dz);
    /* All times one cell. */
    mpz_mul_2exp(e->z, e->z, (unsigned long)-e->plane_scale);
    mpz_submul(e->z, e->ha, e->x);
    mpz_submul(e->z, e->hb, e->y);
    return mpz_sgn(e->z);
}

double exact_meet(exact *e, const exact_plane *p) {
    make_ready(e);
    load_plane(e, p);
    mpz_set(e->x, e->ox);
    add_cells(e, e->x, -(long)p->i);
    mpz_set(e->y, e->oy);
    add_cells(e, e->y, -(long)p->j);
    mpz_sub(e->num_a, e->h, e->oz);
    mpz_mul_2exp(e->num_a, e->num_a, (unsigned long)-e->plane_scale);
    mpz_addmul(e->num_a, e->ha, e->x);
    mpz_addmul(e->num_a, e->hb, e->y);
    mpz_mul_2exp(e->den_a, e->dz, (unsigned long)-e->plane_scale);
    mpz_submul(e->den_a, e->ha, e->dx);
    mpz_submul(e->den_a, e->hb, e->dy);
    return quotient(e->num_a, e->den_a);
}

bool exact_diagonal(exact *e, int32_t *floor) {
    make_ready(e);
    mpz_sub(e->x, e->ox, e->oy);
    const bool whole = mpz_divisible_2exp_p(e->x, (unsigned long)-e->plane_scale) != 0;
    mpz_fdiv_q_2exp(e->x, e->x, (unsigned long)-e->plane_scale);
    *floor = mpz_fits_sint_p(e->x) ? (int32_t)mpz_get_si(e->x) : INT_MIN;
    return whole;
}
