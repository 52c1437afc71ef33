/* SPDX-License-Identifier: Apache-2.0 */
/* Is a hit within its bounds, decided in rational numbers: for the few that doubles cannot decide. */

#include "oracle_walk.h"

#include <math.h>

enum { X, Y, Z, H00, H10, H01, H11, D, TERM, NUMBERS };

/* a + b c */
static void add_product(mpq_t a, const mpq_t b, const mpq_t c, mpq_t term) {
    mpq_mul(term, b, c);
    mpq_add(a, a, term);
}

/* A hole becomes 0: it is a sample of the cell's other triangle. */
static void set_sample(mpq_t z, const oracle *o, int32_t i, int32_t j) {
    const double sample = (double)o->z[(size_t)j * o->nx + (size_t)i];
    mpq_set_d(z, isfinite(sample) ? sample : 0);
}

/* x and y within the cell, z above its sample (i, j), of the ray at t. */
static void place_at(mpq_t n[NUMBERS], const oracle *o, const oracle_triangle *t, double at) {
    const double org[3] = {o->ox, o->oy, o->oz}, dir[3] = {o->dx, o->dy, o->dz};
    mpq_set_d(n[TERM], at);
    for (int c = 0; c < 3; c++) {
        mpq_set_d(n[X + c], org[c]);
        mpq_set_d(n[D], dir[c]);
        mpq_mul(n[D], n[D], n[TERM]);
        mpq_add(n[X + c], n[X + c], n[D]);
    }
    mpq_set_si(n[D], t->i, 1);
    mpq_sub(n[X], n[X], n[D]);
    mpq_set_si(n[D], t->j, 1);
    mpq_sub(n[Y], n[Y], n[D]);
}

/* a <= b */
static bool at_most(const mpq_t a, double b, mpq_t term) {
    mpq_set_d(term, b);
    return mpq_cmp(a, term) <= 0;
}

/* a >= least */
static bool above(const mpq_t a, double least, mpq_t term) {
    mpq_set_d(term, least);
    return mpq_cmp(a, term) >= 0;
}

bool oracle_exactly_within(const oracle *o, const oracle_triangle *t, double at, double height, double place) {
    mpq_t n[NUMBERS];
    for (int k = 0; k < NUMBERS; k++) mpq_init(n[k]);
    const bool a = t->triangle == CW_TRIANGLE_A;
    set_sample(n[H00], o, t->i, t->j);
    set_sample(n[H10], o, t->i + 1, t->j);
    set_sample(n[H01], o, t->i, t->j + 1);
    set_sample(n[H11], o, t->i + 1, t->j + 1);
    place_at(n, o, t, at);
    /* Rises along x and y: A goes by (i + 1, j), B by (i, j + 1). */
    mpq_sub(n[Z], n[Z], n[H00]);
    mpq_sub(n[D], a ? n[H00] : n[H01], a ? n[H10] : n[H11]);
    add_product(n[Z], n[D], n[X], n[TERM]);
    mpq_sub(n[D], a ? n[H10] : n[H00], a ? n[H11] : n[H01]);
    add_product(n[Z], n[D], n[Y], n[TERM]);
    mpq_abs(n[Z], n[Z]);
    bool within = at_most(n[Z], height, n[TERM]);
    /* 0 <= y <= x <= 1 in A, 0 <= x <= y <= 1 in B. */
    mpq_sub(n[D], a ? n[X] : n[Y], a ? n[Y] : n[X]);
    within = within && above(n[D], -place, n[TERM]) && above(a ? n[Y] : n[X], -place, n[TERM]);
    mpq_set_si(n[H00], 1, 1);
    mpq_sub(n[D], a ? n[X] : n[Y], n[H00]);
    within = within && at_most(n[D], place, n[TERM]);
    for (int k = 0; k < NUMBERS; k++) mpq_clear(n[k]);
    return within;
}
