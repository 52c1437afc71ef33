/* SPDX-License-Identifier: Apache-2.0 */
/* Sums of products of doubles without any rounding, after Shewchuk (1997): a sum is kept as parts that
 * do not overlap, smallest first, so that its sign is that of the last part.
 *
 * Requires rounding to nearest, and that no product overflows or has bits below 2^-1022. */
#ifndef CELLWALK_TERRAIN_EXACT_H
#define CELLWALK_TERRAIN_EXACT_H

#include <math.h>

enum { EXACT_PARTS = 400 };

/* The parts that are not zero. */
typedef struct exact_sum {
    int count;
    double parts[EXACT_PARTS];
} exact_sum;

/* a + b as the rounded sum and its error. */
static inline double exact_two_sum(double a, double b, double *error) {
    const double sum = a + b, of_b = sum - a;
    *error = (a - (sum - of_b)) + (b - of_b);
    return sum;
}

/* Half of the bits of a double: products of halves are exact. */
static inline double exact_high(double a) {
    const double c = 134217729 * a; /* 2^27 + 1 */
    return c - (c - a);
}

static inline double exact_two_product(double a, double b, double *error) {
    const double product = a * b;
    const double high_a = exact_high(a), low_a = a - high_a, high_b = exact_high(b), low_b = b - high_b;
    *error = low_a * low_b - (((product - high_a * high_b) - low_a * high_b) - high_a * low_b);
    return product;
}

static inline void exact_add(exact_sum *s, double b) {
    int kept = 0;
    for (int k = 0; k < s->count; k++) {
        double error;
        b = exact_two_sum(b, s->parts[k], &error);
        if (error != 0) s->parts[kept++] = error;
    }
    if (b != 0) s->parts[kept++] = b;
    s->count = kept;
}

static inline void exact_add_product(exact_sum *s, double a, double b) {
    if (a == 0 || b == 0) return;
    double error;
    const double product = exact_two_product(a, b, &error);
    if (error != 0) exact_add(s, error);
    exact_add(s, product);
}

static inline int exact_sign(const exact_sum *s) { return s->count == 0 ? 0 : s->parts[s->count - 1] > 0 ? 1 : -1; }

/* The sum, rounded: off by less than 2^-51 of it. */
static inline double exact_value(const exact_sum *s) {
    double value = 0;
    for (int k = 0; k < s->count; k++) value += s->parts[k];
    return value;
}

#endif
